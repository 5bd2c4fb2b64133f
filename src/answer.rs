//! The answer of one scan: status, reasons and steps, as all parts of the scanner exchange them.

use core::fmt;

/// Most steps of one report.
pub const MAX_STEPS: usize = 16;

/// Most places of an answer where something may stand that it does not hold.
pub const MAX_MAYBES: usize = 6;

/// What a controller may do with a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Trust it; zero steps then means that there are no stairs.
    Ok,
    /// Usable; the reasons say what is weak.
    Degraded,
    /// No answer; the reasons say why. Never holds steps.
    Fault,
}

/// Where the stairs lead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// No stairs.
    #[default]
    None,
    /// Ascending.
    Up,
    /// Descending.
    Down,
}

/// One step of the staircase, in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// Horizontal distance from the mirror's centre to the step's foremost edge; negative behind it.
    pub distance_m: f32,
    /// Height of the step's tread above the surface that the wheelchair stands on.
    pub height_m: f32,
    /// Depth of the tread up to the next step's edge; `None` for the last.
    pub tread_m: Option<f32>,
    /// Height of the riser from the level before; `None` where that level is not known.
    pub riser_m: Option<f32>,
    /// Standard deviation of the distance.
    pub distance_sigma_m: f32,
    /// Standard deviation of the height.
    pub height_sigma_m: f32,
    /// How much of the step was seen, 0…100.
    pub quality: u8,
}

macro_rules! reasons {
    ($($(#[doc = $doc:literal])* $name:ident = $text:literal),* $(,)?) => {
        /// Why a scan is `degraded` or a `fault`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Reason { $($(#[doc = $doc])* $name),* }

        impl Reason {
            /// Every reason, in the order of their bits.
            pub const ALL: &'static [Reason] = &[$(Reason::$name),*];

            /// The word that stands in a sentence.
            pub fn as_str(self) -> &'static str {
                // Every reason has a word; a table of them is a third of a `match` in each caller.
                const WORDS: &[&str] = &[$($text),*];
                WORDS.get(self as usize).copied().unwrap_or("")
            }

            /// What it means, in a sentence for people.
            pub fn meaning(self) -> &'static str {
                const MEANINGS: &[&str] = &[$(concat!($($doc),*)),*];
                MEANINGS.get(self as usize).map_or("", |text| text.trim())
            }
        }
    };
}

