//! Table of all reasons that a status may have: code, meaning, effect on the answer, and the condition of each.
//!
//! This is the only list of them. The report and its parser, `--help`, the report page, the C header of
//! `controller/` and `docs/reasons.md` are generated from it, or compared with it by a test.

use core::fmt;

/// Effect of a reason on an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReasonEffect {
    /// Fault: there is no answer.
    Fault,
    /// Instrument fault: `degraded`, with a horizon and a confidence of 0.
    InstrumentFault,
    /// `degraded`; the horizon is kept.
    Degraded,
    /// No effect on the status: information for people and logs.
    Info,
}

impl ReasonEffect {
    /// Returns the effect's name in documents.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Fault => "fault",
            Self::InstrumentFault => "instrument",
            Self::Degraded => "degraded",
            Self::Info => "info",
        }
    }
}

macro_rules! reasons {
    ($($(#[doc = $doc:literal])* $name:ident = $text:literal [$($effect:ident),+] $condition:literal),* $(,)?) => {
        /// Condition that makes a scan `degraded` or a `fault`, or that is a weakness of one that is `ok`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Reason { $($(#[doc = $doc])* $name),* }

        // One list for each kind of text instead of one of rows: the image then holds the codes alone.
        impl Reason {
            /// All reasons, in the order of their bits.
            pub const ALL: &'static [Reason] = &[$(Reason::$name),*];

            /// Returns the reason's code as it stands in a sentence, such as `lost-rows`.
            pub fn as_str(self) -> &'static str {
                // A table of the codes takes a third of the flash of a `match` in each caller.
                const WORDS: &[&str] = &[$($text),*];
                WORDS.get(self as usize).copied().unwrap_or("")
            }

            /// Returns the reason's meaning, a sentence for people.
            pub fn meaning(self) -> &'static str {
                const MEANINGS: &[&str] = &[$(concat!($($doc),*)),*];
                MEANINGS.get(self as usize).map_or("", |text| text.trim())
            }

            /// Returns the reason's possible effects on an answer; [`Reason::condition`] says when each of them
            /// applies.
            pub fn effects(self) -> &'static [ReasonEffect] {
                const EFFECTS: &[&[ReasonEffect]] = &[$(&[$(ReasonEffect::$effect),+]),*];
                EFFECTS.get(self as usize).copied().unwrap_or(&[])
            }

            /// Returns the condition under which the reason is reported, as text.
            pub fn condition(self) -> &'static str {
                const CONDITIONS: &[&str] = &[$($condition),*];
                CONDITIONS.get(self as usize).copied().unwrap_or("")
            }
        }
    };
}

