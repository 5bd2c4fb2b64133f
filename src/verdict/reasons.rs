//! Table of all reasons that a status may have: code, meaning, effect on the answer, and the condition of each.
//!
//! This is the only list of them. The report and its parser, `--help`, the report page, the C header of
//! `controller/`, the README and `docs/reasons.md` are generated from it, or compared with it by a test.

use core::fmt;

/// Effect of a reason on an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReasonEffect {
    /// There is no answer.
    Fault,
    /// Instrument fault: `degraded`, with a horizon and a confidence of 0.
    InstrumentFault,
    /// `degraded`; the horizon is kept.
    Degraded,
    /// None: information for people and logs.
    Info,
}

impl ReasonEffect {
    /// Returns its name in documents.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Fault => "fault",
            Self::InstrumentFault => "doubt",
            Self::Degraded => "degraded",
            Self::Info => "word",
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

            /// Returns its code in a sentence.
            pub fn as_str(self) -> &'static str {
                // A table of the codes takes a third of the flash of a `match` in each caller.
                const WORDS: &[&str] = &[$($text),*];
                WORDS.get(self as usize).copied().unwrap_or("")
            }

            /// Returns its meaning, a sentence for people.
            pub fn meaning(self) -> &'static str {
                const MEANINGS: &[&str] = &[$(concat!($($doc),*)),*];
                MEANINGS.get(self as usize).map_or("", |text| text.trim())
            }

            /// Returns its possible effects on an answer; [`Reason::condition`] says when each of them applies.
            pub fn effects(self) -> &'static [ReasonEffect] {
                const EFFECTS: &[&[ReasonEffect]] = &[$(&[$(ReasonEffect::$effect),+]),*];
                EFFECTS.get(self as usize).copied().unwrap_or(&[])
            }

            /// Returns the condition under which it is reported, as text.
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
        "The chirps of some rows did not come after all retries, or a mirror that turns all the time passed their angles; it stands beside a fault, too.",
    /// A step, or its height, was inferred from its neighbours: no echo of its own shows it well.
    InferredStep = "inferred-step" [Info]
        "A step has no echo of its own, or the standard deviation of its height is above `sure_height_m`.",
    /// Another reading of the echoes is nearly as likely.
    CloseRival = "close-rival" [Info]
        "The flight, or the answer without steps, leads by less than `clear_lead_nats`, or a single rise may be a threshold or an obstacle as well as a step.",
    /// The steps rest on echoes little above the noise.
    WeakEchoes = "weak-echoes" [Info]
        "A step's strongest echo, or without steps the strongest of all, is below `weak_step_db`, or the next riser's would be below `next_seen_db`.",
    /// Something stands in the line of sight.
    BlockedView = "blocked-view" [InstrumentFault, Info]
        "Right before the mirror something shines by `near_db` more than the mirror in more than `near_rows` rows, or one level stands at one range nearer than `blocked_m` in a share of the rows above `line_share` (doubt); or three echoes above `in_the_way_db` stand where the flight leaves no room (word).",
    /// The answer is not valid over the first metre of the way, or not sure enough of stairs that begin farther away.
    ShortHorizon = "short-horizon" [Degraded]
        "The horizon is below 1.0 m and does not reach the near edge (distance − 3σ) of a told drop; or the first step is right with a probability below 90 %.",
    /// A step departs from the others by more than a person would expect.
    IrregularStep = "irregular-step" [Info]
        "A step's own echoes put its height more than `irregular_m`, and more than two standard deviations, off the straight flight, or its place along the line of sight more than `irregular_m`.",
    /// Nobody has told the scanner yet how it is mounted: no settings were saved, and none have come.
    Unconfigured = "unconfigured" [InstrumentFault]
        "No settings were saved, or others were in force before a reset, and since boot not all that say how the scanner is mounted were set.",
    /// No second sweep over the same scene has confirmed yet that the chair stands, or moves as is said.
    Unconfirmed = "unconfirmed" [Degraded]
        "No sweep before this one can be compared with it, or too little is seen in both; in the paper's estimator always, unless `motion` is `standing`; in the height plane always with `plane both`.",
    /// The chair moves: two sweeps over the scene do not agree, or echoes' phases go on from row to row.
    Moving = "moving" [InstrumentFault, Degraded]
        "On the mean the phases of echoes turn by more than `phase_turned_deg` from row to row though the chair is not known to move (doubt); or two sweeps agree better on another way than on what the motion input says, or than on none where there is no input (degraded).",
    /// The motion input was lost, late, damaged or impossible: the scan was worked off without it.
    MotionInput = "motion-input" [Degraded, Info]
        "Motion input is required, and not every row's place is known by it (degraded); or it was late, jumping, frozen, garbled or disordered during the scan (word).",
    /// What was carried on from earlier scans contradicts this one, and was forgotten.
    SceneChanged = "scene-changed" [Info]
        "What earlier scans said contradicts this one.",
    /// The last full scan has a nearer hazard than this guard sweep: the nearer counts.
    ScanNearer = "scan-nearer" [Info]
        "Beside a guard sweep: the last full scan, at most 5 s old and moved by the motion input, has a step or a drop nearer than the sweep's free distance.",
    /// Samples at the converter's full scale.
    Saturated = "saturated" [Fault]
        "More than one sample in 1000 stands at full scale.",
    /// No signal at all.
    Silent = "silent" [Fault, InstrumentFault]
        "Samples do not swing in more than half of the rows (fault), or in at least one (doubt); or there was nothing to decide on (fault).",
    /// No echo from the mirror.
    MirrorMissing = "mirror-missing" [Fault]
        "On the mean the mirror's own echo stands less than 9 dB above the noise.",
    /// The mirror's echo never changes: the same chirp again and again.
    MirrorFrozen = "mirror-frozen" [Fault]
        "In more than half of the rows four samples across the chirp are those of the chirp before.",
    /// The map holds no noise, so that it cannot come from a radar.
    NoNoise = "no-noise" [Fault]
        "The median of the map is zero.",
    /// Nothing but noise: not even the floor was seen.
    NoEcho = "no-echo" [Fault]
        "No echo reaches `sure_echo_db`; in the paper's estimator no more than three times as many cells as false alarms are expected; in a guard sweep no cell is 15 dB above the median, and over some sweeps the ground's line is not above it either.",
    /// A bit of the converter never changes.
    AdcBit = "adc-bit" [InstrumentFault]
        "In more than `lame_rows` rows a bit of the samples does not change though a lower one does.",
    /// I and Q have changed places, or one has the wrong sign: echoes beat backwards.
    IqSwapped = "iq-swapped" [Fault]
        "The image of the mirror's echo is more than `twin_db` stronger than the echo in more than half of the rows.",
    /// One of the two channels is dead, or both give the same.
    ChannelDead = "channel-dead" [InstrumentFault]
        "The image of the mirror's echo is as strong as the echo within `twin_db` in more than three quarters of the rows.",
    /// I and Q are so unlike that echoes have images.
    IqImbalance = "iq-imbalance" [InstrumentFault]
        "The image of the mirror's echo is less than `image_db` weaker than the echo in more than three quarters of the rows, and not `channel-dead`.",
    /// The converter's offset walks during the scan.
    DcDrift = "dc-drift" [InstrumentFault]
        "The mean of the samples walks by more than `offset_walk` of full scale during the scan.",
    /// Samples are cut off below the converter's full scale.
    Clipped = "clipped" [InstrumentFault]
        "More than `clipped_share` of the samples stand at the chirp's own extreme in more than 35 % of the rows looked at.",
    /// The level of the mirror's own echo changes during the scan.
    GainDrift = "gain-drift" [InstrumentFault]
        "What the scanner shows of itself is more than `inside_drift_db` off its first level in more than `strayed_rows` rows, or the mirror's own echo on the mean that much off its calibrated level.",
    /// Rows were set aside because something else transmits, or a tone stands in all of them.
    Interference = "interference" [InstrumentFault]
        "The noise of a row jumps by more than `burst_db`, or one level stands at one range from `blocked_m` on in a share of the rows above `line_share`.",
    /// The mirror's own echo is not where the mirror's offset says: the range scale is not true.
    RangeScale = "range-scale" [InstrumentFault]
        "On the mean the mirror's own echo is more than `mirror_place_m` off the mirror's offset, or `mirror_moved_m` off its calibrated place.",
    /// The same chirp came more than once.
    StaleChirp = "stale-chirp" [InstrumentFault]
        "A chirp is one of the 16 before it once more.",
    /// Echoes do not change though the mirror should have turned.
    MirrorStuck = "mirror-stuck" [InstrumentFault]
        "Rows stay like those `still_lag_beams` before them for more than `still_beams` beam widths and more than `still_rows` rows.",
    /// Echoes change faster or slower over the rows than the beam's width says: rows are not at their angles.
    AngleJump = "angle-jump" [InstrumentFault]
        "Neighbouring rows differ by more than `jump_db` beyond the usual, or the lobes of strong echoes are narrower or broader over the rows than the beam.",
    /// The floor is not where mount height, angle and offset say that it must be.
    Mount = "mount" [InstrumentFault]
        "The floor is elsewhere than the mounting says, calibration's strain is above `calibration_strain`, or the first riser's corner is more than `corner_astray_rad` off the ground while the floor does not show that the mounting is right.",
    /// Too many chirps were lost.
    TooManyLost = "too-many-lost" [Fault]
        "More rows were lost than `max-lost`.",
    /// The radar module does not answer.
    LinkSilent = "link-silent" [Fault]
        "The radar module did not answer in time, or not in whole frames that fit the request: when asked for its settings, or for 8 rows one after the other.",
    /// The radar module reports an error.
    ModuleError = "module-error" [Fault]
        "The radar module answered with an error or with another answer than was asked for: when asked for its settings, or for 8 rows one after the other.",
    /// The radar module is set to something that the scanner cannot work with.
    ModuleConfig = "module-config" [Fault]
        "With what the radar module is set to the settings are not valid, or make no scan that schedule and buffers hold.",
    /// The motor's driver reports a stall.
    MotorStall = "motor-stall" [Fault]
        "The driver's stall input came to the level `stall-level`.",
    /// The home switch was not found.
    HomeNotFound = "home-not-found" [Fault]
        "The home switch does not close within a turn, does not open, or closes elsewhere each time.",
    /// The known-answer test of the arithmetic failed.
    SelfTest = "self-test" [Fault]
        "A known chirp does not come out of the arithmetic as it must.",
    /// The settings in memory are no longer those that were set: only a reset helps.
    SettingsDamaged = "settings-damaged" [Fault]
        "The checksum of the settings in memory is not that of what was set.",
    /// The watchdog had to reset the chip.
    Watchdog = "watchdog" [Fault]
        "The chip was reset by its watchdog; told by `status` and a failed self-test until the first scan.",
    /// The firmware panicked or took a hardware fault.
    Crash = "crash" [Fault]
        "The firmware panicked, took a hardware fault or an interrupt that nobody handles, or lost its clock; told by `status` and a failed self-test until the first scan.",
    /// Crashes followed one another: the scanner stands still until it is told to start.
    CrashLoop = "crash-loop" [Fault]
        "Three resets by crash, watchdog or supply followed one another, with no minute between them that ended in an answer.",
    /// The image in flash is not what was built.
    ImageDamaged = "image-damaged" [Fault]
        "The checksum of the flash is not that of the sealed image.",
    /// Nobody has sealed the image: whether it is whole cannot be told.
    ImageUnsealed = "image-unsealed" [InstrumentFault]
        "The image holds no checksum of itself.",
    /// The memory does not keep what is written to it.
    MemoryDamaged = "memory-damaged" [Fault]
        "The march test of the memory at boot failed.",
    /// The supply is too low, or was before the reset.
    Supply = "supply" [Fault]
        "At boot the supply detector reports a supply that is too low, or its fall made the reset.",
    /// The crystal does not run, and nobody has said that the internal oscillator will do.
    InternalClock = "internal-clock" [Fault]
        "The crystal does not run, and the setting `internal-clock` is off.",
    /// The motor's driver does not answer, was reset, or reports an error.
    MotorDriver = "motor-driver" [Fault]
        "The driver does not answer on its wire, was reset, or reports an error.",
    /// The home switch or the encoder finds the mirror elsewhere: its angle was not what its steps said.
    MirrorSlipped = "mirror-slipped" [Fault]
        "The home switch or the encoder finds the mirror away from where its steps put it.",
    /// The encoder on the mirror's shaft does not answer, or finds no magnet.
    EncoderSilent = "encoder-silent" [Fault]
        "The encoder does not answer on its bus, or reports no magnet.",
}

/// A set of [`Reason`]s, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reasons(u64);

// Each reason needs a bit.
const _: () = assert!(Reason::ALL.len() <= u64::BITS as usize);

impl Reasons {
    /// No reason.
    pub const NONE: Self = Self(0);

    /// Adds one reason.
    pub fn add(&mut self, reason: Reason) {
        *self = self.with(reason);
    }

    /// Returns this set and one more reason.
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

    /// Returns the first reason of the set.
    pub fn first(self) -> Option<Reason> {
        Reason::ALL.get(self.0.trailing_zeros() as usize).copied()
    }

    /// Returns the reasons of the set, in the order of [`Reason::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Reason> {
        Reason::ALL.iter().copied().filter(move |&r| self.has(r))
    }
}

impl fmt::Display for Reasons {
    /// The codes joined by `+`; nothing for the empty set.
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
