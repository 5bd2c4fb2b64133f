//! The answer to a guard sweep, parsed from the sentence of the report UART.
//!
//! Both `replay` and `emulate` print from here, as from [`crate::answer`].

use std::fmt::Write as _;

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use stairscan::report::{GuardLine, Sentence};
use stairscan::verdict::Status;

use crate::answer::metres;

/// The `GUARD` sentence that answers one guard sweep, and its contents.
#[derive(Clone, Debug)]
pub struct Guarded {
    /// Base name of the recording.
    pub recording: String,
    /// The sentence as received, without its line end.
    pub sentence: String,
    /// Number of the sweep in the recording, from 1.
    pub sweep: u32,
    /// Contents of the sentence: status, free distance, hazard, confidence and reasons.
    pub line: GuardLine,
}

impl Guarded {
    /// Parses the `GUARD` sentences of consecutive sweeps; `first` is the number of sweeps in the
    /// recording before them.
    ///
    /// # Errors
    /// A sentence is not a `GUARD`: the scanner could not sweep, and reports the cause.
    pub fn parse(first: usize, sentences: Vec<String>) -> Result<Vec<Self>> {
        let parse = |sentence: String| {
            let parsed = Sentence::parse(&sentence);
            let Sentence::Guard(line) = parsed.with_context(|| sentence.clone())? else {
                bail!("in place of a guard sweep: {sentence}");
            };
            Ok(Self {
                recording: String::new(),
                sweep: first as u32 + line.sweep,
                sentence,
                line,
            })
        };
        sentences.into_iter().map(parse).collect()
    }

    /// Whether the status is `fault`.
    pub fn is_fault(&self) -> bool {
        self.line.status == Status::Fault
    }

    /// Returns the answer as one JSON object.
    pub fn json(&self) -> Value {
        let GuardLine {
            status,
            free,
            hazard,
            confidence,
            reasons,
            ..
        } = self.line;
        json!({
            "recording": self.recording,
            "guard": self.sweep,
            "status": status.as_str(),
            "free_m": free.map(metres),
            "what": hazard.as_str(),
            "confidence": f64::from(confidence) / 1000.0,
            "reasons": reasons.iter().map(|r| r.as_str()).collect::<Vec<_>>(),
        })
    }
}

/// Returns the sentences of all sweeps of a recording, and a text table.
pub fn text(words: &[Guarded]) -> String {
    let mut out = String::new();
    if let Some(first) = words.first() {
        let _ = writeln!(out, "{}", first.recording);
    }
    for word in words {
        let _ = writeln!(out, "  {}", word.sentence);
    }
    out.push_str("  sweep  status    free distance  ended by  confidence  reasons\n");
    for word in words {
        let line = &word.line;
        let free = line
            .free
            .map_or("-".into(), |free| format!("{:.1} cm", 100.0 * metres(free)));
        let row = format!(
            "  {:>5}  {:<8}  {free:>13}  {:<8}  {:>8.1} %  {}",
            word.sweep,
            line.status.as_str(),
            line.hazard.as_str(),
            f64::from(line.confidence) / 10.0,
            line.reasons
        );
        let _ = writeln!(out, "{}", row.trim_end());
    }
    out
}
