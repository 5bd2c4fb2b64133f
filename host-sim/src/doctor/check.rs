//! The checks of the list that `doctor` prints, in the order of the scanner's start-up.

/// One check of a scanner, a line of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// The report port opens, and the scanner replies.
    Port,
    /// Firmware version, self-test and stored settings, and crashes or watchdog resets in the past.
    Firmware,
    /// The firmware image's checksum.
    Seal,
    /// The microcontroller's clock, supply and memory are in order.
    Chip,
    /// The chip's brown-out reset and protections.
    OptionBytes,
    /// The mirror's motor and its driver work.
    Motor,
    /// The home switch is found, and the mirror has not slipped since.
    Home,
    /// The encoder on the mirror's shaft answers.
    Encoder,
    /// The radar module answers.
    Module,
    /// The samples of the module's chirps are plausible.
    Signal,
    /// The echo of the scanner's own mirror is there.
    MirrorEcho,
    /// The ground is where the mounting requires it, and the field of view is free.
    Mount,
    /// The status of a scan's answer.
    Answer,
}

impl Check {
    /// All checks, in the order of the scanner's start-up.
    pub const ALL: &'static [Self] = &[
        Self::Port,
        Self::Firmware,
        Self::Seal,
        Self::Chip,
        Self::OptionBytes,
        Self::Motor,
        Self::Home,
        Self::Encoder,
        Self::Module,
        Self::Signal,
        Self::MirrorEcho,
        Self::Mount,
        Self::Answer,
    ];

    /// Returns the check's name.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Port => "port",
            Self::Firmware => "firmware",
            Self::Seal => "seal",
            Self::Chip => "chip",
            Self::OptionBytes => "option bytes",
            Self::Motor => "motor",
            Self::Home => "home switch",
            Self::Encoder => "encoder",
            Self::Module => "radar module",
            Self::Signal => "signal",
            Self::MirrorEcho => "mirror echo",
            Self::Mount => "mount, floor",
            Self::Answer => "answer",
        }
    }
}
