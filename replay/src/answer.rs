//! A scan's answer, parsed from the sentences of the report UART.
//!
//! Both `replay` and `emulate` print from here, so that their outputs differ only in the sentences.

use std::fmt::Write as _;

use anyhow::{Context, Result, bail, ensure};
use serde_json::{Value, json};
use stairscan::answer::{Direction, Slope};
use stairscan::report::{DropLine, MaybeLine, ScanLine, Sentence, StepLine, Tenths};
use stairscan::verdict::{Status, free_m, promised};

/// The sentences that answer one scan, and their contents.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Base name of the recording.
    pub recording: String,
    /// Number of the scan in the recording, from 1; `None` if the recording has only one.
    pub part: Option<u32>,
    /// The sentences as received, without line ends.
    pub sentences: Vec<String>,
    /// Horizon of the answer, metres from the mirror; `None` if the sentences do not contain it.
    pub horizon_m: Option<f64>,
    /// Content of the `SCAN` sentence: status, direction, counts and confidence.
    pub scan: ScanLine,
    /// Contents of the `STEP` sentences, nearest first.
    pub steps: Vec<StepLine>,
    /// Content of the `DROP` sentence, the edge of a drop; `None` if no drop is reported.
    pub drop: Option<DropLine>,
    /// Contents of the `MAYBE` sentences, the possible steps, nearest first.
    pub maybes: Vec<MaybeLine>,
}

/// Converts a length of a sentence (0.1 mm) to metres.
pub fn metres(length: Tenths) -> f64 {
    f64::from(length.0) / 10_000.0
}

/// Formats the edge of a drop: `  91.2 cm: the ground ends, not before 86.7 cm, 18 cm deep (97 %)`.
pub fn drop_words(drop: &DropLine) -> String {
    let depth = drop.depth.map_or(String::new(), |depth| {
        format!(", {:.0} cm deep", 100.0 * metres(depth))
    });
    format!(
        "{:6.1} cm: the ground ends, not before {:.1} cm{depth} ({:.0} %)",
        100.0 * metres(drop.distance),
        100.0 * nearest_m(drop),
        f64::from(drop.probability) / 10.0
    )
}

/// Returns the nearest place of a drop's edge, metres from the mirror: distance − 3σ.
pub fn nearest_m(drop: &DropLine) -> f64 {
    metres(Tenths::from_metres(drop.edge().nearest_m()))
}

/// Formats a possible step (`MAYBE`): `  80.0 cm: something 15 cm high may stand (12 %)`.
pub fn maybe_words(maybe: &MaybeLine) -> String {
    let what = if maybe.height.0 < 0 {
        "the ground may end".to_owned()
    } else {
        let height = 100.0 * metres(maybe.height);
        format!("something {height:.0} cm high may stand")
    };
    format!(
        "{:6.1} cm: {what} ({:.0} %)",
        100.0 * metres(maybe.distance),
        f64::from(maybe.probability) / 10.0
    )
}

impl Answer {
    /// Parses the sentences of one scan of the recording named `recording`.
    pub fn parse(recording: &str, sentences: Vec<String>) -> Result<Self> {
        let mut scan = None;
        let mut steps = Vec::new();
        let mut drops = Vec::new();
        let mut maybes = Vec::new();
        for line in &sentences {
            let sentence =
                Sentence::parse(line).with_context(|| format!("{recording}: sentence {line}"))?;
            match sentence {
                Sentence::Scan(head) if scan.is_none() => scan = Some(head),
                Sentence::Step(step) => steps.push(step),
                Sentence::Drop(drop) => drops.push(drop),
                Sentence::Maybe(maybe) => maybes.push(maybe),
                other => bail!("{recording}: unexpected sentence {other:?}"),
            }
        }
        let mut scan = scan.with_context(|| format!("{recording}: no SCAN sentence"))?;
        (scan.status, scan.reasons) = promised(scan.status, scan.reasons, scan.horizon.is_some());
        ensure!(
            steps.len() == usize::from(scan.steps),
            "{recording}: {} STEP sentences, {} announced",
            steps.len(),
            scan.steps
        );
        ensure!(
            drops.len() == usize::from(scan.drops) && drops.len() <= 1,
            "{recording}: {} DROP sentences, {} announced, at most 1 expected",
            drops.len(),
            scan.drops
        );
        ensure!(
            maybes.len() == usize::from(scan.possible_steps),
            "{recording}: {} MAYBE sentences, {} announced",
            maybes.len(),
            scan.possible_steps
        );
        Ok(Self {
            recording: recording.to_owned(),
            part: None,
            horizon_m: scan.horizon.map(metres),
            sentences,
            scan,
            steps,
            drop: drops.pop(),
            maybes,
        })
    }

