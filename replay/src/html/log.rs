//! The page of logs: answers, free distance, status and faults over time.

use serde_json::{Value, json};
use stairscan::report::{LiveLine, Sentence};
use stairscan::verdict::Status;

use crate::answer::{Answer, metres};
use crate::live::Ms;
use crate::live::log::{Log, Logged};
use crate::live::model::{SILENCE, Way};

/// Time between two damaged lines, ms, up to which they are one event.
const TOGETHER: Ms = 1_000;

/// Returns everything that the page shows of a log.
pub fn of(log: &Log) -> Value {
    let answers = log.answers();
    let sweeps = log.sweeps().map(|(line, sweep)| {
        json!([
            line.at,
            sweep.status.as_str(),
            sweep.free.map(metres),
            sweep.hazard.as_str()
        ])
    });
    json!({
        "name": log.name,
        "begun_ms": log.begun_ms,
        "clock": log.clock,
        "length_ms": log.length(),
        "answers": answers.iter().map(|(at, answer)| shown(*at, answer)).collect::<Vec<_>>(),
        "sweeps": sweeps.collect::<Vec<_>>(),
        "events": events(log),
    })
}

fn shown(at: Ms, answer: &Answer) -> Value {
    json!({
        "at": at,
        "scan": answer.scan.scan,
        "status": answer.scan.status.as_str(),
        "free_m": answer.free_m(),
        "horizon_m": answer.horizon_m,
        "steps_m": answer.steps.iter().map(|step| metres(step.distance)).collect::<Vec<_>>(),
        "drop_m": answer.drop.as_ref().map(|drop| metres(drop.distance)),
        "text": answer.summary(),
    })
}

/// Faults and other events of a log, in order.
#[derive(Default)]
struct Events {
    /// Time, kind, text.
    list: Vec<(Ms, &'static str, String)>,
    heard: Option<Ms>,
    /// Time and number of the last damaged lines that belong together.
    damaged: Option<(Ms, u32)>,
    uptime_ms: u32,
    counters: [u16; 4],
}

/// Returns the events of a log: time, ms, kind and text of each.
fn events(log: &Log) -> Vec<(Ms, &'static str, String)> {
    let mut events = Events::default();
    log.lines.iter().for_each(|line| events.line(line));
    events.list
}

impl Events {
    fn add(&mut self, at: Ms, kind: &'static str, text: impl Into<String>) {
        self.list.push((at, kind, text.into()));
    }

    fn line(&mut self, line: &Logged) {
        let Logged { at, way, text } = line;
        match (way, Sentence::parse(text)) {
            (Way::Out, _) => self.add(*at, "sent", text),
            (Way::Note, _) => self.add(*at, "remark", text),
            (_, Ok(sentence)) => self.sentence(*at, &sentence),
            (_, Err(_)) => self.damaged(*at, text),
        }
    }

    fn damaged(&mut self, at: Ms, text: &str) {
        match &mut self.damaged {
            Some((last, count)) if at.saturating_sub(*last) <= TOGETHER => {
                (*last, *count) = (at, *count + 1);
                let count = *count;
                if let Some(event) = self.list.iter_mut().rfind(|event| event.1 == "damaged") {
                    event.2 =
                        format!("{count} lines that are no intact sentence, the last one: {text}");
                }
            }
            _ => {
                self.damaged = Some((at, 1));
                self.add(at, "damaged", format!("no intact sentence: {text}"));
            }
        }
    }

    fn sentence(&mut self, at: Ms, sentence: &Sentence<'_>) {
        let silence = at.saturating_sub(self.heard.unwrap_or(at));
        if silence > SILENCE {
            let text = format!("no intact sentence for {:.1} s", silence as f64 / 1000.0);
            self.add(at - silence, "silence", text);
        }
        self.heard = Some(at);
        match sentence {
            Sentence::Scan(head) if head.status == Status::Fault => {
                self.add(at, "fault", format!("scan {}: {}", head.scan, head.reasons));
            }
            Sentence::Guard(sweep) if sweep.status == Status::Fault => {
                let same = self.list.last().is_some_and(|last| last.1 == "guard fault");
                if !same {
                    self.add(
                        at,
                        "guard fault",
                        format!("sweep {}: {}", sweep.sweep, sweep.reasons),
                    );
                }
            }
            Sentence::Boot(boot) => {
                (self.uptime_ms, self.counters) = (0, [0; 4]);
                self.add(at, "restart", format!("reset by {}", boot.reset));
            }
            Sentence::Halt { reason } => self.add(at, "halt", reason.as_str()),
            Sentence::Fail { command, field, .. } => {
                self.add(at, "refused", format!("{command}: {field}"));
            }
            Sentence::Live(live) => self.live(at, live),
            _ => {}
        }
    }

    fn live(&mut self, at: Ms, live: &LiveLine<'_>) {
        if live.uptime_ms < self.uptime_ms {
            self.add(at, "restart", "its BOOT was lost");
            self.counters = [0; 4];
        }
        let names = [
            "faults of the motion input",
            "refused lines",
            "damaged bytes at the scanner",
            "errors of the radar link",
        ];
        let now = [
            live.motion_faults,
            live.refused,
            live.port_errors,
            live.link_errors,
        ];
        // The counters before the log's first `LIVE` are not of its time.
        let known = self.uptime_ms > 0;
        for (name, (now, before)) in names.into_iter().zip(now.into_iter().zip(self.counters)) {
            if known && now > before {
                self.add(
                    at,
                    "counter",
                    format!("{} more {name}, {now} since boot", now - before),
                );
            }
        }
        (self.uptime_ms, self.counters) = (live.uptime_ms, now);
    }
}
