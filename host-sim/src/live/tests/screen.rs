//! Snapshots of the screen. `LIVE_SNAPSHOTS=write cargo test -p host-sim --lib live` writes them again, for
//! inspection before they are committed.

use std::path::Path;

use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::style::Color;
use stairscan::report::Sentence;
use stairscan::verdict::{Reason, Status};

use super::*;
use crate::live::prompt::{Key, Prompt};
use crate::live::screen;
use crate::live::trouble::Trouble;

fn drawn(state: &State, prompt: &Prompt, now: Ms) -> Buffer {
    let mut terminal = Terminal::new(TestBackend::new(100, 30)).unwrap();
    let draw = |frame: &mut ratatui::Frame<'_>| screen::draw(frame, state, prompt, now);
    terminal.draw(draw).unwrap();
    terminal.backend().buffer().clone()
}

fn text(buffer: &Buffer) -> String {
    let rows = buffer.content.chunks(usize::from(buffer.area.width));
    let row = |cells: &[ratatui::buffer::Cell]| {
        let text: String = cells.iter().map(|cell| cell.symbol()).collect();
        format!("{}\n", text.trim_end())
    };
    rows.map(row).collect()
}

/// Compares the screen with the snapshot `name`, and returns it.
fn snapshot(name: &str, state: &State, prompt: &Prompt, now: Ms) -> Buffer {
    let buffer = drawn(state, prompt, now);
    let text = text(&buffer);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("src/live/tests/{name}.txt"));
    if std::env::var_os("LIVE_SNAPSHOTS").is_some_and(|value| value == "write") {
        std::fs::write(&path, &text).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(text == kept, "{name}: the screen is now\n{text}");
    buffer
}

/// Whether the text `what` is on the screen in grey.
fn is_grey(buffer: &Buffer, what: &str) -> bool {
    let width = usize::from(buffer.area.width);
    let row = buffer.content.chunks(width).find_map(|cells| {
        let text: Vec<&str> = cells.iter().map(|cell| cell.symbol()).collect();
        let at = (0..width).find(|&k| text[k..].concat().starts_with(what))?;
        Some(cells[at].fg == Color::DarkGray)
    });
    row.unwrap_or_else(|| panic!("{what} is not on the screen"))
}

#[test]
fn ok() {
    let screen = snapshot("ok", &scanned(), &Prompt::default(), 3_200);
    assert!(!is_grey(&screen, "3 steps up") && !is_grey(&screen, " 1    50.0"));
}

/// The help stays while sentences come, and is whole on the smallest screen.
#[test]
fn help() {
    let (mut prompt, mut state) = (Prompt::default(), scanned());
    prompt.helping = true;
    (0..20).for_each(|k| receive(&mut state, 3_200 + k, &STAIR_A));
    snapshot("help", &state, &prompt, 3_300);
    let mut terminal = Terminal::new(TestBackend::new(72, 22)).unwrap();
    let draw = |frame: &mut ratatui::Frame<'_>| screen::draw(frame, &state, &prompt, 3_300);
    terminal.draw(draw).unwrap();
    let text = text(terminal.backend().buffer());
    for line in crate::live::prompt::HELP {
        assert!(text.contains(line), "{line} in\n{text}");
    }
}

/// Neither what the program nor what the scanner refuses is cut off on the smallest screen, nor a remedy.
#[test]
fn refusals_are_whole_on_the_smallest_screen() {
    let whole = |state: &State, prompt: &Prompt, now: Ms, expected: &str| {
        let mut terminal = Terminal::new(TestBackend::new(72, 22)).unwrap();
        let draw = |frame: &mut ratatui::Frame<'_>| screen::draw(frame, state, prompt, now);
        terminal.draw(draw).unwrap();
        let shown = text(terminal.backend().buffer());
        let words: Vec<&str> = shown.split_whitespace().collect();
        let expected: Vec<&str> = expected.split_whitespace().collect();
        let found = words.windows(expected.len()).any(|at| at == expected);
        assert!(found, "{expected:?} is not in\n{shown}");
    };
    for typed in ["scna", "calibrate 1500", "set plane sideways", "set seed 7"] {
        let mut prompt = Prompt::default();
        typed.chars().for_each(|c| prompt.key(Key::Char(c)));
        assert_eq!(prompt.enter(), None);
        whole(&scanned(), &prompt, 3_200, &prompt.note);
    }
    let mut state = scanned();
    state.sent(3_150, "scna");
    let expected = "start stop scan guard watch status version selftest reset get set save update or calibrate";
    let refused = Sentence::Fail {
        command: "-",
        field: "command",
        expected,
    };
    receive(&mut state, 3_180, &[&line(&refused)]);
    whole(&state, &Prompt::default(), 3_200, expected);
    let mut state = State::new("/dev/ttyUSB0", 115_200);
    let forbidden = Trouble::Forbidden(None);
    let (_, helps) = forbidden.explain("/dev/ttyUSB0");
    state.take(10, &Event::Failed(forbidden));
    for help in helps {
        whole(&state, &Prompt::default(), 60, &help);
    }
}