reasons! {
    /// Some rows' chirps were lost after all retries.
    LostRows = "lost-rows",
    /// A step, or its height, was inferred from its neighbours: no echo of its own shows it well.
    InferredStep = "inferred-step",
    /// Another reading of the echoes is nearly as likely.
    CloseRival = "close-rival",
    /// The steps rest on echoes little above the noise.
    WeakEchoes = "weak-echoes",
    /// Something stands in the line of sight.
    BlockedView = "blocked-view",
    /// The answer does not vouch for the first metre of the way.
    ShortHorizon = "short-horizon",
    /// A step departs from the others by more than a person would expect.
    IrregularStep = "irregular-step",
    /// Nobody has told the scanner yet how it is mounted: no settings were saved, and none have come.
    Unconfigured = "unconfigured",
    /// No second sweep over the same scene has confirmed yet that the chair stands, or moves as is said.
    Unconfirmed = "unconfirmed",
    /// The chair moves: two sweeps over the scene do not agree, or echoes' phases go on from row to row.
    Moving = "moving",
    /// The motion input was lost, late, damaged or impossible: the scan was worked off without it.
    MotionInput = "motion-input",
    /// What was carried on from earlier scans contradicts this one, and was forgotten.
    SceneChanged = "scene-changed",
    /// Samples at the converter's full scale.
    Saturated = "saturated",
    /// No signal at all.
    Silent = "silent",
    /// No echo from the mirror.
    MirrorMissing = "mirror-missing",
    /// The mirror's echo never changes: the same chirp again and again.
    MirrorFrozen = "mirror-frozen",
    /// The map holds no noise, so that it cannot come from a radar.
    NoNoise = "no-noise",
    /// Nothing but noise: not even the floor was seen.
    NoEcho = "no-echo",
    /// A bit of the converter never changes.
    AdcBit = "adc-bit",
    /// I and Q have changed places, or one has the wrong sign: echoes beat backwards.
    IqSwapped = "iq-swapped",
    /// One of the two channels is dead, or both give the same.
    ChannelDead = "channel-dead",
    /// I and Q are so unlike that echoes have images.
    IqImbalance = "iq-imbalance",
    /// The converter's offset walks during the scan.
    DcDrift = "dc-drift",
    /// Samples are cut off below the converter's full scale.
    Clipped = "clipped",
    /// The level of the mirror's own echo changes during the scan.
    GainDrift = "gain-drift",
    /// Rows were set aside because something else transmits, or a tone stands in all of them.
    Interference = "interference",
    /// The mirror's own echo is not where the mirror's offset says: the range scale is not true.
    RangeScale = "range-scale",
    /// The same chirp came more than once.
    StaleChirp = "stale-chirp",
    /// Echoes do not change though the mirror should have turned.
    MirrorStuck = "mirror-stuck",
    /// Echoes change faster or slower over the rows than the beam's width says: rows are not at their angles.
    AngleJump = "angle-jump",
    /// The floor is not where mount height, angle and offset say that it must be.
    Mount = "mount",
    /// Too many chirps were lost.
    TooManyLost = "too-many-lost",
    /// The radar module does not answer.
    LinkSilent = "link-silent",
    /// The radar module reports an error.
    ModuleError = "module-error",
    /// The radar module is set to something that the scanner cannot work with.
    ModuleConfig = "module-config",
    /// The motor's driver reports a stall.
    MotorStall = "motor-stall",
    /// The home switch was not found.
    HomeNotFound = "home-not-found",
    /// The known-answer test of the arithmetic failed.
    SelfTest = "self-test",
    /// The settings in memory are no longer those that were set: only a reset helps.
    SettingsDamaged = "settings-damaged",
    /// The watchdog had to reset the chip.
    Watchdog = "watchdog",
    /// The firmware panicked or took a hardware fault.
    Crash = "crash",
    /// Crashes followed one another: the scanner stands still until it is told to start.
    CrashLoop = "crash-loop",
    /// The image in flash is not what was built.
    ImageDamaged = "image-damaged",
    /// Nobody has sealed the image: whether it is whole cannot be told.
    ImageUnsealed = "image-unsealed",
    /// The memory does not keep what is written to it.
    MemoryDamaged = "memory-damaged",
    /// The supply is too low, or was before the reset.
    Supply = "supply",
    /// The crystal does not run, and nobody has said that the internal oscillator will do.
    InternalClock = "internal-clock",
    /// The motor's driver does not answer, was reset, or reports an error.
    MotorDriver = "motor-driver",
    /// The home switch or the encoder finds the mirror elsewhere: its angle was not what its steps said.
    MirrorSlipped = "mirror-slipped",
    /// The encoder on the mirror's shaft does not answer, or finds no magnet.
    EncoderSilent = "encoder-silent",
}

/// A set of [`Reason`]s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reasons(u64);

/// Every reason has a bit.
const _: () = assert!(Reason::ALL.len() <= u64::BITS as usize);

impl Reasons {
    /// No reason.
    pub const NONE: Self = Self(0);

    /// Adds one.
    pub fn add(&mut self, reason: Reason) {
        self.0 |= 1 << reason as u8;
    }

    /// This set and one more.
    #[must_use]
    pub fn with(mut self, reason: Reason) -> Self {
        self.add(reason);
        self
    }

    /// Whether `reason` is in the set.
    pub fn has(self, reason: Reason) -> bool {
        self.0 & (1 << reason as u8) != 0
    }

    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// This set without one.
    #[must_use]
    pub fn without(self, reason: Reason) -> Self {
        Self(self.0 & !(1 << reason as u8))
    }

    /// The first reason of the set.
    pub fn first(self) -> Option<Reason> {
        Reason::ALL.get(self.0.trailing_zeros() as usize).copied()
    }

    /// The reasons of the set, in the order of [`Reason::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Reason> {
        Reason::ALL.iter().copied().filter(move |&r| self.has(r))
    }
}

impl fmt::Display for Reasons {
    /// The words joined by `+`; nothing for the empty set.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, reason) in self.iter().enumerate() {
            if k > 0 {
                f.write_str("+")?;
            }
            f.write_str(reason.as_str())?;
        }
        Ok(())
    }
}