reasons! {
    /// Some rows' chirps were lost after all retries.
    LostRows = "lost-rows" [Degraded]
        "The chirps of some rows were not received after all retries, or a continuously turning mirror passed their angles; also reported with a fault.",
    /// A step, or its height, was inferred from its neighbours: no echo of its own shows it clearly.
    InferredStep = "inferred-step" [Info]
        "A step has no echo of its own, or the standard deviation of its height is above `sure_height_m`.",
    /// The runner-up is nearly as probable.
    CloseRival = "close-rival" [Info]
        "The flight, or the answer without steps, has a margin below `clear_lead_nats`, or a single rise may be a threshold or an obstacle as well as a step.",
    /// The steps rest on echoes little above the noise.
    WeakEchoes = "weak-echoes" [Info]
        "A step's strongest echo, or without steps the strongest of all, is below `weak_step_db`, or the next riser's would be below `next_seen_db`.",
    /// An object blocks the line of sight.
    BlockedView = "blocked-view" [InstrumentFault, Info]
        "An echo right before the mirror exceeds the mirror's by `near_db` in more than `near_rows` rows, or a constant level at one range nearer than `blocked_m`, above the skirt of the mirror's echo, fills more than `line_share` of the rows (instrument); or three echoes above `in_the_way_db` lie where the flight leaves no room (info).",
    /// The answer is not valid over the first metre of the way, or not certain enough of stairs that begin farther away.
    ShortHorizon = "short-horizon" [Degraded]
        "The horizon is below 1.0 m and does not reach the near edge (distance − 3σ) of a reported drop; or the first step is correct with a probability below 90 %.",
    /// A step deviates from the others by more than a person would expect.
    IrregularStep = "irregular-step" [Info]
        "A step's own echoes put its height more than `irregular_m`, and more than two standard deviations, off the straight flight, or its place along the line of sight more than `irregular_m`.",
    /// The mounting is not configured: no settings were saved, and none were set.
    Unconfigured = "unconfigured" [InstrumentFault]
        "No settings were saved, or others were in force before a reset, and not all settings of the mounting have been set since boot.",
    /// No second sweep over the same scene has confirmed yet that the chair stands, or moves as reported.
    Unconfirmed = "unconfirmed" [Degraded]
        "The phases of too few echoes show the reported travel, and no earlier sweep can be compared with this one, or too few echoes are common to both; in the paper's estimator always, unless `motion` is `standing`; in the height plane always with `plane both`.",
    /// The chair moves otherwise than reported: two sweeps over the scene do not agree, or the echoes' phases turn otherwise.
    Moving = "moving" [InstrumentFault, Degraded]
        "The mean phase change of echoes from row to row exceeds `phase_turned_deg` though the chair is not known to move (instrument); or two sweeps fit another travel better than the motion input, or than no travel if there is no input, or without such sweeps the phases turn alike from row to row and not as the motion input has it (degraded).",
    /// The motion input was lost, late, damaged or impossible: the scan was processed without it.
    MotionInput = "motion-input" [Degraded, Info]
        "Motion input is required and does not give every row's position (degraded); or it was late, jumping, frozen, garbled or disordered during the scan (info).",
    /// Evidence of earlier scans contradicts this scan and was discarded.
    SceneChanged = "scene-changed" [Info]
        "The evidence of earlier scans contradicts this scan.",
    /// The last full scan has a nearer hazard than this guard sweep: the nearer one is used.
    ScanNearer = "scan-nearer" [Info]
        "With a guard sweep: the last full scan, at most 5 s old and shifted by the motion input, has a step or a drop nearer than the sweep's free distance.",
    /// Samples at the converter's full scale.
    Saturated = "saturated" [Fault]
        "More than one sample in 1000 is at full scale.",
    /// No signal at all.
    Silent = "silent" [Fault, InstrumentFault]
        "Samples are constant in more than half of the rows (fault), or in at least one (instrument); or there was no evidence at all (fault).",
    /// No echo from the mirror.
    MirrorMissing = "mirror-missing" [Fault]
        "The mean level of the mirror's own echo is less than 9 dB above the noise.",
    /// The mirror's echo never changes: all chirps are the same.
    MirrorFrozen = "mirror-frozen" [Fault]
        "In more than half of the rows four samples across the chirp equal those of the chirp before.",
    /// Nothing but noise: not even the ground was detected.
    NoEcho = "no-echo" [Fault]
        "No echo reaches `sure_echo_db`; in the paper's estimator the number of detections is at most three times the expected number of false alarms; in a guard sweep no cell is 15 dB above the median, and the ground's line is not above it either over some sweeps.",
    /// A bit of the converter never changes.
    AdcBit = "adc-bit" [InstrumentFault]
        "In more than `lame_rows` rows a bit of the samples does not change though a lower one does.",
    /// I and Q are exchanged, or one has the wrong sign: the spectrum is mirrored.
    IqSwapped = "iq-swapped" [Fault]
        "The image of the mirror's echo is more than `twin_db` stronger than the echo in more than half of the rows.",
    /// One of the two channels is dead, or both give the same signal.
    ChannelDead = "channel-dead" [InstrumentFault]
        "The image of the mirror's echo is as strong as the echo within `twin_db` in more than three quarters of the rows.",
    /// The imbalance of I and Q is so large that echoes have images.
    IqImbalance = "iq-imbalance" [InstrumentFault]
        "The image of the mirror's echo is less than `image_db` weaker than the echo in more than three quarters of the rows, and not `channel-dead`.",
    /// The converter's offset drifts during the scan.
    DcDrift = "dc-drift" [InstrumentFault]
        "The mean of the samples drifts by more than `offset_walk` of full scale during the scan.",
    /// Samples are clipped below the converter's full scale.
    Clipped = "clipped" [InstrumentFault]
        "More than `clipped_share` of the samples are at the chirp's own extreme in more than 35 % of the checked rows.",
    /// The level of the mirror's own echo changes during the scan.
    GainDrift = "gain-drift" [InstrumentFault]
        "The level of the scanner's own structure is more than `inside_drift_db` off its first level in more than `strayed_rows` rows, or the mean level of the mirror's own echo that much off its calibrated level.",
    /// Rows were discarded because of interference, or a tone is present in all of them.
    Interference = "interference" [InstrumentFault]
        "The noise of a row jumps by more than `burst_db`, or a constant level at one range beyond `blocked_m` fills more than `line_share` of the rows.",
    /// The mirror's own echo does not match the mirror's offset: the range scale is wrong.
    RangeScale = "range-scale" [InstrumentFault]
        "The mean range of the mirror's own echo is more than `mirror_place_m` off the mirror's offset, or `mirror_moved_m` off its calibrated range.",
    /// The same chirp was received more than once.
    StaleChirp = "stale-chirp" [InstrumentFault]
        "A chirp equals one of the previous 16.",
    /// Echoes do not change though the mirror should have turned.
    MirrorStuck = "mirror-stuck" [InstrumentFault]
        "Rows equal those `still_lag_beams` before them, in cells above noise and skirt of the mirror's echo, for more than `still_beams` beam widths and more than `still_rows` rows.",
    /// Echoes change faster or slower over the rows than the beam width allows: rows are not at their angles.
    AngleJump = "angle-jump" [InstrumentFault]
        "Neighbouring rows differ by more than `jump_db` beyond the usual difference, or the lobes of strong echoes are narrower or broader over the rows than the beam.",
    /// The ground is not where mount height, angle and offset put it.
    Mount = "mount" [InstrumentFault]
        "The ground's echoes are likelier for another mounting than for level, stepped or sloping ground by `floor_elsewhere_nats`, the corrections of the calibration exceed `calibration_strain`, or the first riser's corner is more than `corner_astray_rad` off the ground while the ground does not confirm the mounting.",
    /// Too many chirps were lost.
    TooManyLost = "too-many-lost" [Fault]
        "More than `max-lost` rows were lost.",
    /// The radar module does not answer.
    LinkSilent = "link-silent" [Fault]
        "The radar module did not answer in time, or not in complete frames that match the request: when asked for its settings, or for 8 consecutive rows.",
    /// The radar module reports an error.
    ModuleError = "module-error" [Fault]
        "The radar module answered with an error or to another request: when asked for its settings, or for 8 consecutive rows.",
    /// The radar module has settings with which the scanner cannot work.
    ModuleConfig = "module-config" [Fault]
        "With the radar module's settings the scanner's are not valid, the scan exceeds schedule or buffers, or the module cannot add the chirps of a row.",
    /// The motor's driver reports a stall.
    MotorStall = "motor-stall" [Fault]
        "The driver's stall input reached the level `stall-level`.",
    /// The home switch was not found.
    HomeNotFound = "home-not-found" [Fault]
        "The home switch does not close within a turn, does not open, or closes at another position each time.",
    /// The known-answer test of the arithmetic failed.
    SelfTest = "self-test" [Fault]
        "The arithmetic gives a wrong result for a known chirp.",
    /// The settings in memory are corrupted: only a reset helps.
    SettingsDamaged = "settings-damaged" [Fault]
        "The checksum of the settings in memory is wrong.",
    /// The watchdog reset the chip.
    Watchdog = "watchdog" [Fault]
        "The chip was reset by its watchdog; reported by `status` and a failed self-test until the first scan.",
    /// The firmware panicked or took a hardware fault.
    Crash = "crash" [Fault]
        "The firmware panicked, took a hardware fault or an interrupt without a handler, or lost its clock; reported by `status` and a failed self-test until the first scan.",
    /// Repeated resets by crash, watchdog or supply: the scanner stays idle until a command starts it.
    CrashLoop = "crash-loop" [Fault]
        "Three consecutive resets by crash, watchdog or supply, without a minute between them that ended in an answer.",
    /// The image in flash is corrupted.
    ImageDamaged = "image-damaged" [Fault]
        "The checksum of the flash differs from the sealed image's.",
    /// The image has no checksum; its integrity is unknown.
    ImageUnsealed = "image-unsealed" [InstrumentFault]
        "The image contains no checksum of itself.",
    /// The memory does not store what is written to it.
    MemoryDamaged = "memory-damaged" [Fault]
        "The march test of the memory at boot failed.",
    /// The supply is too low, or was before the reset.
    Supply = "supply" [Fault]
        "At boot the supply detector reports a low supply voltage, or its drop caused the reset.",
    /// The crystal does not run, and the setting `internal-clock` is off.
    InternalClock = "internal-clock" [Fault]
        "The crystal does not run, and the setting `internal-clock` is off.",
    /// The motor's driver does not answer, was reset, or reports an error.
    MotorDriver = "motor-driver" [Fault]
        "The driver does not answer on its UART, was reset, or reports an error.",
    /// The home switch or the encoder finds the mirror elsewhere: its angle does not match its steps.
    MirrorSlipped = "mirror-slipped" [Fault]
        "The home switch or the encoder finds the mirror away from the position of its step count.",
    /// The encoder on the mirror's shaft does not answer, or finds no magnet.
    EncoderSilent = "encoder-silent" [Fault]
        "The encoder does not answer on its bus, or reports no magnet.",
    /// The estimator computes no horizon: how far the answer is right is not known.
    NoPromise = "no-promise" [Degraded]
        "The answer is the paper's estimator's, which has neither horizon nor confidence.",
}

