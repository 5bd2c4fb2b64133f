//! Clusters: Fuzzy ART, and the paper's rules to reject clusters that are not steps (paper III-B).

pub use crate::observer::paper_trace::{ClusterVerdict, Extent};
use heapless::Vec;

/// Maximum number of clusters of a scan.
pub const MAX_CLUSTERS: usize = 64;

/// Mark of a particle without a cluster.
pub const NO_CLUSTER: u16 = u16::MAX;

/// Result of [`FuzzyArt`] for one input: the category that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Match {
    /// Index of the category in [`FuzzyArt::categories`].
    pub category: u16,
    /// Whether the category is new or had to grow.
    pub learned: bool,
}

/// One category of [`FuzzyArt`], a cluster: the bounding box of all its inputs, which is equivalent to a weight
/// vector of complement-coded inputs with fast learning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Category<const F: usize> {
    /// Minimum of each feature over the inputs.
    pub low: [u8; F],
    /// Maximum of each feature over the inputs.
    pub high: [u8; F],
    /// |w| = Σ low + (255 - high) over the features: the smaller, the larger the box.
    norm: u16,
}

impl<const F: usize> Category<F> {
    /// Maximum |w|: that of a box which is a single point.
    const NORM: u16 = 255 * F as u16;

    fn point(input: &[u8; F]) -> Self {
        Self {
            low: *input,
            high: *input,
            norm: Self::NORM,
        }
    }

    /// Returns |w| - |I ∧ w|: the growth of the box that includes `input`.
    #[inline]
    fn growth(&self, input: &[u8; F]) -> u16 {
        (self.low.iter().zip(&self.high).zip(input))
            .map(|((&low, &high), &value)| {
                u16::from(low.saturating_sub(value)) + u16::from(value.saturating_sub(high))
            })
            .sum()
    }

    /// Extends the box to include `input`: w becomes I ∧ w.
    fn learn(&mut self, input: &[u8; F]) {
        self.norm -= self.growth(input).min(self.norm);
        for ((low, high), &value) in self.low.iter_mut().zip(&mut self.high).zip(input) {
            *low = (*low).min(value);
            *high = (*high).max(value);
        }
    }
}

/// Fuzzy ART (Carpenter, Grossberg, Rosen 1991) on complement-coded inputs of `F` bytes, with fast learning (β = 1)
/// and in the conservative limit (α → 0).
///
/// An input goes to the category with the largest choice |I ∧ w| / (α + |w|) among those that match, |I ∧ w| ≥ ρ |I|.
/// If none matches, the input becomes a new category. Choices are compared by cross-multiplication, without a
/// division, so the result is exact.
#[derive(Clone, Debug)]
pub struct FuzzyArt<const F: usize, const C: usize> {
    categories: Vec<Category<F>, C>,
    least_norm: u32,
}

impl<const F: usize, const C: usize> FuzzyArt<F, C> {
    /// Returns a network without categories, with the vigilance ρ in thousandths.
    pub fn new(vigilance: u16) -> Self {
        let least = u32::from(Category::<F>::NORM) * u32::from(vigilance.min(1000));
        Self {
            categories: Vec::new(),
            least_norm: least.div_ceil(1000),
        }
    }

    /// Returns the categories, the oldest first.
    pub fn categories(&self) -> &[Category<F>] {
        &self.categories
    }

    /// Presents one input and learns from it. Returns `None` if no category matches and there is no room for a new
    /// one.
    pub fn present(&mut self, input: &[u8; F]) -> Option<Match> {
        let mut best: Option<(usize, u32, u32)> = None;
        for (k, category) in self.categories.iter().enumerate() {
            let norm = u32::from(category.norm);
            let matched = norm.saturating_sub(u32::from(category.growth(input)));
            if matched < self.least_norm {
                continue;
            }
            // Of equal choices, α prefers the smaller box, and then the order prefers the older one.
            let better = best.is_none_or(|(_, best_matched, best_norm)| {
                let (this, other) = (matched * best_norm, best_matched * norm);
                this > other || (this == other && norm > best_norm)
            });
            if better {
                best = Some((k, matched, norm));
            }
        }
        let Some((k, matched, norm)) = best else {
            let category = self.categories.len() as u16;
            self.categories.push(Category::point(input)).ok()?;
            return Some(Match {
                category,
                learned: true,
            });
        };
        let learned = matched < norm;
        if let (true, Some(category)) = (learned, self.categories.get_mut(k)) {
            category.learn(input);
        }
        Some(Match {
            category: k as u16,
            learned,
        })
    }

