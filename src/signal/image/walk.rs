//! Walk of the scatterers through the range bins while the chair moves.
//!
//! Seen from the chair's place at the scan's first row a scatterer has one *seen bin*. In each row, by the travel until then,
//! it is nearer by the row's *walk*: several bins between the first and the last row of a lobe. The rows are summed by their
//! seen bins. So that none of a row's bins is lost before all walks are known, the sums of a node begin at the seen bin of
//! the first bin of the node's first row.

/// Number of words in which the image's memory keeps the walk of a node.
pub const WORDS: usize = 3;

/// Walk of a node: the seen bin of its first cell, and the mean walk of its rows.
#[derive(Clone, Copy, Debug, Default)]
pub struct NodeWalk {
    /// Seen bin of the first cell.
    pub first: i32,
    sum: f32,
    weight: f32,
}

impl NodeWalk {
    /// Returns the walk of a node whose cells begin at a seen bin, without rows.
    pub fn new(first: i32) -> Self {
        Self {
            first,
            ..Self::default()
        }
    }

    /// Reads the walk from its words.
    pub fn from_words([first, sum, weight]: [u32; WORDS]) -> Self {
        Self {
            first: first as i32,
            sum: f32::from_bits(sum),
            weight: f32::from_bits(weight),
        }
    }

    /// Returns the walk in its words.
    pub fn to_words(self) -> [u32; WORDS] {
        [self.first as u32, self.sum.to_bits(), self.weight.to_bits()]
    }

    /// Adds a row's walk, in bins. A scatterer at the node has the filter's weight in the row's amplitude, and once more in
    /// the sum.
    pub fn add(&mut self, walk: f32, weight: f32) {
        self.sum += weight * weight * walk;
        self.weight += weight * weight;
    }

    /// Returns the mean walk, in bins: by how much a scatterer was nearer in its row than its seen bin says.
    pub fn mean(&self) -> f32 {
        match self.weight > 0.0 {
            true => self.sum / self.weight,
            false => 0.0,
        }
    }
}

/// Returns how many places of two sequences are to be left out at their beginnings, so that place k of the first and place
/// k + `by` of the second come together.
pub fn aligned(by: i32) -> (usize, usize) {
    let most = by.unsigned_abs() as usize;
    if by < 0 { (most, 0) } else { (0, most) }
}

/// Moves all values by `by` places towards the end, or towards the beginning if it is negative; values move out, and zeros in.
pub fn moved(values: &mut [u32], by: i32) {
    let (skipped, first) = aligned(by);
    let count = values.len();
    let mut take = |to: usize, from: Option<usize>| {
        let taken = from.and_then(|from| values.get(from)).copied();
        if let Some(place) = values.get_mut(to) {
            *place = taken.unwrap_or(0);
        }
    };
    if by > 0 {
        (0..count).rev().for_each(|k| take(k, k.checked_sub(first)));
    } else if by < 0 {
        (0..count).for_each(|k| take(k, k.checked_add(skipped)));
    }
}
