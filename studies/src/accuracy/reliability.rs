//! Tables of the reliability of reported probabilities.

use std::fmt::Write as _;

use super::weighted;
use host_sim::random::Kind;
use host_sim::score::{
    AnswerType, Bin, DEPTH_M, NEAR_DROP_M, Reliability, SetScore, Share, upper_bound,
};

/// Formats the median horizon of the `ok` answers as `1.42 m`; a dash without any.
fn horizon(set: &SetScore) -> String {
    match set.ok_horizon_m {
        None => "–".into(),
        Some(m) if m.is_finite() => format!("{m:.2} m"),
        Some(_) => "not reported".into(),
    }
}

/// Returns the line with the shares of exact answers, and of right and wrong `ok` answers, of all scenes.
pub fn total(all: &SetScore) -> String {
    format!(
        "All scenes together: exact {}; `ok` of what is not wrong {}; `ok` and wrong, of `ok`, {}; median horizon of \
         an `ok` {}.\n",
        all.exact.full(),
        all.ok_among_correct.full(),
        all.ok_and_wrong.full(),
        horizon(all)
    )
}

/// Returns the tables of wrong `ok` answers by type for all scenes together, and of the reported probabilities
/// (confidence and those of `MAYBE`s) against the outcomes.
pub fn tables(kinds: &[(Kind, SetScore, Share)], all: &SetScore) -> String {
    let mut out = total(all);
    out.push_str(
        "\n| type of answer | `ok` | of them wrong | upper 95 % bound (Clopper-Pearson) |\n\
         |---|---|---|---|\n",
    );
    // Without a reported drop there is no row and no line.
    let occurs = |kind: AnswerType| kind != AnswerType::Drop || all.drops > 0;
    let types = all.ok_and_wrong_by_type.into_iter();
    for (kind, Share { hits, of }) in types.filter(|(kind, _)| occurs(*kind)) {
        let name = kind.name();
        let bound = match of {
            0 => "–".to_owned(),
            of => format!("{:.2} %", 100.0 * upper_bound(hits, of)),
        };
        let _ = writeln!(out, "| {name} | {of} | {hits} | {bound} |");
    }
    out.push('\n');
    out.push_str(&weighted::table(kinds, &occurs));
    if all.drops > 0 {
        out.push_str(
            "| scenes | near drops reported | false drops | on scenes without one | with a depth | depth error: median, \
             95 %, too large |\n|---|---|---|---|---|---|\n",
        );
        for (kind, set, _) in kinds
            .iter()
            .filter(|(_, set, _)| set.reported_drops.of + set.drops > 0)
        {
            let _ = writeln!(out, "| {kind} | {} |", drops(set));
        }
        let _ = writeln!(
            out,
            "| all | {} |\n\nNear drops are those nearer than {NEAR_DROP_M:.1} m; a depth error is too large above {:.0} cm.\n",
            drops(all),
            100.0 * DEPTH_M
        );
    }
    if all.confidence.all.actual.of == 0 {
        out.push_str("No answer reports a confidence.\n");
        return out;
    }
    out.push_str(
        "An answer's confidence is the probability that nothing is wrong up to its horizon, or over \
         the first metre if that is farther. Predicted and actual share agree when they differ by \
         at most 5 points or two standard errors; bins of fewer than 30 answers are not \
         compared.\n\n| confidence | answers | predicted | right | agree |\n|---|---|---|---|---|\n",
    );
    bins(&mut out, &all.confidence);
    let _ = write!(
        out,
        "| all | {} |\n\n\
         | scenes | answers | predicted | right | agree |\n|---|---|---|---|---|\n",
        figures(&all.confidence.all)
    );
    for (kind, set, _) in kinds {
        let _ = writeln!(out, "| {kind} | {} |", figures(&set.confidence.all));
    }
    out.push_str(
        "\nA `MAYBE` is right when a true step stands within 10 cm of it, or a drop where it \
         reports a possible end of the ground.\n\n| probability | `MAYBE`s | predicted | right | \
         agree |\n|---|---|---|---|---|\n",
    );
    bins(&mut out, &all.maybes);
    let _ = writeln!(out, "| all | {} |", figures(&all.maybes.all));
    out
}

/// Adds to the text `out` one table row for each bin of reported probability: its range, and the comparison with the
/// outcomes.
fn bins(out: &mut String, reliability: &Reliability) {
    for bin in &reliability.bins {
        let percent = |v: f64| format!("{:.0}", 100.0 * v);
        let (from, to) = (percent(bin.from), percent(bin.to));
        let _ = writeln!(out, "| {from}–{to} % | {} |", figures(bin));
    }
}

/// Returns the table cells of a bin of reported probabilities as text: number of answers, mean predicted probability,
/// actual share of correct ones, and whether predicted and actual agree.
fn figures(bin: &Bin) -> String {
    let percent = |v: Option<f64>| v.map_or("–".into(), |v| format!("{:.1} %", 100.0 * v));
    let agree = match bin.agrees() {
        Some(true) => "yes",
        Some(false) => "**no**",
        None => "–",
    };
    format!(
        "{} | {} | {} | {agree}",
        bin.actual.of,
        percent(bin.predicted()),
        bin.actual.percent(),
    )
}