    /// Presents all `items` in their order, repeatedly until an epoch changes nothing, at most `epochs` times.
    /// `features` returns an item's input, `mark` the place for its category ([`NO_CLUSTER`] for none). Returns the
    /// number of epochs.
    pub fn settle<T>(
        &mut self,
        items: &mut [T],
        epochs: u8,
        features: impl Fn(&T) -> [u8; F],
        mark: impl Fn(&mut T) -> &mut u16,
    ) -> u8 {
        for epoch in 1..=epochs {
            let mut quiet = true;
            for item in items.iter_mut() {
                let answer = self.present(&features(item));
                let category = answer.map_or(NO_CLUSTER, |m| m.category);
                let place = mark(item);
                quiet &= *place == category && answer.is_none_or(|m| !m.learned);
                *place = category;
            }
            if quiet {
                return epoch;
            }
        }
        epochs
    }
}

/// Marks those `clusters` as outliers that are empty or hold fewer than 10 % of the mean particle count of a cluster.
pub fn reject_outliers(clusters: &mut [Extent]) {
    const SHARE: u32 = 10;
    let total: u32 = clusters.iter().map(|c| u32::from(c.count)).sum();
    let number = clusters.iter().filter(|c| c.count > 0).count() as u32;
    for cluster in clusters {
        if u32::from(cluster.count) * number * SHARE < total || cluster.count == 0 {
            cluster.verdict = ClusterVerdict::Outlier;
        }
    }
}

/// Calls `judge` with the index of each kept cluster, the one with the most particles first, and sets the cluster's
/// `verdict` to the result that it returns.
fn by_precedence(
    clusters: &mut [Extent],
    mut judge: impl FnMut(&[Extent], usize, &Extent) -> ClusterVerdict,
) {
    let mut judged: u64 = 0;
    for _ in 0..clusters.len().min(MAX_CLUSTERS) {
        let next = (clusters.iter().enumerate().take(MAX_CLUSTERS))
            .filter(|(k, c)| c.verdict == ClusterVerdict::Kept && judged & (1 << k) == 0)
            .reduce(|best, c| if c.1.precedes(best.1) { c } else { best })
            .map(|(k, c)| (k, *c));
        let Some((k, cluster)) = next else { return };
        let fate = judge(clusters, k, &cluster);
        judged |= 1 << k;
        if let Some(cluster) = clusters.get_mut(k) {
            cluster.verdict = fate;
        }
    }
}

/// Marks clusters that are close along the axis of the mirror's angle as fused. Each kept cluster that is closer than
/// `spacing_m` to one with more particles is fused with the nearest of those: a riser is one object, whatever its
/// height and however uneven its echoes.
pub fn fuse(clusters: &mut [Extent], spacing_m: f32) {
    let mut objects: u64 = 0;
    by_precedence(clusters, |clusters, k, cluster| {
        let nearest = (clusters.iter().enumerate().take(MAX_CLUSTERS))
            .filter(|(object, _)| objects & (1 << object) != 0)
            .map(|(object, c)| (object, (c.along_m - cluster.along_m).abs()))
            .filter(|&(_, distance)| distance < spacing_m)
            .reduce(|a, b| if b.1 < a.1 { b } else { a });
        match nearest {
            Some((object, _)) => ClusterVerdict::Fused(object as u16),
            None => {
                objects |= 1 << k;
                ClusterVerdict::Kept
            }
        }
    });
}

