//! Signed images: keys, signatures, and the transfer over the report port into a scanner.
//!
//! | module | content |
//! |---|---|
//! | [`keys`] | key pairs in files |
//! | [`slots`] | an ELF file converted to the bytes of either slot |
//! | [`files`] | loader and image as files for programs that write flash |
//! | [`package`] | the file that `update` sends: the image for slot A and for slot B, each with its signature |
//! | [`wire`] | frames to the boot loader and its answers |
//! | [`client`] | an update, from the first request to the confirmation |

pub mod client;
pub mod files;
pub mod keys;
pub mod package;
pub mod slots;
pub mod wire;
