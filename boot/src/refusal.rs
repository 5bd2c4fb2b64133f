//! Why an image is not taken or not executed.

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind};

/// A reason, which is also the code of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Refusal {
    /// No header of an image.
    NoImage = 1,
    /// An image for another chip or board.
    OtherChip = 2,
    /// An image linked for another slot.
    OtherSlot = 3,
    /// Longer than a slot.
    TooLong = 4,
    /// Its number is below the anti-rollback counter.
    Older = 5,
    /// Signed with a key that this loader does not know.
    WrongKey = 6,
    /// The signature does not belong to the header.
    BadSignature = 7,
    /// Fewer bytes than the header names.
    CutOff = 8,
    /// The payload is not the one that was signed.
    Damaged = 9,
    /// The flash did not take what was written, or could not be erased.
    Flash = 10,
    /// No such request, or not now.
    Request = 11,
    /// There is no other image to go back to.
    NoWayBack = 12,
    /// The supply is too low to write flash.
    Supply = 13,
}

impl Refusal {
    /// All of them.
    pub const ALL: [Self; 13] = [
        Self::NoImage,
        Self::OtherChip,
        Self::OtherSlot,
        Self::TooLong,
        Self::Older,
        Self::WrongKey,
        Self::BadSignature,
        Self::CutOff,
        Self::Damaged,
        Self::Flash,
        Self::Request,
        Self::NoWayBack,
        Self::Supply,
    ];

    /// Returns the reason with this code.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|known| *known as u8 == code)
    }

    /// Word in the loader's sentence and in the host's messages.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::NoImage => "no-image",
            Self::OtherChip => "other-chip",
            Self::OtherSlot => "other-slot",
            Self::TooLong => "too-long",
            Self::Older => "older-version",
            Self::WrongKey => "wrong-key",
            Self::BadSignature => "bad-signature",
            Self::CutOff => "cut-off",
            Self::Damaged => "damaged",
            Self::Flash => "flash",
            Self::Request => "request",
            Self::NoWayBack => "no-way-back",
            Self::Supply => "supply",
        }
    }
}

/// A flash whose errors tell why a request was refused.
pub trait Flash: NorFlash + ErrorType<Error: Into<Refusal>> {}

impl<F: NorFlash + ErrorType<Error: Into<Refusal>>> Flash for F {}

impl From<NorFlashErrorKind> for Refusal {
    fn from(_: NorFlashErrorKind) -> Self {
        Self::Flash
    }
}
