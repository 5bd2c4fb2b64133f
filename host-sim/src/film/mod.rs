//! A picture that moves: the chair goes from scan to scan of a recording, the beam turns, echoes appear where
//! it meets something, and the answer follows. One SVG file without a script, for a page or a README.
//!
//! Distances count from where the mirror was at the first scan. What moves it is the true travel where the
//! recording has it, else what the chair's odometry said; a recording without either is one of a chair that
//! stands.

mod shots;
mod stage;
#[cfg(test)]
mod tests;

pub use shots::Film;
use stage::Stage;

impl Film {
    /// The picture.
    pub fn svg(&self) -> String {
        Stage::of(self).draw(self).to_string()
    }
}
