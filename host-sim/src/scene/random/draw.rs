//! Draws that several kinds of random scenes share.

use super::super::maths::Random;

/// What treads and floors are made of.
pub(super) const SOLID: [&str; 4] = ["painted-wood", "dark-ceramic", "concrete", "metal"];

/// One of `names`.
pub(super) fn pick(rng: &mut Random, names: &[&str]) -> String {
    names[rng.index(names.len())].into()
}

/// Which of a list of names with shares a seed shows, by turns.
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