/// Reasons about the instrument: each is a rule of `health`.
pub const INSTRUMENT_REASONS: &[Reason] = &[
    Reason::Silent,
    Reason::AdcBit,
    Reason::StaleChirp,
    Reason::DcDrift,
    Reason::Clipped,
    Reason::GainDrift,
    Reason::Interference,
    Reason::ChannelDead,
    Reason::IqImbalance,
    Reason::RangeScale,
    Reason::BlockedView,
    Reason::Moving,
    Reason::MirrorStuck,
    Reason::AngleJump,
];

/// A set of [`Reason`]s, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reasons(u64);

// Each reason needs a bit.
const _: () = assert!(Reason::ALL.len() <= u64::BITS as usize);

impl Reasons {
    /// The empty set.
    pub const NONE: Self = Self(0);

    /// Adds one reason.
    pub fn add(&mut self, reason: Reason) {
        *self = self.with(reason);
    }

    /// Returns this set with one more reason.
    #[must_use]
    pub const fn with(self, reason: Reason) -> Self {
        Self(self.0 | 1 << reason as u8)
    }

    /// Returns the union of both sets.
    #[must_use]
    pub const fn and(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// Whether `reason` is in the set.
    pub fn has(self, reason: Reason) -> bool {
        self.0 & (1 << reason as u8) != 0
    }

    /// Whether the set is empty.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns the first reason of the set, in the order of [`Reason::ALL`]; `None` if it is empty.
    pub fn first(self) -> Option<Reason> {
        Reason::ALL.get(self.0.trailing_zeros() as usize).copied()
    }

    /// Returns the reasons of the set, in the order of [`Reason::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Reason> {
        Reason::ALL.iter().copied().filter(move |&r| self.has(r))
    }
}

impl fmt::Display for Reasons {
    /// Writes the codes of the reasons joined by `+`; nothing for the empty set.
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