    /// Returns the slope of the ground; `None` where it is level or not seen to slope.
    pub fn slope(&self) -> Option<Slope> {
        self.scan.ground.map(|ground| ground.slope())
    }

    /// Whether the status is `fault`.
    pub fn is_fault(&self) -> bool {
        self.scan.status == Status::Fault
    }

    /// Returns the distance without steps and drops ahead, metres from the mirror; `None` if there
    /// is none according to [`free_m`].
    pub fn free_m(&self) -> Option<f64> {
        let first = self.steps.first().map(|step| step.distance.metres());
        let edge = self.drop.map(|drop| drop.edge());
        let horizon_m = self.horizon_m.map(|m| m as f32);
        let free = free_m(self.scan.status, horizon_m, first, edge.as_ref());
        // With the resolution of the sentences.
        free.map(|m| metres(Tenths::from_metres(m)))
    }

    /// Returns the index of the scan in its recording, from 0.
    pub fn scan_of_recording(&self) -> usize {
        self.part
            .map_or(0, |part| (part as usize).saturating_sub(1))
    }

    /// Returns the recording's name for headings, with the number of the scan if there are several:
    /// `NAME`, or `NAME scan K`.
    pub fn name(&self) -> String {
        match self.part {
            None => self.recording.clone(),
            Some(part) => format!("{} scan {part}", self.recording),
        }
    }

    /// Returns the answer as one JSON object.
    pub fn json(&self) -> Value {
        let step = |s: &StepLine| {
            json!({
                "distance_m": metres(s.distance),
                "height_m": metres(s.height),
                "tread_m": s.tread.map(metres),
                "riser_m": s.riser.map(metres),
                "distance_sigma_m": metres(s.distance_sigma),
                "height_sigma_m": metres(s.height_sigma),
                "quality": s.quality,
            })
        };
        let drop = |d: DropLine| {
            json!({
                "distance_m": metres(d.distance),
                "distance_sigma_m": metres(d.distance_sigma),
                "depth_m": d.depth.map(metres),
                "probability": f64::from(d.probability) / 1000.0,
            })
        };
        let maybe = |m: &MaybeLine| {
            json!({
                "distance_m": metres(m.distance),
                "height_m": metres(m.height),
                "probability": f64::from(m.probability) / 1000.0,
            })
        };
        let mut object = json!({
            "recording": self.recording,
            "scan": self.part.unwrap_or(self.scan.scan),
            "status": self.scan.status.as_str(),
            "direction": self.scan.direction.as_str(),
            "steps": self.steps.iter().map(step).collect::<Vec<_>>(),
            "drop": self.drop.map(drop),
            "horizon_m": self.horizon_m,
            "free_m": self.free_m(),
            "confidence": self.scan.confidence.map(|tenths| f64::from(tenths) / 1000.0),
            "maybe": self.maybes.iter().map(maybe).collect::<Vec<_>>(),
            "ground": self.slope().iter().map(|at| json!([at.from_m, at.slope])).collect::<Vec<_>>(),
            "lost_rows": self.scan.lost_rows,
            "reasons": self.scan.reasons.iter().map(|r| r.as_str()).collect::<Vec<_>>(),
        });
        // As in the sentence: only for a scanner that changes planes.
        if let Some(plane) = self.scan.plane {
            object["plane"] = json!(plane.as_str());
        }
        object
    }

