//! Share of wrong `ok` answers with weights for how often a chair meets each kind of scene, independent of the
//! numbers in a draw.

use std::fmt::Write as _;

use host_sim::random::Kind;
use host_sim::score::{AnswerType, SetScore, Share, upper_bound};

/// Returns the frequency, relative to the other kinds, of a kind of scene among the places that a chair approaches. The
/// frequencies are assumptions: studies of what wheelchair users meet count complaints or rate the difficulty of
/// barriers (Meyers et al. 2002; Harris, Yang and Sanford 2015), not their frequency. Assumed is a chair that mostly
/// drives on level ground, past objects; kerbs are ten times as frequent as a platform; entrances half as frequent as
/// kerbs; stairs, most of them regular, as frequent downward as upward.
fn met(kind: Kind) -> f64 {
    match kind {
        Kind::None => 400.0,
        Kind::Clutter => 200.0,
        Kind::Kerb => 120.0,
        Kind::Entrance => 60.0,
        Kind::Ascending => 60.0,
        Kind::Descending | Kind::Downstairs => 50.0,
        Kind::Brink => 15.0,
        Kind::Platform | Kind::Uneven | Kind::Soft | Kind::Beside => 12.0,
        Kind::Landing | Kind::Low | Kind::Irregular | Kind::Odd | Kind::Open => 10.0,
        Kind::Steep | Kind::Hole | Kind::Mounting => 5.0,
        // A state of the chair, not a place.
        Kind::Vibrating => 0.0,
    }
}

/// Weighted `ok` answers of one type (no steps, steps up, steps down): share of wrong ones, its upper 95 % bound, and
/// effective number of answers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Weighted {
    wrong: f64,
    bound: f64,
    effective: usize,
}

impl Weighted {
    /// Returns the weighted share of wrong answers with its bound; `None` without answers. `kinds` holds for each kind
    /// of scene the weight of one answer, and its `ok` answers, of which the hits are the wrong ones. The bound is that
    /// of Clopper and Pearson for the effective number of answers (Kish 1965: the square of the weights' sum over the
    /// sum of their squares), rounded up.
    fn of(kinds: &[(f64, Share)]) -> Option<Self> {
        let sum = |f: &dyn Fn(f64, Share) -> f64| kinds.iter().map(|(w, s)| f(*w, *s)).sum::<f64>();
        let weights = sum(&|w, s| w * s.of as f64);
        if weights <= 0.0 {
            return None;
        }
        let wrong = sum(&|w, s| w * s.hits as f64) / weights;
        let effective = (weights * weights / sum(&|w, s| w * w * s.of as f64)) as usize;
        Some(Self {
            wrong,
            bound: upper_bound((wrong * effective as f64).ceil() as usize, effective),
            effective,
        })
    }
}

/// Returns the table of wrong `ok` answers by type, for the types that `occurs` selects, with equal weights of the
/// kinds and with their assumed frequencies.
pub fn table(kinds: &[(Kind, SetScore, Share)], occurs: &dyn Fn(AnswerType) -> bool) -> String {
    let mut out = String::from(
        "Share of them that is wrong, its upper 95 % bound, and the effective number of answers \
         (Kish), with all kinds of scene alike, or as often as a chair is assumed to meet \
         each.\n\n| type of answer | alike | met |\n|---|---|---|\n",
    );
    let types = AnswerType::ALL.into_iter().enumerate();
    for (k, kind) in types.filter(|(_, kind)| occurs(*kind)) {
        let by = |weight: &dyn Fn(Kind) -> f64| {
            let answers: Vec<(f64, Share)> = kinds
                .iter()
                .map(|(scenes, set, _)| {
                    let each = weight(*scenes) / set.scenes.max(1) as f64;
                    (each, set.ok_and_wrong_by_type[k].1)
                })
                .collect();
            Weighted::of(&answers).map_or("–".to_owned(), |w| {
                let (wrong, bound) = (100.0 * w.wrong, 100.0 * w.bound);
                format!("{wrong:.2} %, at most {bound:.2} % ({})", w.effective)
            })
        };
        let (alike, met) = (by(&|_| 1.0), by(&met));
        let _ = writeln!(out, "| {} | {alike} | {met} |", kind.name());
    }
    out.push('\n');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alike_weights_are_none_and_a_heavy_kind_counts_for_few() {
        let alike = Weighted::of(&[(0.5, Share::new(1, 100)), (0.5, Share::new(3, 300))]).unwrap();
        assert_eq!((alike.wrong, alike.effective), (0.01, 400));
        assert_eq!(alike.bound, upper_bound(4, 400));
        // Nine tenths of the weight are on ten answers.
        let heavy = Weighted::of(&[(9.0, Share::new(0, 10)), (0.1, Share::new(5, 100))]).unwrap();
        assert!((heavy.wrong - 0.005).abs() < 1e-12, "{heavy:?}");
        assert_eq!(heavy.effective, 12);
        assert_eq!(heavy.bound, upper_bound(1, 12));
        assert_eq!(Weighted::of(&[(1.0, Share::new(0, 0))]), None);
    }
}