/// Returns the table cells that count reported and false drops, and the errors of their depths; a dash where nothing is
/// counted.
fn drops(set: &SetScore) -> String {
    let counted = |Share { hits, of }: Share| match of {
        0 => "–".to_owned(),
        _ => format!("{hits} of {of}"),
    };
    let depths = match set.depths.hits {
        0 => "–".to_owned(),
        _ => counted(set.depths),
    };
    let errors = set.depth.map_or("–".to_owned(), |depth| {
        format!(
            "{:.1} cm, {:.1} cm, {}",
            100.0 * depth.median,
            100.0 * depth.p95,
            counted(set.depths_off)
        )
    });
    format!(
        "{} | {} | {} | {depths} | {errors}",
        counted(set.reported_drops),
        set.false_drops,
        counted(set.false_drops_without),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use host_sim::score::{Prediction, SceneScore};
    use stairscan::answer::Direction;
    use stairscan::verdict::Status;

    /// Returns the score of an `ok` answer with the horizon `horizon_m`, metres, and the confidence `predicted`, and
    /// with a `MAYBE` of 15 %. `outcome`: whether the answer is correct and the possible step exists.
    fn scene(horizon_m: f64, predicted: f64, outcome: bool) -> SceneScore {
        SceneScore {
            recording: String::new(),
            set: String::new(),
            status: Status::Ok,
            direction: Direction::Up,
            reasons: String::new(),
            horizon_m,
            confidence: Some(Prediction { predicted, outcome }),
            maybes: vec![Prediction {
                predicted: 0.15,
                outcome,
            }],
            reports_drop: false,
            tells_depth: false,
            depth_error_m: None,
            near_drops: Share::default(),
            without_drop: true,
            false_drop: false,
            truth: Vec::new(),
            matches: Vec::new(),
            missed: Vec::new(),
            false_steps: Vec::new(),
            exact: outcome,
            wrong: !outcome,
            flaws: Vec::new(),
            covered: 0,
            false_stair: false,
            misleading: false,
        }
    }

    #[test]
    fn lines_tell_what_was_predicted_and_what_came_true() {
        // Of 40 answers with 96 % 8 are wrong, of 10 with 99.5 % none.
        let mut scenes = vec![scene(1.25, 0.96, true); 32];
        scenes.extend(vec![scene(1.25, 0.96, false); 8]);
        scenes.extend(vec![scene(1.5, 0.995, true); 10]);
        let set = || SetScore::new("all", scenes.iter());
        let text = tables(&[(Kind::None, set(), Share::default())], &set());
        let has = |line: &str| assert!(text.contains(line), "{line}\n{text}");
        has("| 95–97 % | 40 | 96.0 % | 80.0 % (65.2–89.5) | **no** |\n");
        has("| 99–100 % | 10 | 99.5 % | 100.0 % (72.2–100.0) | – |\n");
        has("| 0–50 % | 0 | – | – | – |\n");
        has("| none | 50 | 96.7 % | 84.0 % (71.5–91.7) | **no** |\n");
        has("median horizon of an `ok` 1.25 m");
        // 42 of 50 MAYBEs with 15 % are correct.
        has("| 10–20 % | 50 | 15.0 % | 84.0 % (71.5–91.7) | **no** |\n");
    }

    #[test]
    fn drops_are_reported_of_where_an_answer_has_one() {
        let quiet = scene(1.25, 0.96, true);
        let confident = SceneScore {
            direction: Direction::None,
            reports_drop: true,
            near_drops: Share::new(1, 1),
            without_drop: false,
            ..quiet.clone()
        };
        let text = |scenes: &[SceneScore]| {
            let set = || SetScore::new("all", scenes.iter());
            tables(&[(Kind::Brink, set(), Share::default())], &set())
        };
        let (without, with) = (
            text(std::slice::from_ref(&quiet)),
            text(&[quiet, confident]),
        );
        let quiet = !without.contains("a drop ahead") && !without.contains("drops");
        assert!(quiet, "{without}");
        assert!(
            with.contains("| a drop ahead | 1 | 0 | 95.00 % |"),
            "{with}"
        );
        let line = "| brink | 1 of 1 | 0 | 0 of 1 | – | – |\n";
        assert!(with.contains(line), "{with}");
    }

    #[test]
    fn an_estimator_without_confidence_says_so() {
        let mut silent = scene(f64::INFINITY, 0.9, true);
        silent.confidence = None;
        let set = SetScore::new("all", [silent].iter());
        let text = tables(&[], &set);
        assert!(
            text.contains("median horizon of an `ok` not reported"),
            "{text}"
        );
        assert!(
            text.ends_with("No answer reports a confidence.\n"),
            "{text}"
        );
    }
}