/// Marks one of each pair of kept clusters closer than `spacing_m` along or across the axis as redundant: the one
/// with fewer particles, of equal ones the lower one.
///
/// Clusters are processed from the largest on, so that a cluster that is itself redundant makes no other one
/// redundant.
pub fn reject_redundant(clusters: &mut [Extent], spacing_m: f32) {
    let mut objects: u64 = 0;
    by_precedence(clusters, |clusters, k, cluster| {
        let near = (clusters.iter().enumerate().take(MAX_CLUSTERS)).any(|(object, c)| {
            objects & (1 << object) != 0
                && ((c.along_m - cluster.along_m).abs() < spacing_m
                    || (c.across_m - cluster.across_m).abs() < spacing_m)
        });
        if near {
            return ClusterVerdict::Redundant;
        }
        objects |= 1 << k;
        ClusterVerdict::Kept
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Returns the category index of each of `inputs` in their order, and the trained network.
    fn settle<const F: usize>(
        inputs: &[[u8; F]],
        vigilance: u16,
    ) -> (std::vec::Vec<u16>, FuzzyArt<F, 8>) {
        let mut art = FuzzyArt::new(vigilance);
        let mut items: std::vec::Vec<([u8; F], u16)> =
            inputs.iter().map(|&i| (i, NO_CLUSTER)).collect();
        art.settle(&mut items, 10, |i| i.0, |i| &mut i.1);
        (items.iter().map(|i| i.1).collect(), art)
    }

    #[test]
    fn a_box_grows_as_far_as_the_vigilance_lets_it() {
        // One feature, ρ = 0.8: |I ∧ w| = 255 - box ≥ 204, so a box may be at most 51 wide.
        let (marks, art) = settle(&[[0], [51], [52], [103], [104]], 800);
        assert_eq!(marks, [0, 0, 1, 1, 2]);
        assert_eq!(art.categories()[1].low, [52]);
        assert_eq!(art.categories()[1].high, [103]);
    }

    #[test]
    fn a_category_is_chosen_by_the_choice_function() {
        // Computed by hand: two features, norm 510. After the first three inputs A = (0,0)…(100,0) with |w| = 410 and
        // B = the point (200,0) with |w| = 510. The input (150,0) gives A: |I ∧ w| = 360, T = 360/410 = 0.878; B:
        // 460, T = 460/510 = 0.902: it goes to B.
        let mut art = FuzzyArt::<2, 8>::new(700);
        assert_eq!(art.present(&[0, 0]).unwrap().category, 0);
        assert_eq!(art.present(&[100, 0]).unwrap().category, 0);
        assert_eq!(art.present(&[200, 0]).unwrap().category, 1);
        let answer = art.present(&[150, 0]).unwrap();
        assert_eq!((answer.category, answer.learned), (1, true));
        // 125 is 25 to the right of A's edge and 25 to the left of B's (150…200). A loses the larger share of its
        // smaller norm, 385/410 = 0.939 against 435/460 = 0.946.
        assert_eq!(art.present(&[125, 0]).unwrap().category, 1);
    }

    #[test]
    fn of_two_boxes_around_an_input_the_smaller_takes_it() {
        let mut art = FuzzyArt::<1, 8>::new(0);
        for (low, high) in [([100], [200]), ([120], [170]), ([110], [160])] {
            let mut category = Category::point(&low);
            category.learn(&high);
            art.categories.push(category).unwrap();
        }
        // Within all three boxes T = |w| / (α + |w|), which is 1 for α → 0. For α > 0 the smaller box has the larger
        // T; of the two equal ones the older one is chosen.
        let answer = art.present(&[145]).unwrap();
        assert_eq!((answer.category, answer.learned), (1, false));
    }

    #[test]
    fn the_ends_of_the_vigilance() {
        let inputs = [[0, 0], [255, 255], [0, 0], [3, 9], [255, 0]];
        assert_eq!(settle(&inputs, 0).0, [0; 5]);
        assert_eq!(settle(&inputs, 1000).0, [0, 1, 0, 2, 3]);
        assert_eq!(settle(&inputs, u16::MAX).0, [0, 1, 0, 2, 3]);
    }

    #[test]
    fn what_finds_no_room_stays_without_a_cluster() {
        let inputs: std::vec::Vec<[u8; 1]> = (0..9).map(|k| [k]).collect();
        let (marks, _) = settle(&inputs, 1000);
        assert_eq!(marks, [0, 1, 2, 3, 4, 5, 6, 7, NO_CLUSTER]);
    }

    fn extents(of: &[(u16, f32, f32)]) -> std::vec::Vec<Extent> {
        of.iter()
            .map(|&(count, along_m, across_m)| Extent {
                count,
                along_m,
                across_m,
                verdict: ClusterVerdict::Kept,
            })
            .collect()
    }

    fn fates(of: &[Extent]) -> std::vec::Vec<ClusterVerdict> {
        of.iter().map(|c| c.verdict).collect()
    }

    #[test]
    fn outliers_are_fewer_than_a_tenth_of_the_mean() {
        use ClusterVerdict::{Kept, Outlier};
        // Mean 50: 5 is a tenth of it and stays.
        let mut clusters = extents(&[(95, 0.0, 0.0), (5, 1.0, 1.0)]);
        reject_outliers(&mut clusters);
        assert_eq!(fates(&clusters), [Kept, Kept]);
        // Mean 50.5: 5 is less than a tenth.
        let mut clusters = extents(&[(96, 0.0, 0.0), (5, 1.0, 1.0)]);
        reject_outliers(&mut clusters);
        assert_eq!(fates(&clusters), [Kept, Outlier]);
    }

    #[test]
    fn redundant_clusters_are_closer_than_the_spacing_in_depth_or_height() {
        use ClusterVerdict::{Kept, Redundant};
        // 0.125 m is exact in binary, so the bound itself can be tested.
        let check = |other: (u16, f32, f32), expected| {
            let mut clusters = extents(&[(10, 1.0, 1.0), other]);
            reject_redundant(&mut clusters, 0.125);
            assert_eq!(fates(&clusters), expected, "{other:?}");
        };
        check((9, 1.125, 1.125), [Kept, Kept]);
        check((9, 1.124, 2.0), [Kept, Redundant]);
        check((9, 2.0, 0.876), [Kept, Redundant]);
        check((11, 1.0, 2.0), [Redundant, Kept]);
        check((10, 1.0, 0.9), [Kept, Redundant]);
        check((10, 1.0, 1.1), [Redundant, Kept]);
    }

    #[test]
    fn a_redundant_cluster_takes_no_other_with_it() {
        use ClusterVerdict::{Kept, Outlier, Redundant};
        let mut clusters = extents(&[(5, 1.16, 1.16), (9, 1.08, 1.08), (10, 1.0, 1.0)]);
        reject_redundant(&mut clusters, 0.1);
        assert_eq!(fates(&clusters), [Kept, Redundant, Kept]);
        let mut clusters = extents(&[(5, 1.0, 1.0), (9, 1.0, 1.0)]);
        clusters[1].verdict = Outlier;
        reject_redundant(&mut clusters, 0.1);
        assert_eq!(fates(&clusters), [Kept, Outlier]);
    }

    #[test]
    fn an_object_is_fused_from_what_is_close_along_the_axis() {
        use ClusterVerdict::{Fused, Kept, Outlier};
        // 0.125 m is exact in binary, so the bound itself can be tested.
        let mut clusters = extents(&[
            (9, 1.1, 0.0),
            (10, 1.0, 0.5),
            (8, 1.2, 1.0),
            (7, 1.125, 1.0),
            (6, 1.251, 1.0),
        ]);
        clusters[4].verdict = Outlier;
        fuse(&mut clusters, 0.125);
        assert_eq!(fates(&clusters), [Fused(1), Kept, Kept, Fused(2), Outlier],);
        let mut clusters = extents(&[(10, 1.0, 0.0), (9, 1.125, 0.0)]);
        fuse(&mut clusters, 0.125);
        assert_eq!(fates(&clusters), [Kept, Kept]);
    }

    #[test]
    fn clusters_that_lost_all_particles_are_outliers_and_do_not_count() {
        use ClusterVerdict::{Kept, Outlier};
        // Mean of the two remaining clusters: 50.5.
        let mut clusters = extents(&[(96, 0.0, 0.0), (0, 0.0, 0.0), (5, 1.0, 1.0)]);
        reject_outliers(&mut clusters);
        assert_eq!(fates(&clusters), [Kept, Outlier, Outlier]);
    }

    proptest! {
        #[test]
        fn settled_boxes_hold_their_inputs_and_obey_the_vigilance(
            inputs in proptest::collection::vec(any::<[u8; 3]>(), 1..100),
            vigilance in 0_u16..=1000,
        ) {
            let (marks, art) = settle(&inputs, vigilance);
            for category in art.categories() {
                let size: u16 = (category.low.iter().zip(&category.high))
                    .map(|(&low, &high)| u16::from(high) - u16::from(low))
                    .sum();
                prop_assert_eq!(category.norm, 765 - size);
                prop_assert!(1000 * u32::from(category.norm) >= 765 * u32::from(vigilance));
            }
            for (input, &mark) in inputs.iter().zip(&marks) {
                let Some(category) = art.categories().get(usize::from(mark)) else {
                    prop_assert_eq!(mark, NO_CLUSTER);
                    continue;
                };
                prop_assert_eq!(category.growth(input), 0);
            }
        }

        #[test]
        fn kept_clusters_are_apart(
            list in proptest::collection::vec((0_u16..50, 0.0_f32..2.0, 0.0_f32..2.0), 0..80),
        ) {
            let mut clusters = extents(&list);
            reject_outliers(&mut clusters);
            reject_redundant(&mut clusters, 0.1);
            let kept: std::vec::Vec<&Extent> = clusters
                .iter()
                .take(MAX_CLUSTERS)
                .filter(|c| c.verdict == ClusterVerdict::Kept)
                .collect();
            for (k, a) in kept.iter().enumerate() {
                for b in &kept[..k] {
                    prop_assert!((a.along_m - b.along_m).abs() >= 0.1);
                    prop_assert!((a.across_m - b.across_m).abs() >= 0.1);
                }
            }
        }
    }
}
