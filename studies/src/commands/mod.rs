//! The program's commands, one module each.

pub mod ablate;
pub mod accuracy;
pub mod bench;
pub mod budget;
pub mod capability;
pub mod compare;
pub mod drives;
pub mod faults;
pub mod fit;
pub mod guard;
pub mod hardware;
pub mod params;
pub mod reasons;
pub mod sbom;
pub mod sequences;
pub mod snr;
pub mod soak;
pub mod table1;
pub mod twins;

pub use host_sim::commands::{
    Format, Settings, busy, emit, full_scans, progress, progress_aside, recordings, timing,
};
