//! Sentences of a scan: head `SCAN`, steps `STEP`, drop `DROP`, and possible further steps `MAYBE`.

use super::fields::{Fields, ParseError};
use super::frame::{Line, Tenths};
use super::writer::Writer;
use crate::answer::{Direction, DropEdge, PossibleStep, Slope, Step};
use crate::config::Plane;
use crate::verdict::{Outcome, Reasons, Status};

/// Content of the sentence `STEP`: one step of a scan's answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepLine {
    /// Number of the scan.
    pub scan: u32,
    /// Index of the step, from 1.
    pub index: u8,
    /// Number of steps in the scan's answer.
    pub count: u8,
    /// Horizontal distance from the mirror's centre to the step's foremost edge, 0.1 mm; negative behind the
    /// mirror.
    pub distance: Tenths,
    /// Height of the step's tread above the ground, 0.1 mm; negative going down.
    pub height: Tenths,
    /// Depth of the step's tread up to the next step's edge, 0.1 mm; `None` for the last step.
    pub tread: Option<Tenths>,
    /// Height of the step's riser over the tread before (or the ground), 0.1 mm; `None` where the height of that is not
    /// known.
    pub riser: Option<Tenths>,
    /// Standard deviation of the step's distance, 0.1 mm.
    pub distance_sigma: Tenths,
    /// Standard deviation of the step's height, 0.1 mm.
    pub height_sigma: Tenths,
    /// Detection quality: share of the step's expected features that are detected, per cent.
    pub quality: u8,
}

impl StepLine {
    /// Creates the sentence of `step`, number `index` (from 1) of `count` steps of scan number `scan`.
    pub fn new(scan: u32, index: u8, count: u8, step: &Step) -> Self {
        Self {
            scan,
            index,
            count,
            distance: Tenths::from_metres(step.distance_m),
            height: Tenths::from_metres(step.height_m),
            tread: step.tread_m.map(Tenths::from_metres),
            riser: step.riser_m.map(Tenths::from_metres),
            distance_sigma: Tenths::from_metres(step.distance_sigma_m),
            height_sigma: Tenths::from_metres(step.height_sigma_m),
            quality: step.quality.min(100),
        }
    }

    /// Returns the sentence, with its CRC and line end.
    pub(super) fn write(&self) -> Line {
        Writer::new("STEP")
            .number(self.scan)
            .number(u32::from(self.index))
            .number(u32::from(self.count))
            .length(Some(self.distance))
            .length(Some(self.height))
            .length(self.tread)
            .length(self.riser)
            .length(Some(self.distance_sigma))
            .length(Some(self.height_sigma))
            .number(u32::from(self.quality))
            .finish()
    }

    /// Parses the fields of a sentence after its name `STEP`.
    pub(super) fn parse(fields: &mut Fields<'_>) -> Result<Self, ParseError> {
        let absent = |field| move |value: Option<Tenths>| value.ok_or(ParseError::Field(field));
        Ok(Self {
            scan: fields.number("scan")?,
            index: fields.number("index")?,
            count: fields.number("count")?,
            distance: fields.length("distance").and_then(absent("distance"))?,
            height: fields.length("height").and_then(absent("height"))?,
            tread: fields.length("tread")?,
            riser: fields.length("riser")?,
            distance_sigma: fields
                .length("distance-sigma")
                .and_then(absent("distance-sigma"))?,
            height_sigma: fields
                .length("height-sigma")
                .and_then(absent("height-sigma"))?,
            quality: fields.number("quality")?,
        })
    }
}

/// Content of the sentence `SCAN`, the head of a scan's answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScanLine {
    /// Number of the scan since boot, from 1; 0 for a failed self-test.
    pub scan: u32,
    /// Status of the answer: `ok`, `degraded` or `fault`.
    pub status: Status,
    /// Direction of the stairs: none, up or down.
    pub direction: Direction,
    /// Number of `STEP` sentences that follow.
    pub steps: u8,
    /// Number of rows whose chirp was lost.
    pub lost_rows: u16,
    /// Reasons why the answer is not `ok`, and limitations of an `ok` answer.
    pub reasons: Reasons,
    /// Horizon, the distance from the mirror up to which the answer is valid, 0.1 mm; `None` in a fault, or
    /// without an estimate.
    pub horizon: Option<Tenths>,
    /// Confidence: probability that the answer is right up to the horizon, or over the first metre if that is
    /// farther, tenths of a per cent; `None` in a fault, or without an estimate.
    pub confidence: Option<u16>,
    /// Number of `MAYBE` sentences that follow.
    pub possible_steps: u8,
    /// [`Settings::hash`](crate::scanner::Settings::hash) of the scan's settings.
    pub settings: u32,
    /// Number of `DROP` sentences that follow: 0 or 1.
    pub drops: u8,
    /// Plane of the scan; `None`, and left out of the sentence, unless the scanner changes planes.
    pub plane: Option<Plane>,
    /// Slope of the ground; `None`, and left out of the sentence, where the ground is level or not seen to slope.
    pub ground: Option<SlopeField>,
}

