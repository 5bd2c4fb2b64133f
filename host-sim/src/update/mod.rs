//! Signed images: keys, what is signed, and the way over the report port into a scanner.
//!
//! | module | what it is |
//! |---|---|
//! | [`keys`] | pairs of keys in files |
//! | [`slots`] | an ELF file as the bytes of either slot |
//! | [`package`] | the file that `update` sends: the image for slot A and for slot B, each with its signature |
//! | [`wire`] | frames to the boot loader and its answers |
//! | [`client`] | an update from the first question to the confirmation |

pub mod client;
pub mod keys;
pub mod package;
pub mod slots;
pub mod wire;
