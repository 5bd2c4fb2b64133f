//! What a kind of stairs is to the search: faces one behind the other, and how well they explain
//! the echoes.
//!
//! Going up, the faces that look at the mirror are risers one behind the other; going down they are
//! treads one below the other. A flight's score is a sum over its faces plus what lies behind the
//! last one, so every beginning is scored once, whatever follows.

use super::roles::Role;
use super::scene::{Mark, Scene};
use crate::math;
use heapless::Vec;

/// Most faces of a flight.
pub const MAX_FLIGHT: usize = 10;

/// One face of a chain: its place, and the column that shows it unless it is inferred.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChainLink {
    /// Along the line of sight, metres.
    pub along_m: f32,
    /// Index of the column.
    pub column: Option<u8>,
}

/// Faces one behind the other.
pub type Chain = Vec<ChainLink, MAX_FLIGHT>;

/// Mean distance of a flight's faces, landings left out, and the number of those: faces farther apart
/// than `most_m`.
pub fn regular(chain: &[ChainLink], most_m: f32) -> (f32, usize) {
    let (mut sum, mut spans, mut landings) = (0.0, 0.0, 0);
    for pair in chain.windows(2) {
        let [before, after] = pair else { continue };
        let away_m = after.along_m - before.along_m;
        if away_m <= most_m {
            sum += away_m;
            spans += 1.0;
        } else {
            landings += 1;
        }
    }
    (sum / math::max(spans, 1.0), landings)
}

/// A kind of explanation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Explanation {
    /// Level ground; going down also ground that falls.
    NoStairs,
    /// Stairs going up.
    Up {
        /// Height of one riser, metres.
        rise_m: f32,
        /// Whether they float.
        open: bool,
    },
    /// Stairs going down.
    Down {
        /// First edge, metres from the mirror.
        edge_m: f32,
        /// From edge to edge, metres.
        going_m: f32,
    },
}

/// How far faces may lie from each other and from where they should, metres.
#[derive(Clone, Copy, Debug)]
pub struct Spacing {
    /// Least distance from face to face.
    pub least_m: f32,
    /// Largest distance.
    pub most_m: f32,
    /// A face may stand this far from where its predecessors lead.
    pub tolerance_m: f32,
    /// A second flight may begin this far behind the first: on a landing. Less than
    /// [`Spacing::most_m`] for none.
    pub landing_m: f32,
}

/// A kind of stairs: how well a flight of it explains the echoes.
pub trait Stairs {
    /// What two flights of the same chain may differ in.
    type Shape: Copy + Default + core::fmt::Debug;

    /// The echoes.
    fn scene(&self) -> &Scene<'_>;
    /// Of stairs that people use.
    fn spacing(&self) -> Spacing;
    /// The columns that a flight may begin with, each with the shapes worth a try there.
    fn beginnings(&self) -> impl Iterator<Item = (usize, Self::Shape)>;
    /// Log-likelihood that `next` adds to the chain, nats.
    fn face(&self, chain: &[ChainLink], next: ChainLink, shape: Self::Shape) -> f32;
    /// Log-likelihood of everything behind the last face, nats.
    fn behind(&self, chain: &[ChainLink], shape: Self::Shape) -> f32;
    /// Log-likelihood of the best explanation without stairs, nats.
    fn null(&self) -> f32;
    /// What a mark is taken for if the flight is true.
    fn role(&self, mark: &Mark, chain: &[ChainLink], shape: Self::Shape) -> Role;
    /// Whether the treads float.
    fn open(shape: Self::Shape) -> bool;
    /// The flight in words.
    fn explanation(shape: Self::Shape) -> Explanation;

    /// Log-likelihood ratio of a whole flight against everything that is no stair, nats.
    fn whole(&self, chain: &[ChainLink], shape: Self::Shape) -> f32 {
        let faces = (0..chain.len()).filter_map(|k| {
            let (before, rest) = chain.split_at_checked(k)?;
            Some(self.face(before, *rest.first()?, shape))
        });
        faces.sum::<f32>() + self.behind(chain, shape) - self.null()
    }
}

/// A flight, or the beginning of one.
#[derive(Clone, Debug, Default)]
pub struct Flight<S> {
    /// Its faces.
    pub chain: Chain,
    /// Its shape.
    pub shape: S,
    /// Log-likelihood of its faces, nats.
    pub faces: f32,
    /// Log-likelihood ratio of the whole against everything that is no stair, nats.
    pub score: f32,
}
