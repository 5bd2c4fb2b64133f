//! Shares of successes in a number of draws, with their confidence intervals.

use serde_json::{Value, json};

/// Quantile of the standard normal distribution for a two-sided 95 % interval, standard deviations.
const Z95: f64 = 1.959_964;

/// Returns Wilson's 95 % score interval of a share `p` (0…1) from `n` draws (E. B. Wilson, Probable Inference, the
/// Law of Succession, and Statistical Inference, JASA 22, 1927). It stays within 0…1 and has a non-zero width also
/// for shares of 0 and 1.
pub(super) fn wilson(p: f64, n: f64) -> (f64, f64) {
    let z2 = Z95 * Z95;
    let middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = Z95 / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    ((middle - half).max(0.0), (middle + half).min(1.0))
}

/// Returns the probability of at most `k` successes in `n` draws, each with probability `p` (binomial).
pub fn at_most(k: usize, n: usize, p: f64) -> f64 {
    if k >= n || p <= 0.0 {
        return 1.0;
    }
    if p >= 1.0 {
        return 0.0;
    }
    let (so, not) = (libm::log(p), libm::log1p(-p));
    let (mut ln_choose, mut sum) = (0.0, 0.0);
    for j in 0..=k {
        if j > 0 {
            ln_choose += libm::log((n - j + 1) as f64 / j as f64);
        }
        sum += libm::exp(ln_choose + j as f64 * so + (n - j) as f64 * not);
    }
    sum.min(1.0)
}

/// Number of bisections of the interval 0…1 in the search for the upper confidence bound of a share, which is then
/// accurate to less than a millionth.
const HALVINGS: usize = 24;

/// Returns the upper 95 % confidence bound of a share from `hits` of `of` draws (Clopper and Pearson, Biometrika
/// 26, 1934); 1 without draws.
pub fn upper_bound(hits: usize, of: usize) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if of > 0 && at_most(hits, of, middle) <= 0.05 {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// A share: number of successes, such as correct answers, out of a number of draws, such as answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    /// Number of successes, the numerator of the share.
    pub hits: usize,
    /// Number of draws, successful or not: the denominator of the share.
    pub of: usize,
}

impl Share {
    /// Creates a share of `hits` successes in `of` draws.
    pub fn new(hits: usize, of: usize) -> Self {
        Self { hits, of }
    }

    /// Counts the items for which `so` holds, as a share of all `items`.
    pub fn count<T>(items: impl IntoIterator<Item = T>, so: impl Fn(T) -> bool) -> Self {
        let mut share = Self::default();
        for item in items {
            share.of += 1;
            share.hits += usize::from(so(item));
        }
        share
    }

    /// Returns the share, 0…1; `None` without draws.
    pub fn value(self) -> Option<f64> {
        (self.of > 0).then(|| self.hits as f64 / self.of as f64)
    }

    /// Returns Wilson's 95 % confidence interval of the share, 0…1; `None` without draws.
    pub fn interval(self) -> Option<(f64, f64)> {
        Some(wilson(self.value()?, self.of as f64))
    }

    /// Formats share and 95 % interval as `12.5 % (10.1–15.4)`; a dash without draws.
    pub fn percent(self) -> String {
        match (self.value(), self.interval()) {
            (Some(p), Some((low, high))) => {
                let percent = |v: f64| format!("{:.1}", 100.0 * v);
                format!("{} % ({}–{})", percent(p), percent(low), percent(high))
            }
            _ => "–".into(),
        }
    }

    /// Formats counts, share and 95 % interval as `1/8: 12.5 % (2.2–47.1)`; a dash without draws.
    pub fn full(self) -> String {
        match self.of {
            0 => "–".into(),
            _ => format!("{}/{}: {}", self.hits, self.of, self.percent()),
        }
    }

    /// Returns the numbers of successes and draws, and the share's 95 % confidence interval, as JSON.
    pub fn json(self) -> Value {
        json!({
            "count": self.hits,
            "of": self.of,
            "interval_95": self.interval().map(|(low, high)| [low, high]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table I of R. G. Newcombe, Two-sided confidence intervals for the single proportion,
    /// Statistics in Medicine 17 (1998), method 3.
    #[test]
    fn wilson_is_as_published() {
        for (hits, of, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let (a, b) = Share::new(hits, of).interval().unwrap();
            assert!(
                (a - low).abs() < 5e-5 && (b - high).abs() < 5e-5,
                "{hits}/{of}: {a} {b}"
            );
        }
        assert_eq!(Share::new(0, 0).interval(), None);
        assert_eq!(Share::new(0, 0).percent(), "–");
        let all = Share::new(40, 40).interval().unwrap();
        assert!(all.1 == 1.0 && all.0 > 0.9 && all.0 < 1.0);
    }

    #[test]
    fn counting() {
        assert_eq!(Share::count([1, 2, 3, 4], |n| n > 2), Share::new(2, 4));
        assert_eq!(Share::new(1, 8).percent(), "12.5 % (2.2–47.1)");
        assert_eq!(Share::new(1, 8).full(), "1/8: 12.5 % (2.2–47.1)");
    }
}
