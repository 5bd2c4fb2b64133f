//! The diffuse scatterers of a scene's facets, drawn once and cached, because all positions along a way use the same
//! ones.

use core::cell::RefCell;

use num_complex::Complex64;

use super::lateral::PATCH;
use super::maths::Random;

/// Number of the first stream of random numbers for scatterers: facet `k` uses stream `SCATTERERS + k`.
pub const SCATTERERS: u64 = 0x4449_4646_0000_0000;

/// Cache of the diffuse scatterers drawn by one seed, facet by facet.
pub struct Scatterers {
    seed: u64,
    facets: RefCell<Vec<Vec<Complex64>>>,
}

impl Scatterers {
    /// Creates an empty cache for the scatterers of `seed`.
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            facets: RefCell::default(),
        }
    }

    /// Runs `look` on the scatterers of facet `k`, at least the first `count`, which are drawn if the cache has fewer.
    pub fn with<T>(&self, k: usize, count: usize, look: impl FnOnce(&[Complex64]) -> T) -> T {
        let mut facets = self.facets.borrow_mut();
        if facets.len() <= k {
            facets.resize(k + 1, Vec::new());
        }
        let facet = &mut facets[k];
        if facet.len() < count {
            // Redrawn from the first one, with reserve: a facet comes nearer, and seldom needs
            // more.
            let mut rng = Random::new(self.seed, SCATTERERS + k as u64);
            facet.clear();
            facet.extend((0..2 * count).map(|_| rng.complex(PATCH)));
        }
        look(facet)
    }
}
