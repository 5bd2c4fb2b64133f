//! Numbers with their nouns, for messages.

use std::fmt::Display;

/// Returns `1 scan`, `2 scans`: a number with its noun, which makes its plural with an s.
pub fn counted<N: Display + PartialEq + From<u8>>(count: N, noun: &str) -> String {
    let plural = if count == N::from(1) { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn one_is_singular() {
        let all = [0_usize, 1, 2].map(|n| counted(n, "guard sweep"));
        assert_eq!(all, ["0 guard sweeps", "1 guard sweep", "2 guard sweeps"]);
        assert_eq!(counted(1_u32, "scan"), "1 scan");
    }
}
