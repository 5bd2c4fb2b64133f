//! Tests of the scanner's state and its display.

mod screen;
mod state;

use stairscan::report::{LiveLine, ScanLine, Sentence};
use stairscan::verdict::{Outcome, Reason, Reasons, Status};

use super::Ms;
use super::model::{Event, State};

/// Sentences of the answer to `recordings/stair_a`.
const STAIR_A: [&str; 4] = [
    "$PSTR,SCAN,1,ok,up,3,0,,1000.0,98.9,0,100152FB,0*48425B4C",
    "$PSTR,STEP,1,1,3,500.5,165.4,279.5,165.4,1.5,3.7,100*2688B9C3",
    "$PSTR,STEP,1,2,3,780.0,330.7,280.6,165.3,1.5,13.6,100*252F41B4",
    "$PSTR,STEP,1,3,3,1060.7,495.1,,164.4,1.5,23.0,100*25D20E0E",
];

fn line(sentence: &Sentence<'_>) -> String {
    sentence.write().trim_end().to_owned()
}

fn live(uptime_ms: u32, age_ms: Option<u32>) -> String {
    line(&Sentence::Live(LiveLine {
        state: "scanning",
        scan: 2,
        uptime_ms,
        age_ms,
        motion: "absent",
        motion_faults: 0,
        refused: 0,
        port_errors: 0,
        link_errors: 0,
    }))
}

/// The `SCAN` sentence of a scan without steps.
fn scan(number: u32, status: Status, reasons: &[Reason]) -> String {
    let reasons = reasons.iter().fold(Reasons::NONE, |all, r| all.with(*r));
    line(&Sentence::Scan(ScanLine {
        status,
        reasons,
        ..ScanLine::new(number, 0, &Outcome::silent(), 7)
    }))
}

fn receive(state: &mut State, at: Ms, lines: &[&str]) {
    for line in lines {
        state.take(at, &Event::Line((*line).to_owned()));
    }
}

/// Returns a state that is open since 100 ms, with the answer to stair_a at 3,000 ms and a `LIVE`
/// at 3,100 ms.
fn scanned() -> State {
    let mut state = State::new("/dev/ttyUSB0", 115_200);
    state.take(100, &Event::Opened);
    receive(&mut state, 3_000, &STAIR_A);
    receive(&mut state, 3_100, &[&live(5_000, Some(124))]);
    state
}
