//! What is known of the chair's motion when a scan ends, and what holds where nothing is.

use crate::track::Track;

/// What holds where nothing is known of the chair's motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Two sweeps over the same scene must agree before anything is `ok`, but where motion input and echoes say that
    /// the chair stands.
    #[default]
    Auto,
    /// Nothing is `ok` without motion input.
    Required,
    /// The chair is known to stand: a bench, a recording of a single scan.
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
    /// Neither used nor kept.
    Off,
    /// Neither used nor changed: a scan of the other plane comes in between.
    Aside,
}

/// What became of the motion input during a scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Input {
    /// There never was any.
    #[default]
    Absent,
    /// Every row's place is known.
    Good,
    /// Too long between two sentences, or none any more.
    Late,
    /// Travel or pitch changed faster than a chair can.
    Jumping,
    /// The same sentence again and again.
    Frozen,
    /// A sentence came damaged.
    Garbled,
    /// An older sentence came after a newer one.
    Disordered,
}

impl Input {
    /// Whether there was an input, and a scan could not be put where it was seen by it.
    pub const fn is_bad(self) -> bool {
        !matches!(self, Self::Good | Self::Absent)
    }

    /// Its name in sentences.
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

/// What is known of the chair's motion when a scan ends.
#[derive(Clone, Copy, Debug)]
pub struct Drive<'a> {
    /// What holds where the input is not good.
    pub mode: Mode,
    /// What became of the motion input.
    pub input: Input,
    /// When each row was seen, and where; none where the chair is known to stand.
    pub track: Option<&'a Track>,
    /// Forward travel from the last row of the scan before to that of this one, metres, where the
    /// input was good all the way.
    pub moved_m: Option<f32>,
    /// Time between these two rows, seconds; none for the first scan.
    pub since_s: Option<f32>,
    /// Whether the chair stood during the scan by the motion input, and by the phases of the echoes, which the
    /// data path adds.
    pub stood: bool,
    /// Duration of a chirp, seconds.
    pub chirp_s: f32,
    /// Whether the evidence of earlier scans is used.
    pub memory: Retention,
}

impl<'a> Drive<'a> {
    /// That of a chair which is known to stand: on a bench, where each scan is by itself.
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

    /// The track, if it says where the chair was.
    pub fn known(&self) -> Option<&'a Track> {
        self.track.filter(|_| self.input == Input::Good)
    }
}
