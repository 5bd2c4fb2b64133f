//! The sentences of a scan: its head, its steps, its drop, what else may stand there.

use super::fields::{Fields, ParseError};
use super::frame::{Line, Tenths};
use super::writer::Writer;
use crate::answer::{Direction, DropEdge, Maybe, Step};
use crate::config::Plane;
use crate::verdict::{Outcome, Reasons, Status};

/// One step as its sentence carries it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepLine {
    /// Number of the scan.
    pub scan: u32,
    /// Index of the step, from 1.
    pub index: u8,
    /// Number of steps of the scan.
    pub count: u8,
    /// Horizontal distance from the mirror's centre, negative behind it.
    pub distance: Tenths,
    /// Height above the ground.
    pub height: Tenths,
    /// Depth of the tread.
    pub tread: Option<Tenths>,
    /// Height of the riser.
    pub riser: Option<Tenths>,
    /// Standard deviation of the distance.
    pub distance_sigma: Tenths,
    /// Standard deviation of the height.
    pub height_sigma: Tenths,
    /// How much of the step was seen, 0…100.
    pub quality: u8,
}

impl StepLine {
    /// The sentence of `step`.
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

    /// The sentence, with its CRC and line end.
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

    /// From the fields behind the name.
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

/// The head of a scan's answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScanLine {
    /// Number of the scan since boot, from 1.
    pub scan: u32,
    /// What the answer is worth.
    pub status: Status,
    /// Where the stairs lead.
    pub direction: Direction,
    /// Number of `STEP` sentences that follow.
    pub steps: u8,
    /// Rows whose chirp was lost.
    pub lost_rows: u16,
    /// Why it is not `ok`, and what is weak where it is.
    pub reasons: Reasons,
    /// How far the answer vouches for itself, from the mirror.
    pub horizon: Option<Tenths>,
    /// How likely nothing is wrong up to there, tenths of a per cent.
    pub confidence: Option<u16>,
    /// Number of `MAYBE` sentences that follow.
    pub maybes: u8,
    /// [`hash`](crate::scanner::Settings::hash) of the settings that the scan was made with.
    pub settings: u32,
    /// Number of `DROP` sentences that follow: 0 or 1.
    pub drops: u8,
    /// The plane that the scan was made in: of a scanner that changes planes. A field that is left out elsewhere.
    pub plane: Option<Plane>,
}

/// Where the ground ends, as its sentence carries it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DropLine {
    /// Number of the scan.
    pub scan: u32,
    /// Horizontal distance from the mirror's centre to the edge.
    pub distance: Tenths,
    /// Standard deviation of the distance.
    pub distance_sigma: Tenths,
    /// Depth of the next surface below the ground; `None` where it is not known.
    pub depth: Option<Tenths>,
    /// Probability that the ground ends there, tenths of a per cent.
    pub probability: u16,
}

impl DropLine {
    /// The sentence of `edge`.
    pub fn new(scan: u32, edge: &DropEdge) -> Self {
        Self {
            scan,
            distance: Tenths::from_metres(edge.distance_m),
            distance_sigma: Tenths::from_metres(edge.distance_sigma_m),
            depth: edge.depth_m.map(Tenths::from_metres),
            probability: permille(edge.probability),
        }
    }

    /// What the sentence tells, in the units of the answer.
    pub fn edge(&self) -> DropEdge {
        DropEdge {
            distance_m: self.distance.metres(),
            distance_sigma_m: self.distance_sigma.metres(),
            depth_m: self.depth.map(Tenths::metres),
            probability: f32::from(self.probability) / 1000.0,
        }
    }

    /// The sentence, with its CRC and line end.
    pub(super) fn write(&self) -> Line {
        Writer::new("DROP")
            .number(self.scan)
            .length(Some(self.distance))
            .length(Some(self.distance_sigma))
            .length(self.depth)
            .length(Some(Tenths(self.probability.into())))
            .finish()
    }

    /// From the fields behind the name.
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

/// What may stand there though the answer does not hold it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MaybeLine {
    /// Number of the scan.
    pub scan: u32,
    /// Index, from 1.
    pub index: u8,
    /// Number of them in the scan.
    pub count: u8,
    /// Horizontal distance from the mirror's centre.
    pub distance: Tenths,
    /// Height above the ground; negative where the ground may end.
    pub height: Tenths,
    /// How likely, tenths of a per cent.
    pub probability: u16,
}

impl MaybeLine {
    /// The sentence of `maybe`.
    pub fn new(scan: u32, index: u8, count: u8, maybe: &Maybe) -> Self {
        Self {
            scan,
            index,
            count,
            distance: Tenths::from_metres(maybe.distance_m),
            height: Tenths::from_metres(maybe.height_m),
            probability: permille(maybe.probability),
        }
    }

    /// The sentence, with its CRC and line end.
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

    /// From the fields behind the name.
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

/// A probability in tenths of a per cent, rounded.
pub(super) fn permille(p: f32) -> u16 {
    ((1000.0 * p + 0.5) as u16).min(1000)
}

impl ScanLine {
    /// Number of sentences of the same scan that follow.
    pub fn following(&self) -> u8 {
        let rest = self.drops.saturating_add(self.maybes);
        self.steps.saturating_add(rest)
    }

    /// The head of an answer to scan number `scan`, made with settings of this hash.
    pub fn new(scan: u32, lost_rows: u16, outcome: &Outcome, settings: u32) -> Self {
        let told = outcome.status() != Status::Fault;
        Self {
            scan,
            status: outcome.status(),
            direction: outcome.answer.direction,
            steps: if told {
                outcome.answer.steps.len() as u8
            } else {
                0
            },
            lost_rows,
            reasons: outcome.reasons(),
            horizon: outcome
                .horizon_m()
                .filter(|_| told)
                .map(Tenths::from_metres),
            confidence: outcome.confidence().filter(|_| told).map(permille),
            maybes: if told {
                outcome.answer.maybes.len() as u8
            } else {
                0
            },
            settings,
            drops: u8::from(told && outcome.answer.drop.is_some()),
            plane: None,
        }
    }

    /// The sentence, with its CRC and line end.
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
            .number(u32::from(self.maybes))
            .hex(&[self.settings])
            .number(u32::from(self.drops));
        match self.plane {
            Some(plane) => line.text(plane.as_str()),
            None => line,
        }
        .finish()
    }

    /// From the fields behind the name.
    pub(super) fn parse(fields: &mut Fields<'_>) -> Result<Self, ParseError> {
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
            maybes: fields.number("maybes")?,
            settings: fields.hash("settings")?,
            drops: fields.number("drops")?,
            plane: match fields.ended() {
                true => None,
                false => {
                    Some(fields.word("plane", &[Plane::Depth, Plane::Height], |p| p.as_str())?)
                }
            },
        })
    }
}

/// A probability in per cent with one decimal, or nothing.
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
