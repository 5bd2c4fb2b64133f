//! Random choices, and choices in turn by the seed, that several kinds of random scenes share.

use crate::scene::maths::Random;

/// Materials of treads and floors; each is drawn equally often.
pub(super) const SOLID: [&str; 4] = ["painted-wood", "dark-ceramic", "concrete", "metal"];

/// Returns one of `names`, drawn at random.
pub(super) fn pick(rng: &mut Random, names: &[&str]) -> String {
    names[rng.index(names.len())].into()
}

/// Returns the name for `seed` by taking turns: each name of the list holds for its number of consecutive seeds, then
/// the next one; after the last name the first follows again, and seed 0 begins the list.
pub(super) fn turn(list: &[(&'static str, usize)], seed: u64) -> &'static str {
    let total: usize = list.iter().map(|(_, n)| n).sum();
    let mut turn = (seed % total.max(1) as u64) as usize;
    for &(name, n) in list {
        if turn < n {
            return name;
        }
        turn -= n;
    }
    ""
}
