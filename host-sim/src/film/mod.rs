//! Animated drawing of a recording: the chair moves from scan to scan, the beam turns, echoes
//! appear where it meets surfaces, and the answer follows. One SVG file without a script, for a
//! page or a README.
//!
//! Distances are measured from the mirror at the first scan. The mirror moves by the true travel if
//! the recording has it, else by the chair's odometry. Without either, the chair stands.

mod shots;
mod stage;
#[cfg(test)]
mod tests;

pub use shots::Film;
use stage::Stage;

impl Film {
    /// Returns the animation of all scans as an SVG document.
    pub fn svg(&self) -> String {
        Stage::of(self).draw(self).to_string()
    }
}
