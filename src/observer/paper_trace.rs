//! Intermediate results of the paper's estimator for an observer: its particles and clusters.

/// Stages of the paper's particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CloudStage {
    /// Initial particles, in cells of the map (angle, range).
    Drawn,
    /// Particles after a round of resampling, in cells of the map.
    Resampled,
    /// Particles in the sagittal plane (along, across), labelled with their clusters.
    Clustered,
    /// Particles after fusion and rejection of clusters; those of rejected clusters keep their labels.
    Rejected,
}

/// Number of coordinate units per cell (row or range bin) of the map. It keeps rounding below 0.2 mm and 0.004°, and
/// the largest map within 16 bits.
pub const UNITS_PER_CELL: i16 = 64;

/// One particle: a weighted sample in two coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PointParticle {
    /// Coordinates: angle and range in 1/64 cell of the map, or, once clustered, along and across the axis of the
    /// mirror's angle in 1/64 range bin.
    pub at: [i16; 2],
    /// Weight, not normalised.
    pub weight: u16,
    /// Number of copies during resampling; index of the particle's cluster afterwards.
    pub mark: u16,
}

impl PointParticle {
    /// Returns the cell (row, bin) of the map in which a particle with the coordinates angle and range lies; `None`
    /// if a coordinate is before the first cell.
    pub fn cell(&self) -> Option<(usize, usize)> {
        let unit = i32::from(UNITS_PER_CELL);
        let [row, bin] = self
            .at
            .map(|c| usize::try_from((i32::from(c) + unit / 2).div_euclid(unit)));
        Some((row.ok()?, bin.ok()?))
    }
}

/// Result of the paper's rejection rules for a cluster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ClusterVerdict {
    /// The cluster is a step.
    #[default]
    Kept,
    /// Too few particles: scatter that did not converge.
    Outlier,
    /// Part of the same object as the cluster with this index, and fused with it.
    Fused(u16),
    /// Part of an object that another, larger cluster represents.
    Redundant,
}

/// A cluster as the rejection rules see it: particle count and mean position, by which they decide, and their result.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent {
    /// Number of the cluster's particles.
    pub count: u16,
    /// Mean position along the axis from which the mirror's angle is measured (the depth of stairs going up; for
    /// stairs going down the height, positive downwards), metres from the mirror.
    pub along_m: f32,
    /// Mean position across the axis from which the mirror's angle is measured (the height of stairs going up,
    /// positive upwards; for stairs going down the depth, negative forward), metres from the mirror.
    pub across_m: f32,
    /// Result of the rejection rules for the cluster.
    pub verdict: ClusterVerdict,
}

impl Extent {
    /// Whether this cluster represents an object rather than `other`: the one with more particles, of equal ones the
    /// higher one.
    pub(crate) fn precedes(&self, other: &Self) -> bool {
        self.count > other.count || (self.count == other.count && self.across_m > other.across_m)
    }
}