    /// Returns the sentences, followed by a text table of their contents.
    pub fn text(&self) -> String {
        let mut out = format!("{}\n", self.name());
        for line in &self.sentences {
            let _ = writeln!(out, "  {line}");
        }
        let _ = writeln!(out, "  {}", self.summary());
        if !self.steps.is_empty() {
            out.push_str(
                "  step   distance ± 2σ      height ± 2σ        tread    riser   quality\n",
            );
        }
        for s in &self.steps {
            let optional = |v: Option<Tenths>| {
                v.map_or("-".into(), |v| format!("{:.1} cm", 100.0 * metres(v)))
            };
            let pair = |v, sigma| {
                format!(
                    "{:6.1} ± {:.1} cm",
                    100.0 * metres(v),
                    200.0 * metres(sigma)
                )
            };
            let _ = writeln!(
                out,
                "  {:>4}   {:<17}  {:<17}  {:>7}  {:>7}   {:>5} %",
                s.index,
                pair(s.distance, s.distance_sigma),
                pair(s.height, s.height_sigma),
                optional(s.tread),
                optional(s.riser),
                s.quality
            );
        }
        if let Some(drop) = &self.drop {
            let _ = writeln!(out, "  drop   {}", drop_words(drop));
        }
        for m in &self.maybes {
            let _ = writeln!(out, "  maybe  {}", maybe_words(m));
        }
        out
    }

