//! The checks of the list, in the order of the scanner's start-up.

/// One line of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// The report port opens, and the scanner replies.
    Port,
    /// Version, and its past operation.
    Firmware,
    /// The checksum of the image.
    Seal,
    /// Clock, supply and memory.
    Chip,
    /// The mirror's motor and its driver.
    Motor,
    /// The home switch.
    Home,
    /// The encoder on the mirror's shaft.
    Encoder,
    /// The radar module's answers.
    Module,
    /// The samples of its chirps.
    Signal,
    /// The mirror's own echo.
    MirrorEcho,
    /// The ground is where the mounting requires it, and the field of view is free.
    Mount,
    /// The whole answer.
    Answer,
}

impl Check {
    /// All checks, in the order of the scanner's start-up.
    pub const ALL: &'static [Self] = &[
        Self::Port,
        Self::Firmware,
        Self::Seal,
        Self::Chip,
        Self::Motor,
        Self::Home,
        Self::Encoder,
        Self::Module,
        Self::Signal,
        Self::MirrorEcho,
        Self::Mount,
        Self::Answer,
    ];

    /// Its name.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Port => "port",
            Self::Firmware => "firmware",
            Self::Seal => "seal",
            Self::Chip => "chip",
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
