//! Motion of the chair during a scan, as the estimators receive it, and the rules where it is unknown.

use crate::track::Track;

/// Rule for the status of answers of scans whose motion input is not good.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Two sweeps over the same scene must agree before an answer is `ok`, unless motion input and phases show
    /// that the chair stands.
    #[default]
    Auto,
    /// No answer is `ok` without motion input.
    Required,
    /// The chair is known to stand: a bench, or a recording of a single scan.
    Standing,
}

/// Use of the evidence of earlier scans of the same scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Retention {
    /// Earlier evidence is used, as far as the chair's travel since is known.
    #[default]
    Kept,
    /// Earlier evidence is discarded: this scan counts as the first.
    Anew,
    /// Earlier evidence is discarded, and this scan adds none.
    Off,
    /// Earlier evidence is neither used nor changed: this scan is of the other plane, between two scans of the first.
    Aside,
}

/// Travel of a chair that may move, as the motion input has it while a scan is made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExpectedTravel {
    /// Forward travel from the first motion sentence after the scan's first row to the last one, metres.
    pub since_first_m: f32,
    /// Forward travel from the row before to this one at the speed of the last sentences, metres. Sentences come later than
    /// they were read, by varying times: the speed does not jump with them.
    pub step_m: f32,
}

/// State of the motion input, the sentences of the chair's controller, during a scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Input {
    /// No motion sentence has been received yet.
    #[default]
    Absent,
    /// The position of the chair is known for every row.
    Good,
    /// Too much time passed between two motion sentences, or since the last one.
    Late,
    /// Travel or pitch changed faster than a chair's can.
    Jumping,
    /// The same motion sentence was received again and again.
    Frozen,
    /// A motion sentence was received damaged.
    Garbled,
    /// An older motion sentence was received after a newer one.
    Disordered,
}

impl Input {
    /// Returns whether there was a motion input that did not give the chair's position at every row.
    pub const fn is_bad(self) -> bool {
        !matches!(self, Self::Good | Self::Absent)
    }

    /// Returns the state's name in the scanner's sentences.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Absent => "absent",
            Self::Good => "good",
            Self::Late => "late",
            Self::Jumping => "jumping",
            Self::Frozen => "frozen",
            Self::Garbled => "garbled",
            Self::Disordered => "disordered",
        }
    }
}

/// Whether the phases of a scan's echoes turn from row to row as the motion input has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PhaseAgreement {
    /// No motion input, too few echoes, or phases that spread.
    #[default]
    Unknown,
    /// They do: the chair stood or moved as reported, but for multiples of half a wavelength a row.
    Agrees,
    /// They turn alike, and not as reported.
    Differs,
}

/// Motion of the chair during a scan.
#[derive(Clone, Copy, Debug)]
pub struct Drive<'a> {
    /// Rule for the answer's status where the motion input is not good.
    pub mode: Mode,
    /// State of the motion input.
    pub input: Input,
    /// Time and chair's position of each row; `None` where the chair is known to stand.
    pub track: Option<&'a Track>,
    /// Forward travel from the last row of the scan before to the last row of this one, metres; `None` if the input was
    /// not good all the way.
    pub moved_m: Option<f32>,
    /// Time from the last row of the scan before to the last row of this one, seconds; `None` for the first scan.
    pub since_s: Option<f32>,
    /// Whether the phases of the scan's echoes agree with the motion input; set by the data path.
    pub phases: PhaseAgreement,
    /// Duration of one radar chirp, seconds.
    pub chirp_s: f32,
    /// Rule for using and changing the evidence of earlier scans in this scan.
    pub memory: Retention,
}

impl<'a> Drive<'a> {
    /// Motion of a chair that is known to stand, without earlier scans: on a bench.
    pub const STANDING: Self = Self {
        mode: Mode::Standing,
        input: Input::Absent,
        track: None,
        moved_m: None,
        since_s: None,
        phases: PhaseAgreement::Unknown,
        chirp_s: 0.0,
        memory: Retention::Off,
    };

    /// Returns the track if the motion input was good.
    pub fn known(&self) -> Option<&'a Track> {
        self.track.filter(|_| self.input == Input::Good)
    }
}

/// Result of the comparison of two sweeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Whether the two sweeps agree on the chair's motion.
    pub finding: Finding,
    /// State of the motion input during the later sweep.
    pub input: Input,
}

/// Whether two sweeps agree on the chair's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finding {
    /// The chair is known or measured to stand, or the sweeps agree.
    Agreed,
    /// There is no sweep to compare with, or too few strong echoes.
    Unconfirmed,
    /// The sweeps do not agree.
    Moved,
    /// Motion input is required and is missing.
    Missing,
}

impl Agreement {
    /// Agreement of a chair that is known to stand.
    pub const STANDING: Self = Self {
        finding: Finding::Agreed,
        input: Input::Absent,
    };

    /// Returns the agreement of a scan that is compared with no other: `Agreed` only for a chair that is known
    /// to stand.
    pub fn untested(mode: Mode) -> Self {
        match mode {
            Mode::Standing => Self::STANDING,
            Mode::Auto | Mode::Required => Self {
                finding: Finding::Unconfirmed,
                ..Self::STANDING
            },
        }
    }

    /// Returns the travel from the sweep before to this one, metres: by the motion input, or 0 where both
    /// sweeps agree on one position without it; `None` if unknown.
    pub fn moved_m(&self, drive: &Drive<'_>) -> Option<f32> {
        match (self.finding, self.input) {
            (Finding::Missing, _) => None,
            (_, Input::Good) => drive.moved_m,
            (Finding::Agreed, _) => Some(0.0),
            _ => None,
        }
    }

    /// Returns the agreement with the finding `Agreed` if the steps agree with the motion input (`by_steps`),
    /// although most echoes are of the ground, which looks alike everywhere; else unchanged.
    pub fn confirmed(self, by_steps: bool) -> Self {
        let open = matches!(self.finding, Finding::Unconfirmed | Finding::Moved);
        let finding = match open && by_steps && self.input == Input::Good {
            true => Finding::Agreed,
            false => self.finding,
        };
        Self { finding, ..self }
    }

    /// Returns whether the echoes' positions can be used: the sweeps agree, or could not be compared.
    pub fn placed(&self) -> bool {
        matches!(self.finding, Finding::Agreed | Finding::Unconfirmed)
    }
}
