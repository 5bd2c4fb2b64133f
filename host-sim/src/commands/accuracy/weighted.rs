//! The share of `ok` answers that is wrong where kinds of scenes are met as often as said, whatever a draw holds of each.

use std::fmt::Write as _;

use crate::scene::random::Kind;
use crate::score::{AnswerType, SetScore, Share, upper_bound};

/// How often a chair meets a kind, per 1,000 places that it is driven up to. By assumption: studies of what wheelchair
/// users meet count complaints or rate how hard barriers are (Meyers et al. 2002; Harris, Yang and Sanford 2015), not how
/// often each is met. Assumed are a chair that mostly drives on level ground, past things that stand about; kerbs ten
/// times as often as a platform; entrances half as often as kerbs; and stairs, most of them regular, as often down as up.
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
    }
}

/// `ok` answers of a type, weighted: which share of them is wrong, and its upper 95 % bound.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Weighted {
    wrong: f64,
    bound: f64,
    effective: usize,
}

impl Weighted {
    /// From the weight of each scene of a kind and its `ok` answers. The bound is Clopper and Pearson's of as many
    /// answers of one weight as know a mean as well (Kish 1965: the weights' squared sum over the sum of their squares),
    /// rounded up.
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

/// Each type of answer that is `told`, its kinds weighted alike and as they are met.
pub fn table(kinds: &[(Kind, SetScore, Share)], told: &dyn Fn(AnswerType) -> bool) -> String {
    let mut out = String::from(
        "The same by type, but that each kind of scene counts as if it were met as often as every other (alike), or as \
         often as a chair meets it (met; an assumption, in `host-sim/src/commands/accuracy/weighted.rs`): share of the \
         `ok` answers that is wrong, its upper 95 % bound, and in brackets how many answers of one weight are known as \
         well (Kish).\n\n\
         | type of answer | alike | met |\n\
         |---|---|---|\n",
    );
    let types = AnswerType::ALL.into_iter().enumerate();
    for (k, kind) in types.filter(|(_, kind)| told(*kind)) {
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
        // Nine tenths of the weight lie on ten answers.
        let heavy = Weighted::of(&[(9.0, Share::new(0, 10)), (0.1, Share::new(5, 100))]).unwrap();
        assert!((heavy.wrong - 0.005).abs() < 1e-12, "{heavy:?}");
        assert_eq!(heavy.effective, 12);
        assert_eq!(heavy.bound, upper_bound(1, 12));
        assert_eq!(Weighted::of(&[(1.0, Share::new(0, 0))]), None);
    }
}