    /// Returns status, steps and horizon in one line of text.
    pub fn summary(&self) -> String {
        let reasons: Vec<_> = self.scan.reasons.iter().map(|r| r.as_str()).collect();
        let because = if reasons.is_empty() {
            String::new()
        } else {
            format!(" ({})", reasons.join(", "))
        };
        let lost = match self.scan.lost_rows {
            0 => String::new(),
            1 => ", 1 row lost".to_owned(),
            n => format!(", {n} rows lost"),
        };
        let what = match (self.scan.status, self.scan.direction, self.steps.len()) {
            (Status::Fault, ..) => "no answer".to_owned(),
            (_, Direction::None, _) => "no stairs".to_owned(),
            (_, Direction::Up, n) => format!("{n} step{} up", if n == 1 { "" } else { "s" }),
            (_, Direction::Down, n) => format!("{n} step{} down", if n == 1 { "" } else { "s" }),
        };
        let plane = self.scan.plane.map_or(String::new(), |plane| {
            format!(" in the {} plane", plane.as_str())
        });
        let ground = self.slope().map_or(String::new(), |slope| {
            let way = if slope.slope < 0.0 { "down" } else { "up" };
            let percent = 100.0 * slope.slope.abs();
            format!(", ground {percent:.0} % {way} from {:.1} m", slope.from_m)
        });
        let validity = match (self.horizon_m, self.scan.confidence) {
            (Some(horizon), Some(tenths)) if horizon > 0.0 => format!(
                ", valid up to {horizon:.1} m ({:.1} % confidence)",
                f64::from(tenths) / 10.0
            ),
            (Some(_), Some(_)) => ", valid nowhere".to_owned(),
            _ => String::new(),
        };
        format!(
            "{}{because}: {what}{ground}{plane}{lost}{validity}",
            self.scan.status.as_str()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stairscan::answer::{DropEdge, PossibleStep};
    use stairscan::motion::Agreement;
    use stairscan::report::sentence::{ScanId, write_scan};
    use stairscan::verdict::{Assessment, Evidence, Outcome, Validity};

    /// Returns the sentences of an outcome.
    fn written(outcome: &Outcome) -> Vec<String> {
        let mut lines = Vec::new();
        write_scan(ScanId::FIRST, 0, outcome, |line| {
            lines.push(line.trim_end().to_owned());
        });
        lines
    }

    /// Returns the sentences of an `ok` answer with a drop and a `MAYBE`.
    fn sentences() -> Vec<String> {
        let mut outcome = Outcome::silent();
        let drop = DropEdge {
            distance_m: 0.9123,
            distance_sigma_m: 0.0151,
            depth_m: Some(0.18),
            probability: 0.9738,
        };
        outcome.answer.drop = Some(drop);
        let _ = outcome.answer.possible_steps.push(PossibleStep::default());
        let sight = Assessment {
            echo_found: true,
            valid: Some(Validity {
                horizon_m: 0.9,
                confidence: 0.995,
                first_step: 1.0,
            }),
            drop_m: Some(drop.nearest_m()),
            ..Assessment::nothing(Agreement::STANDING)
        };
        outcome.decide(&Evidence {
            assessment: Some(sight),
            ..Evidence::default()
        });
        written(&outcome)
    }

    #[test]
    fn a_drop_comes_out_as_json_and_in_words() {
        let answer = Answer::parse("brink", sentences()).unwrap();
        let json = answer.json();
        let drop = json!({
            "distance_m": 0.9123,
            "distance_sigma_m": 0.0151,
            "depth_m": 0.18,
            "probability": 0.974,
        });
        assert_eq!((&json["status"], &json["drop"]), (&json!("ok"), &drop));
        assert_eq!(json["free_m"], json!(0.867));
        let text = answer.text();
        let words = "  drop     91.2 cm: the ground ends, not before 86.7 cm, 18 cm deep (97 %)\n";
        assert!(text.contains(words), "{text}");
    }

    /// Logs of earlier images contain such answers.
    #[test]
    fn an_ok_without_a_horizon_is_shown_as_degraded() {
        let silent = written(&Outcome::silent());
        let Ok(Sentence::Scan(mut head)) = Sentence::parse(&silent[0]) else {
            panic!("{silent:?}");
        };
        let verdict = stairscan::verdict::verdict(&Evidence {
            assessment: Some(testbed::sure()),
            ..Evidence::default()
        });
        (head.status, head.reasons, head.horizon) = (verdict.status, verdict.reasons, None);
        let line = Sentence::Scan(head).write().trim_end().to_owned();
        assert!(line.contains(",ok,none,"), "{line}");
        let answer = Answer::parse("log", vec![line]).unwrap();
        assert_eq!(answer.json()["status"], "degraded");
        assert_eq!(answer.json()["reasons"], json!(["no-promise"]));
        assert!(
            answer.text().contains("degraded (no-promise): no stairs"),
            "{}",
            answer.text()
        );
    }

    #[test]
    fn the_plane_stands_where_the_sentence_tells_it() {
        let mut lines = sentences();
        let one = Answer::parse("brink", lines.clone()).unwrap();
        assert_eq!(one.json().get("plane"), None);
        assert!(!one.summary().contains("plane"));
        let head = Sentence::Scan(ScanLine {
            plane: Some(stairscan::config::Plane::Depth),
            ..one.scan
        });
        lines[0] = head.write().trim_end().to_owned();
        let both = Answer::parse("brink", lines).unwrap();
        assert_eq!(both.json()["plane"], "depth");
        assert!(both.summary().contains(": no stairs in the depth plane, "));
    }

    #[test]
    fn no_drop_and_no_free_distance_are_null() {
        let lines = written(&Outcome::silent());
        let json = Answer::parse("fault", lines).unwrap().json();
        assert!(json["drop"].is_null() && json["free_m"].is_null(), "{json}");
    }

    #[test]
    fn an_answer_whose_drop_is_missing_or_doubled_is_refused() {
        let whole = sentences();
        for lines in [
            vec![whole[0].clone(), whole[2].clone()],
            vec![
                whole[0].clone(),
                whole[1].clone(),
                whole[1].clone(),
                whole[2].clone(),
            ],
        ] {
            let error = Answer::parse("brink", lines).unwrap_err().to_string();
            assert!(error.contains("DROP"), "{error}");
        }
    }
}