/// The answer of one scan.
///
/// ```
/// use stairscan::answer::{Direction, Outcome, Reason, Status, Step};
///
/// let at = |distance_m, height_m| Step { distance_m, height_m, ..Step::default() };
/// let mut outcome = Outcome { direction: Direction::Up, ..Outcome::undecided() };
/// outcome.steps.push(at(0.50, 0.17)).unwrap();
/// outcome.steps.push(at(0.78, 0.34)).unwrap();
/// outcome.link();
/// let tread_m = outcome.steps[0].tread_m.unwrap();
/// assert!((tread_m - 0.28).abs() < 1e-6);
/// assert_eq!(outcome.steps[1].tread_m, None);
/// assert_eq!(outcome.status, Status::Fault);
/// outcome.decide(Status::Ok);
/// assert!(outcome.status == Status::Ok && outcome.reasons.is_empty());
///
/// let fault = Outcome::fault(Reason::MotorStall);
/// assert_eq!(fault.status, Status::Fault);
/// assert!(fault.steps.is_empty());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// How far it can be trusted.
    pub status: Status,
    /// Where the stairs lead.
    pub direction: Direction,
    /// The steps, nearest first.
    pub steps: heapless::Vec<Step, MAX_STEPS>,
    /// Why it is not `ok`, and what is weak where it is.
    pub reasons: Reasons,
    /// Up to where the answer vouches for itself, metres from the mirror; `None` if the estimator
    /// does not say, and then it claims the whole range.
    pub horizon_m: Option<f32>,
    /// Probability that nothing is wrong up to the horizon, or over the first metre where that is
    /// farther; `None` if the estimator does not say.
    pub confidence: Option<f32>,
    /// What may stand there though the answer does not hold it, nearest first.
    pub maybes: heapless::Vec<Maybe, MAX_MAYBES>,
}

/// Something that may stand there though the answer does not hold it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Maybe {
    /// Horizontal distance from the mirror's centre, metres.
    pub distance_m: f32,
    /// Height above the ground, metres; [`Maybe::DROP_M`] where the ground may end, of which the depth
    /// is not known.
    pub height_m: f32,
    /// How likely, 0…1.
    pub probability: f32,
}

impl Maybe {
    /// Height that stands for ground that ends: the least depth that is a drop to a wheelchair.
    pub const DROP_M: f32 = -0.1;
}

impl Outcome {
    /// An answer that is not decided yet: without steps, and a `fault` (`silent`) until [`Outcome::decide`].
    pub const fn undecided() -> Self {
        Self {
            status: Status::Fault,
            direction: Direction::None,
            steps: heapless::Vec::new(),
            reasons: Reasons(1 << Reason::Silent as u8),
            horizon_m: None,
            confidence: None,
            maybes: heapless::Vec::new(),
        }
    }

    /// No answer, for `reason`.
    pub fn fault(reason: Reason) -> Self {
        Self {
            status: Status::Fault,
            reasons: Reasons::NONE.with(reason),
            ..Self::undecided()
        }
    }
}

impl Outcome {
    /// Gives an undecided answer its status. Only what has weighed the whole answer may call this.
    pub fn decide(&mut self, status: Status) {
        self.status = status;
        self.reasons = self.reasons.without(Reason::Silent);
    }

    /// Takes `ok` away where there is doubt about the instrument, and with it what the answer vouches
    /// for: no estimator can know better than its instrument.
    #[inline(never)]
    pub fn doubt(&mut self, doubts: Reasons) {
        if doubts.is_empty() {
            return;
        }
        doubts.iter().for_each(|reason| self.reasons.add(reason));
        if self.status != Status::Fault {
            self.status = Status::Degraded;
            self.horizon_m = self.horizon_m.map(|_| 0.0);
            self.confidence = self.confidence.map(|_| 0.0);
        }
    }

    /// Tread depths and riser heights of the steps in the order of their distance: a tread reaches
    /// to the next step's edge, a riser from the level before; the first stands on the ground.
    pub fn link(&mut self) {
        let mut level = 0.0;
        for step in &mut self.steps {
            step.riser_m = Some((step.height_m - level).abs());
            level = step.height_m;
            step.tread_m = None;
        }
        let mut next = None;
        for step in self.steps.iter_mut().rev() {
            step.tread_m = next.map(|distance: f32| distance - step.distance_m);
            next = Some(step.distance_m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn treads_and_risers_come_from_neighbours() {
        let at = |distance_m, height_m| Step {
            distance_m,
            height_m,
            ..Step::default()
        };
        let mut outcome = Outcome::undecided();
        for step in [at(0.5, 0.17), at(0.8, 0.34), at(1.1, 0.53)] {
            outcome.steps.push(step).unwrap();
        }
        outcome.link();
        let steps = outcome.steps;
        let close = |a: Option<f32>, b: f32| a.is_some_and(|a| (a - b).abs() < 1e-6);
        assert!(close(steps[0].tread_m, 0.3) && close(steps[1].tread_m, 0.3));
        assert_eq!(steps[2].tread_m, None);
        assert!(close(steps[0].riser_m, 0.17) && close(steps[2].riser_m, 0.19));
    }
}