/// Slope of the ground in the sentence `SCAN`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlopeField {
    /// Horizontal distance from the mirror's centre at which the slope begins, 0.1 mm; the ground is level before.
    pub from: Tenths,
    /// Rise per metre, 0.1 mm; negative going down.
    pub rise: Tenths,
}

impl SlopeField {
    fn new(ground: Slope) -> Self {
        Self {
            from: Tenths::from_metres(ground.from_m),
            rise: Tenths::from_metres(ground.slope),
        }
    }

    /// Returns the slope, distance in metres.
    pub fn slope(&self) -> Slope {
        Slope {
            from_m: self.from.metres(),
            slope: self.rise.metres(),
        }
    }
}

/// Content of the sentence `DROP`: the edge where the ground ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DropLine {
    /// Number of the scan.
    pub scan: u32,
    /// Horizontal distance from the mirror's centre to the edge where the ground ends, 0.1 mm.
    pub distance: Tenths,
    /// Standard deviation of the distance of the edge where the ground ends, 0.1 mm.
    pub distance_sigma: Tenths,
    /// Depth below the ground of the next surface behind the edge, 0.1 mm; `None` where it is not known.
    pub depth: Option<Tenths>,
    /// Probability that the ground ends at this edge, tenths of a per cent.
    pub probability: u16,
}

impl DropLine {
    /// Creates the sentence of `edge`, reported by scan number `scan`.
    pub fn new(scan: u32, edge: &DropEdge) -> Self {
        Self {
            scan,
            distance: Tenths::from_metres(edge.distance_m),
            distance_sigma: Tenths::from_metres(edge.distance_sigma_m),
            depth: edge.depth_m.map(Tenths::from_metres),
            probability: permille(edge.probability),
        }
    }

    /// Returns the edge where the ground ends, with lengths in metres and a probability from 0 to 1.
    pub fn edge(&self) -> DropEdge {
        DropEdge {
            distance_m: self.distance.metres(),
            distance_sigma_m: self.distance_sigma.metres(),
            depth_m: self.depth.map(Tenths::metres),
            probability: f32::from(self.probability) / 1000.0,
        }
    }

    /// Returns the sentence, with its CRC and line end.
    pub(super) fn write(&self) -> Line {
        Writer::new("DROP")
            .number(self.scan)
            .length(Some(self.distance))
            .length(Some(self.distance_sigma))
            .length(self.depth)
            .length(Some(Tenths(self.probability.into())))
            .finish()
    }

    /// Parses the fields of a sentence after its name `DROP`.
    pub(super) fn parse(fields: &mut Fields<'_>) -> Result<Self, ParseError> {
        let absent = |field| move |value: Option<Tenths>| value.ok_or(ParseError::Field(field));
        Ok(Self {
            scan: fields.number("scan")?,
            distance: fields.length("distance").and_then(absent("distance"))?,
            distance_sigma: fields
                .length("distance-sigma")
                .and_then(absent("distance-sigma"))?,
            depth: fields.length("depth")?,
            probability: parse_permille(fields, "probability")?
                .ok_or(ParseError::Field("probability"))?,
        })
    }
}

/// Content of the sentence `MAYBE`: a possible step or drop that the answer does not contain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MaybeLine {
    /// Number of the scan.
    pub scan: u32,
    /// Index of the possible step, from 1.
    pub index: u8,
    /// Number of `MAYBE` sentences of the scan.
    pub count: u8,
    /// Horizontal distance from the mirror's centre to the possible step, 0.1 mm.
    pub distance: Tenths,
    /// Height of the possible step's tread above the ground, 0.1 mm; negative where the ground may end.
    pub height: Tenths,
    /// Probability that the step or drop exists, tenths of a per cent.
    pub probability: u16,
}

impl MaybeLine {
    /// Creates the sentence of `maybe`, number `index` (from 1) of `count` possible steps of scan number `scan`.
    pub fn new(scan: u32, index: u8, count: u8, maybe: &PossibleStep) -> Self {
        Self {
            scan,
            index,
            count,
            distance: Tenths::from_metres(maybe.distance_m),
            height: Tenths::from_metres(maybe.height_m),
            probability: permille(maybe.probability),
        }
    }

    /// Returns the sentence, with its CRC and line end.
    pub(super) fn write(&self) -> Line {
        Writer::new("MAYBE")
            .number(self.scan)
            .number(u32::from(self.index))
            .number(u32::from(self.count))
            .length(Some(self.distance))
            .length(Some(self.height))
            .length(Some(Tenths(self.probability.into())))
            .finish()
    }