#[test]
fn degraded() {
    let mut state = State::new("/dev/ttyUSB0", 115_200);
    state.take(100, &Event::Opened);
    let lines = [
        "$PSTR,SCAN,4,degraded,down,1,2,lost-rows+unconfirmed,0.0,41.2,1,100152FB,0",
        "$PSTR,STEP,4,1,1,612.5,-172.0,,-172.0,2.5,12.0,80",
        "$PSTR,MAYBE,4,1,1,912.0,-100.0,22.5",
    ];
    let closed = lines.map(|line| {
        let body = line.trim_start_matches('$');
        format!("{line}*{:08X}", stairscan::report::sentence::crc32(body))
    });
    receive(&mut state, 2_000, &closed.each_ref().map(String::as_str));
    receive(&mut state, 2_100, &[&live(70_000, Some(110))]);
    snapshot("degraded", &state, &Prompt::default(), 2_200);
}

/// An `ok` answer with a drop.
#[test]
fn drop() {
    let mut state = State::new("/dev/ttyUSB0", 115_200);
    state.take(100, &Event::Opened);
    let lines = [
        "$PSTR,SCAN,5,ok,none,0,0,,860.0,99.5,0,100152FB,1",
        "$PSTR,DROP,5,912.0,15.0,180.0,97.4",
    ];
    let closed = lines.map(|line| {
        let body = line.trim_start_matches('$');
        format!("{line}*{:08X}", stairscan::report::sentence::crc32(body))
    });
    receive(&mut state, 2_000, &closed.each_ref().map(String::as_str));
    receive(&mut state, 2_100, &[&live(70_000, Some(110))]);
    let screen = snapshot("drop", &state, &Prompt::default(), 2_200);
    assert!(!is_grey(&screen, " |   91.2 cm: the ground ends"));
    let old = drawn(&state, &Prompt::default(), 6_000);
    assert!(is_grey(&old, " |   91.2 cm: the ground ends"));
}

#[test]
fn fault() {
    let mut state = scanned();
    let fault = scan(2, Status::Fault, &[Reason::MotorStall]);
    receive(&mut state, 9_000, &[&fault, &live(11_000, Some(6_100))]);
    let screen = snapshot("fault", &state, &Prompt::default(), 9_300);
    assert!(!text(&screen).contains("50.0 ±"), "a fault tells no steps");
}

#[test]
fn stale() {
    let screen = snapshot("stale", &scanned(), &Prompt::default(), 6_000);
    assert!(is_grey(&screen, "3 steps up") && is_grey(&screen, " 1    50.0"));
}

#[test]
fn unplugged() {
    let mut state = scanned();
    let gone = Trouble::Unplugged("no such device any more".to_owned());
    state.take(5_000, &Event::Failed(gone));
    let screen = snapshot("unplugged", &state, &Prompt::default(), 17_300);
    assert!(is_grey(&screen, "3 steps up"));
}

#[test]
fn no_port() {
    let mut state = State::new("/dev/ttyUSB7", 115_200);
    let ports = vec!["/dev/ttyUSB0".to_owned(), "/dev/ttyS0".to_owned()];
    state.take(10, &Event::Failed(Trouble::Missing(ports)));
    snapshot("no-port", &state, &Prompt::default(), 60);
}

#[test]
fn forbidden() {
    let mut state = State::new("/dev/ttyUSB0", 115_200);
    state.take(10, &Event::Failed(Trouble::Forbidden(None)));
    snapshot("forbidden", &state, &Prompt::default(), 60);
}

