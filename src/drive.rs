//! Motion of the chair during a scan, as the estimators receive it, and the rules where it is unknown.

use crate::track::Track;

/// Rule for scans whose motion input is not good.
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

/// Whether the evidence of earlier scans of the scene is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Retention {
    /// Used, as far as the travel since is known.
    #[default]
    Kept,
    /// Discarded: this scan counts as the first.
    Anew,
    /// Neither used nor kept: evidence of earlier scans is discarded, and this scan adds none.
    Off,
    /// Neither used nor changed: a scan of the other plane in between.
    Aside,
}

/// State of the motion input during a scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Input {
    /// No motion sentence has been received yet.
    #[default]
    Absent,
    /// The position of every row is known.
    Good,
    /// Too much time between two sentences, or since the last one.
    Late,
    /// Travel or pitch changed faster than those of a chair can.
    Jumping,
    /// The same sentence was received again and again.
    Frozen,
    /// A sentence was received damaged.
    Garbled,
    /// An older sentence was received after a newer one.
    Disordered,
}

impl Input {
    /// Returns whether there was an input that did not give the position of every row.
    pub const fn is_bad(self) -> bool {
        !matches!(self, Self::Good | Self::Absent)
    }

    /// Returns the name in sentences.
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

/// Motion of the chair during a scan.
#[derive(Clone, Copy, Debug)]
pub struct Drive<'a> {
    /// Rule where the input is not good.
    pub mode: Mode,
    /// State of the motion input.
    pub input: Input,
    /// Time and position of each row; `None` where the chair is known to stand.
    pub track: Option<&'a Track>,
    /// Forward travel from the last row of the scan before to that of this one, metres; `None` if the input was
    /// not good all the way.
    pub moved_m: Option<f32>,
    /// Time between these two rows, seconds; `None` for the first scan.
    pub since_s: Option<f32>,
    /// Whether the chair stood during the scan by the motion input and by the phases of the echoes; set by the
    /// data path.
    pub stood: bool,
    /// Duration of a chirp, seconds.
    pub chirp_s: f32,
    /// Whether the evidence of earlier scans is used.
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
        stood: false,
        chirp_s: 0.0,
        memory: Retention::Off,
    };

    /// Returns the track if the motion input was good.
    pub fn known(&self) -> Option<&'a Track> {
        self.track.filter(|_| self.input == Input::Good)
    }
}
