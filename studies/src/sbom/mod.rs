//! The supply chain of the image: the crates that are linked into it, their purpose, and their share of
//! the code.
//!
//! | module | from → to |
//! |---|---|
//! | `graph` | `cargo tree`, `cargo metadata`, `Cargo.lock` → the linked crates with their dependencies |
//! | `cyclonedx` | the linked crates → a CycloneDX document |
//! | `notes` | why each crate is there, and who maintains it |
//! | `sources` | the source folder of a crate → lines, `unsafe`, build script, prebuilt files |
//! | `code` | the image's line table → bytes of code by crate |
//! | `tables` | all of these → the tables of docs/generated/supply-chain.md |

pub mod code;
pub mod cyclonedx;
pub mod graph;
pub mod notes;
pub mod sources;
pub mod tables;
