//! Converts bytes of a serial port to the state of the scanner there, by the lines and the model of `cargo sim
//! live`.

use serde_json::{Value, json};
use stairscan_replay::html;
use stairscan_replay::live::lines::Splitter;
use stairscan_replay::live::model::{self, Link, State, Validity, Way};
use stairscan_replay::live::trouble::Trouble;

use crate::request::{Event, News};

/// Number of lines shown on the page.
const LINES: usize = 60;

/// The last port that was opened.
pub struct Port {
    lines: Splitter,
    state: State,
    /// Last answer that was passed to the page: its time of arrival, ms, and its sentences.
    given: Option<(u64, Vec<String>)>,
}

impl Default for Port {
    fn default() -> Self {
        Self {
            lines: Splitter::default(),
            state: State::new("", 0),
            given: None,
        }
    }
}

impl Port {
    /// Processes an event. Returns the current state, with new answers.
    pub fn take(&mut self, news: &News, data: &[u8]) -> Value {
        let now = news.now;
        let mut answers = Vec::new();
        match news.what {
            Event::Opened => {
                *self = Self {
                    state: State::new(&news.port, news.baud),
                    ..Self::default()
                };
                self.state.take(now, &model::Event::Opened);
            }
            Event::Bytes => {
                for line in self.lines.push(data) {
                    self.state.take(now, &model::Event::Line(line));
                    answers.extend(self.fresh());
                }
            }
            Event::Tick => {
                if let Some(text) = self.lines.pending() {
                    self.state.take(now, &model::Event::Pending(text));
                }
            }
            Event::Gone => {
                let trouble = Trouble::Unplugged(news.why.clone());
                self.state.take(now, &model::Event::Failed(trouble));
            }
        }
        self.known(now, &answers)
    }

    /// Returns the answer in the page's form if it is new to the page.
    fn fresh(&mut self) -> Option<Value> {
        let (came, answer) = self.state.answer.as_ref()?;
        let known = self.given.as_ref();
        if known.is_some_and(|(at, lines)| at == came && *lines == answer.sentences) {
            return None;
        }
        self.given = Some((*came, answer.sentences.clone()));
        Some(html::answered(answer))
    }

    /// Returns the state of port and scanner, with the answers that are new to the page.
    fn known(&self, now: u64, answers: &[Value]) -> Value {
        let (trouble, help) = self.trouble(now);
        let state = &self.state;
        let skipped = state.log.len().saturating_sub(LINES);
        let line = |entry: &model::Entry| json!([entry.at, way(entry.way), entry.text]);
        let log: Vec<Value> = state.log.iter().skip(skipped).map(line).collect();
        json!({
            "standing": standing(state.standing(now)),
            "age_ms": state.age(now),
            "open": state.is_open(),
            "damaged": state.damaged(),
            "pulse": state.pulse.as_ref().map(|pulse| json!({
                "state": pulse.state,
                "scan": pulse.scan,
                "uptime_ms": pulse.uptime_ms,
                "motion": pulse.motion,
                "counters": pulse.counters,
            })),
            "trouble": trouble,
            "help": help,
            "log": log,
            "answers": answers,
        })
    }

    /// Returns the fault of the port and its remedies; `None` if there is no fault.
    fn trouble(&self, now: u64) -> (Option<String>, Vec<String>) {
        let state = &self.state;
        let cause = match &state.link {
            Link::Away(_, trouble) => Some(trouble.explain(&state.port)),
            _ => state
                .unexpected_data(now)
                .map(|unexpected_data| unexpected_data.explain(state.baud)),
        };
        cause.map_or((None, Vec::new()), |(what, help)| (Some(what), help))
    }
}

/// Returns the validity of the answer with regard to its age: a word and its meaning.
fn standing(standing: Validity) -> [String; 2] {
    let [word, meaning] = match standing {
        Validity::Fresh => ["fresh", "the current answer"],
        Validity::Unplugged => ["unplugged", "the port is closed: this answer is stale"],
        Validity::Silent(_) => [
            "silent",
            "no intact sentence for 500 ms: this answer is stale",
        ],
        Validity::Restarted => [
            "restarted",
            "the scanner has restarted: this answer is stale",
        ],
        Validity::Old => ["old", "older than any controller may act on"],
    };
    [word.to_owned(), meaning.to_owned()]
}

fn way(way: Way) -> &'static str {
    match way {
        Way::In => "in",
        Way::Damaged => "damaged",
        Way::Out => "out",
        Way::Note => "note",
    }
}