#[test]
fn wrong_port() {
    let mut state = State::new("/dev/ttyS0", 115_200);
    state.take(10, &Event::Opened);
    snapshot("silent-port", &state, &Prompt::default(), 4_000);
    let mut state = State::new("/dev/ttyACM0", 9_600);
    state.take(10, &Event::Opened);
    receive(&mut state, 900, &["\\x00\\xf8\\x80~\\xff", "\\xe0\\x1c"]);
    snapshot("wrong-speed", &state, &Prompt::default(), 4_000);
}

#[test]
fn command_answered_and_offered() {
    let mut state = scanned();
    state.sent(3_150, "stop");
    receive(
        &mut state,
        3_180,
        &[&line(&Sentence::Done { command: "stop" })],
    );
    let mut prompt = Prompt::default();
    "set mount-height 41000"
        .chars()
        .for_each(|c| prompt.key(Key::Char(c)));
    assert_eq!(prompt.enter(), None);
    snapshot("command", &state, &prompt, 3_200);
}

#[test]
fn any_size_and_any_answer_can_be_drawn() {
    let full: Vec<Reason> = Reason::ALL.to_vec();
    let mut state = scanned();
    receive(
        &mut state,
        3_150,
        &[&scan(3, Status::Degraded, &full[..12])],
    );
    for state in [scanned(), state, State::new("", 0)] {
        for (width, height) in [(1, 1), (40, 10), (72, 22), (73, 200), (300, 23)] {
            let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
            let draw = |frame: &mut ratatui::Frame<'_>| {
                screen::draw(frame, &state, &Prompt::default(), 3_200);
            };
            terminal.draw(draw).unwrap();
        }
    }
}

/// The labels of the x axis are below their values: 100 at the horizon of 100 cm.
#[test]
fn the_axis_says_where_the_horizon_is() {
    for width in [80, 100, 150] {
        let mut terminal = Terminal::new(TestBackend::new(width, 30)).unwrap();
        let (state, prompt) = (scanned(), Prompt::default());
        let draw = |frame: &mut ratatui::Frame<'_>| screen::draw(frame, &state, &prompt, 3_200);
        terminal.draw(draw).unwrap();
        let screen = text(terminal.backend().buffer());
        let column = |line: &str, what: &str| {
            let at = line
                .find(what)
                .unwrap_or_else(|| panic!("{width}: {what}: {line}"));
            line[..at].chars().count()
        };
        let lines: Vec<&str> = screen.lines().collect();
        let axis = lines
            .iter()
            .position(|line| line.contains("└──") && line.contains("│"))
            .unwrap();
        let (labels, dots) = (lines[axis + 1], lines[axis - 2]);
        let middle = column(labels, "100") + 1;
        assert_eq!(middle, column(dots, ":"), "{width}:\n{screen}");
    }
}

/// New lines do not move the displayed ones after scrolling back.
#[test]
fn the_log_scrolls_and_stays_where_it_is() {
    let mut state = scanned();
    (0..40).for_each(|k| state.note(k, &format!("line {k}.")));
    let shows = |state: &State, what: &str| {
        let screen = drawn(state, &Prompt::default(), 3_200);
        text(&screen).contains(what)
    };
    assert!(shows(&state, "line 39.") && !shows(&state, "newer ones"));
    state.older();
    state.older();
    assert!(shows(&state, "line 29.") && !shows(&state, "line 30."));
    state.note(50, "line 40.");
    assert!(shows(&state, "line 29.") && !shows(&state, "line 30."));
    assert!(shows(&state, "11 newer ones"));
    (0..3).for_each(|_| state.newer());
    assert!(shows(&state, "line 40.") && !shows(&state, "newer ones"));
    (0..500).for_each(|_| state.older());
    assert!(state.hidden < state.log.len());
    drawn(&state, &Prompt::default(), 3_200);
    let mut empty = State::new("port", 0);
    empty.older();
    drawn(&empty, &Prompt::default(), 0);
}

/// Receives guard sweeps, each given by the fields after its number, one every 100 ms from `at` on.
fn sweep(state: &mut State, mut at: Ms, sweeps: impl Iterator<Item = String>) {
    for (k, fields) in sweeps.enumerate() {
        let body = format!("PSTR,GUARD,{},{fields}", k + 1);
        let crc = stairscan::report::sentence::crc32(&body);
        at += 100;
        receive(state, at, &[&format!("${body}*{crc:08X}")]);
    }
}

