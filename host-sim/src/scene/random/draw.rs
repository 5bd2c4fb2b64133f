//! Draws shared by several kinds of random scenes.

use super::super::maths::Random;

/// Materials of treads and floors, in equal shares.
pub(super) const SOLID: [&str; 4] = ["painted-wood", "dark-ceramic", "concrete", "metal"];

/// Returns one of `names`, drawn at random.
pub(super) fn pick(rng: &mut Random, names: &[&str]) -> String {
    names[rng.index(names.len())].into()
}

/// Returns the name that `seed` selects in turn from a list of names, each with its number of consecutive seeds.
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
