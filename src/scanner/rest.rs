//! Whether the scanner has something to do at once, or may rest until an interrupt.

/// Time for which the scanner's next step may wait if no interrupt comes, the shortest first.
///
/// Bytes, step pulses and edges of the inputs come by interrupts, so that whoever waits for one of them may sleep. What
/// is polled limits the rest: transmitters take a byte every 87 µs at 115,200 baud, and deadlines come by time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rest {
    /// The next step is due at once.
    None,
    /// The radar module's reply is under way.
    Reply,
    /// Bytes wait for a transmitter, or a deadline is near.
    Short,
    /// Nothing is under way but `LIVE`, or a deadline far off.
    Long,
}

impl Rest {
    /// Returns the maximum time until the next step, µs; `None` if it is due at once.
    pub const fn limit_us(self) -> Option<u32> {
        match self {
            Self::None => None,
            Self::Reply | Self::Short => Some(50),
            Self::Long => Some(1_000),
        }
    }

    /// Returns this rest if `waits`, [`Rest::None`] otherwise.
    pub(super) const fn only_if(self, waits: bool) -> Self {
        match waits {
            true => self,
            false => Self::None,
        }
    }
}