    /// Parses the fields of a sentence after its name `MAYBE`.
    pub(super) fn parse(fields: &mut Fields<'_>) -> Result<Self, ParseError> {
        let absent = |field| move |value: Option<Tenths>| value.ok_or(ParseError::Field(field));
        Ok(Self {
            scan: fields.number("scan")?,
            index: fields.number("index")?,
            count: fields.number("count")?,
            distance: fields.length("distance").and_then(absent("distance"))?,
            height: fields.length("height").and_then(absent("height"))?,
            probability: parse_permille(fields, "probability")?
                .ok_or(ParseError::Field("probability"))?,
        })
    }
}

/// Returns the probability `p`, from 0 to 1, in tenths of a per cent, rounded.
pub(super) fn permille(p: f32) -> u16 {
    ((1000.0 * p + 0.5) as u16).min(1000)
}

impl ScanLine {
    /// Returns the number of sentences of the same scan that follow this head.
    pub fn following(&self) -> u8 {
        let rest = self.drops.saturating_add(self.possible_steps);
        self.steps.saturating_add(rest)
    }

    /// Creates the head of the answer `outcome` to scan number `scan`; `settings` is the hash of the scan's
    /// settings.
    pub fn new(scan: u32, lost_rows: u16, outcome: &Outcome, settings: u32) -> Self {
        let reported = outcome.status() != Status::Fault;
        Self {
            scan,
            status: outcome.status(),
            direction: outcome.answer.direction,
            steps: if reported {
                outcome.answer.steps.len() as u8
            } else {
                0
            },
            lost_rows,
            reasons: outcome.reasons(),
            horizon: outcome
                .horizon_m()
                .filter(|_| reported)
                .map(Tenths::from_metres),
            confidence: outcome.confidence().filter(|_| reported).map(permille),
            possible_steps: if reported {
                outcome.answer.possible_steps.len() as u8
            } else {
                0
            },
            settings,
            drops: u8::from(reported && outcome.answer.drop.is_some()),
            plane: None,
            ground: outcome
                .answer
                .ground
                .filter(|_| reported)
                .map(SlopeField::new),
        }
    }

    /// Returns the sentence, with its CRC and line end.
    pub(super) fn write(&self) -> Line {
        let line = Writer::new("SCAN")
            .number(self.scan)
            .text(self.status.as_str())
            .text(self.direction.as_str())
            .number(u32::from(self.steps))
            .number(u32::from(self.lost_rows))
            .reasons(self.reasons)
            .length(self.horizon)
            .length(self.confidence.map(|tenths| Tenths(tenths.into())))
            .number(u32::from(self.possible_steps))
            .hex(&[self.settings])
            .number(u32::from(self.drops));
        let line = match (self.plane, self.ground) {
            (Some(plane), _) => line.text(plane.as_str()),
            (None, Some(_)) => line.text(""),
            (None, None) => line,
        };
        match self.ground {
            Some(ground) => line.length(Some(ground.from)).length(Some(ground.rise)),
            None => line,
        }
        .finish()
    }

    /// Parses the fields of a sentence after its name `SCAN`.
    pub(super) fn parse(fields: &mut Fields<'_>) -> Result<Self, ParseError> {
        let absent = |field| move |value: Option<Tenths>| value.ok_or(ParseError::Field(field));
        Ok(Self {
            scan: fields.number("scan")?,
            status: fields.word(
                "status",
                &[Status::Ok, Status::Degraded, Status::Fault],
                |s| s.as_str(),
            )?,
            direction: fields.word(
                "direction",
                &[Direction::None, Direction::Up, Direction::Down],
                |d| d.as_str(),
            )?,
            steps: fields.number("steps")?,
            lost_rows: fields.number("lost-rows")?,
            reasons: fields.reasons("reasons")?,
            horizon: fields.length("horizon")?,
            confidence: parse_permille(fields, "confidence")?,
            possible_steps: fields.number("maybes")?,
            settings: fields.hash("settings")?,
            drops: fields.number("drops")?,
            plane: fields.last_plane()?,
            ground: match fields.ended() {
                true => None,
                false => Some(SlopeField {
                    from: fields.length("slope-from").and_then(absent("slope-from"))?,
                    rise: fields.length("slope").and_then(absent("slope"))?,
                }),
            },
        })
    }
}

/// Parses the next field, a probability in per cent with one decimal; returns tenths of a per cent, `None` for an
/// empty field.
pub(super) fn parse_permille(
    fields: &mut Fields<'_>,
    field: &'static str,
) -> Result<Option<u16>, ParseError> {
    match fields.length(field)? {
        None => Ok(None),
        Some(Tenths(tenths @ 0..=1000)) => Ok(Some(tenths as u16)),
        Some(_) => Err(ParseError::Field(field)),
    }
}