#[test]
fn guarding() {
    let mut state = scanned();
    let nearer = (1..=9).map(|sweep| format!("ok,{}.0,rise,99.8,", 1_300 - 50 * sweep));
    sweep(&mut state, 3_100, nearer);
    let screen = snapshot("guarding", &state, &Prompt::default(), 4_050);
    assert!(!is_grey(&screen, "Guard: ok") && !is_grey(&screen, "Last sweep"));
    let kept = state
        .log
        .iter()
        .filter(|entry| entry.text.contains("GUARD"));
    assert_eq!(kept.count(), 1);
    // Once no sweep comes, the answer has the screen again.
    let stale = drawn(&state, &Prompt::default(), 6_000);
    assert!(is_grey(&stale, "Guard: ok") && !text(&stale).contains("Last sweep"));
    assert!(text(&stale).contains("Side view"));
    // On a high screen both are seen.
    let mut terminal = Terminal::new(TestBackend::new(100, 40)).unwrap();
    let draw =
        |frame: &mut ratatui::Frame<'_>| screen::draw(frame, &state, &Prompt::default(), 4_050);
    terminal.draw(draw).unwrap();
    let high = text(terminal.backend().buffer());
    assert!(high.contains("Last sweep") && high.contains("Side view"));
}

/// Each status has its colour in the strip; a pause is a gap, and a reported watch distance moves the line.
#[test]
fn guard_strip() {
    let mut state = State::new("demo", 0);
    state.take(100, &Event::Opened);
    receive(
        &mut state,
        150,
        &[&framed_line("PSTR,CONF,watch-distance,100000")],
    );
    let far = std::iter::repeat_n("ok,2000.0,none,99.9,".to_owned(), 4);
    let weak = std::iter::repeat_n("degraded,500.0,unknown,60.0,lost-rows".to_owned(), 2);
    let fault = std::iter::once("fault,,unknown,0.0,motor-stall".to_owned());
    sweep(&mut state, 200, far.chain(weak).chain(fault));
    sweep(
        &mut state,
        2_000,
        std::iter::once("ok,1000.0,drop,99.8,".to_owned()),
    );
    let screen = snapshot("guard-strip", &state, &Prompt::default(), 2_150);
    let width = usize::from(screen.area.width);
    let rows: Vec<_> = screen.content.chunks(width).collect();
    let is_bottom = |row: &&&[ratatui::buffer::Cell]| {
        row[width - 2].symbol() == "█" && row[width - 4].symbol() == "x"
    };
    let bottom = rows.iter().find(is_bottom).unwrap();
    let colours: Vec<Color> = bottom[width - 10..width - 1]
        .iter()
        .map(|cell| cell.fg)
        .collect();
    let (ok, weak) = (Color::Cyan, Color::Yellow);
    assert_eq!(
        colours,
        [ok, ok, ok, ok, weak, weak, Color::Red, Color::Reset, ok]
    );
}

/// Each hazard is drawn; after a restart the strip stays.
#[test]
fn guard_hazards() {
    let outline = |ending: &str| {
        let mut state = State::new("demo", 0);
        state.take(100, &Event::Opened);
        let fields = format!("ok,800.0,{ending},99.8,");
        sweep(&mut state, 200, std::iter::once(fields));
        let screen = text(&drawn(&state, &Prompt::default(), 350));
        receive(
            &mut state,
            400,
            &[&framed_line(
                "PSTR,BOOT,0.2.0,a,power-on,hse-168,1,00000000,000000000000000000000000",
            )],
        );
        let restarted = text(&drawn(&state, &Prompt::default(), 450));
        assert!(
            restarted.contains("Sweeps, free") && restarted.contains("restarted"),
            "{restarted}"
        );
        let view = screen
            .lines()
            .skip_while(|line| !line.contains("Last sweep"));
        view.skip(1)
            .take(14)
            .map(|line| line.chars().take(56).collect::<String>())
            .collect::<Vec<_>>()
            .join("\n")
    };
    let all = ["none", "rise", "drop", "obstacle", "unknown"].map(outline);
    for (k, view) in all.iter().enumerate() {
        assert!(view.contains(':'), "{view}");
        assert!(all[..k].iter().all(|other| other != view), "{view}");
    }
    assert!(all[4].contains('?') && !all[0].contains('?'));
}

fn framed_line(body: &str) -> String {
    format!("${body}*{:08X}", stairscan::report::sentence::crc32(body))
}
