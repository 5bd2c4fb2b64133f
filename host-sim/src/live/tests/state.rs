use stairscan::report::{BootLine, Sentence};
use stairscan::verdict::{Reason, Status};

use super::*;
use crate::live::model::{Link, SILENCE, Validity, Way};
use crate::live::trouble::{Trouble, UnexpectedData};

fn unplugged() -> Event {
    Event::Failed(Trouble::Unplugged("gone".to_owned()))
}

#[test]
fn an_answer_counts_once_all_of_it_has_come() {
    let mut state = State::new("p", 115_200);
    state.take(0, &Event::Opened);
    receive(&mut state, 10, &STAIR_A[..3]);
    assert!(state.answer.is_none());
    // LIVE may come between any two sentences.
    receive(&mut state, 20, &[&live(300, None), STAIR_A[3]]);
    let (at, answer) = state.answer.as_ref().unwrap();
    assert_eq!((*at, answer.steps.len()), (20, 3));
    // An incomplete answer does not replace it.
    let second = scan(2, Status::Degraded, &[Reason::Moving]);
    receive(&mut state, 30, &[STAIR_A[0], STAIR_A[1], STAIR_A[2]]);
    assert_eq!(state.answer.as_ref().unwrap().0, 20);
    receive(&mut state, 40, &[&second, STAIR_A[3]]);
    assert_eq!(state.answer.as_ref().unwrap().1.scan.scan, 2);
}

#[test]
fn age_counts_from_the_last_row_as_live_tells_it() {
    let mut state = scanned();
    assert_eq!(state.age(3_100), Some(124));
    assert_eq!(state.age(3_400), Some(424));
    // A fault has no age in LIVE: it is measured from its arrival.
    receive(
        &mut state,
        4_000,
        &[
            &scan(2, Status::Fault, &[Reason::NoEcho]),
            &live(6_000, Some(1_200)),
        ],
    );
    assert_eq!(state.age(4_500), Some(500));
    assert_eq!(State::new("p", 0).age(9), None);
}

#[test]
fn an_answer_goes_stale_in_each_way_that_there_is() {
    let mut state = scanned();
    assert_eq!(state.standing(3_200), Validity::Fresh);
    assert_eq!(state.standing(3_100 + SILENCE), Validity::Fresh);
    assert_eq!(
        state.standing(3_101 + SILENCE),
        Validity::Silent(SILENCE + 1)
    );
    receive(&mut state, 30_000, &[&live(31_900, Some(27_000))]);
    assert_eq!(state.standing(30_100), Validity::Old);
    let boot = line(&Sentence::Boot(BootLine {
        version: "0.1.0",
        revision: "abc",
        reset: "power",
        clock: "hse-168",
        boots: 1,
        settings: 7,
        serial: [1, 2, 3],
        ..BootLine::default()
    }));
    receive(&mut state, 30_200, &[&boot]);
    assert_eq!(state.standing(30_200), Validity::Restarted);
    receive(&mut state, 33_000, &STAIR_A);
    assert_eq!(state.standing(33_000), Validity::Fresh);
    // A lost BOOT is detected by the uptime in LIVE.
    receive(
        &mut state,
        33_100,
        &[&live(40_000, Some(5)), &live(200, None)],
    );
    assert_eq!(state.standing(33_100), Validity::Restarted);
}

#[test]
fn a_pulled_plug_keeps_the_answer_and_says_so_until_it_comes_back() {
    let mut state = scanned();
    state.take(5_000, &unplugged());
    assert_eq!(state.standing(5_000), Validity::Unplugged);
    assert!(state.answer.is_some() && !state.is_open());
    // Further failures to open it are not new, and do not change the time.
    state.take(5_300, &Event::Failed(Trouble::Missing(Vec::new())));
    assert!(matches!(
        &state.link,
        Link::Away(5_000, Trouble::Unplugged(_))
    ));
    // A missing permission is new.
    let denied = Trouble::Forbidden(None);
    state.take(5_600, &Event::Failed(denied.clone()));
    assert_eq!(state.link, Link::Away(5_000, denied));
    state.take(5_800, &unplugged());
    state.take(6_000, &Event::Opened);
    assert_eq!((state.is_open(), state.reopened), (true, 1));
    receive(&mut state, 6_100, &STAIR_A);
    assert_eq!(state.standing(6_100), Validity::Fresh);
}

#[test]
fn half_an_answer_does_not_survive_a_pulled_plug() {
    let mut state = State::new("p", 115_200);
    state.take(0, &Event::Opened);
    receive(&mut state, 10, &STAIR_A[..2]);
    state.take(20, &unplugged());
    state.take(30, &Event::Opened);
    receive(&mut state, 40, &STAIR_A[2..]);
    assert!(state.answer.is_none());
}

#[test]
fn a_port_without_sentences_is_explained_by_what_comes_instead() {
    let open = |lines: &[&str]| {
        let mut state = State::new("p", 9_600);
        state.take(1_000, &Event::Opened);
        receive(&mut state, 1_100, lines);
        assert_eq!(
            state.unexpected_data(2_000),
            None,
            "a scanner may be booting"
        );
        state
    };
    assert_eq!(
        open(&[]).unexpected_data(4_000),
        Some(UnexpectedData::Nothing)
    );
    assert_eq!(
        open(&["\\xfe\\x80\\x00x"]).unexpected_data(4_000),
        Some(UnexpectedData::Noise)
    );
    let other = "Zephyr OS build v3";
    assert_eq!(
        open(&[other]).unexpected_data(4_000),
        Some(UnexpectedData::Others(other))
    );
    let damaged = STAIR_A[0].replace("1000.0", "1900.0");
    assert_eq!(
        open(&[&damaged]).unexpected_data(4_000),
        Some(UnexpectedData::Damaged)
    );
    assert_eq!(scanned().unexpected_data(3_500), None);
    assert_eq!(
        scanned().unexpected_data(9_000),
        Some(UnexpectedData::Silence)
    );
}

#[test]
fn a_command_has_its_answer_and_no_other() {
    let mut state = scanned();
    state.sent(4_000, "scan");
    receive(
        &mut state,
        4_100,
        &[&line(&Sentence::Done { command: "stop" })],
    );
    assert_eq!(state.asked.as_ref().unwrap().reply, None);
    assert!(!state.asked.as_ref().unwrap().overdue(5_000));
    assert!(state.asked.as_ref().unwrap().overdue(7_000));
    receive(
        &mut state,
        7_100,
        &[&line(&Sentence::Done { command: "scan" })],
    );
    let reply = state.asked.as_ref().unwrap().reply.clone().unwrap();
    assert_eq!(reply, (7_100, "done".to_owned(), true));

    state.sent(8_000, "$PSTC,set,seed,7*352B37A8");
    let refused = Sentence::Fail {
        command: "set",
        field: "seed",
        expected: "a whole number",
    };
    receive(&mut state, 8_050, &[&line(&refused)]);
    let (_, text, good) = state.asked.as_ref().unwrap().reply.clone().unwrap();
    assert_eq!(
        (text.as_str(), good),
        ("refused: seed: expected a whole number", false)
    );
    // `get` ends with its DONE; the self-test takes longer.
    state.sent(9_000, "get");
    let value = |key| line(&Sentence::Config { key, value: "1" });
    receive(&mut state, 9_010, &[&value("seed"), &value("modes")]);
    receive(
        &mut state,
        9_020,
        &[&line(&Sentence::Done { command: "get" })],
    );
    assert_eq!(
        state.asked.as_ref().unwrap().reply.as_ref().unwrap().1,
        "done"
    );
    state.sent(10_000, "selftest");
    assert!(!state.asked.as_ref().unwrap().overdue(20_000));
}

#[test]
fn lines_are_kept_with_their_time_and_way_but_for_live() {
    let mut state = scanned();
    receive(&mut state, 3_200, &["$PSTR,DONE,x*00000000"]);
    state.sent(3_300, "status");
    let ways: Vec<_> = state
        .log
        .iter()
        .map(|entry| (entry.at, entry.way))
        .collect();
    let expected = [
        (100, Way::Note),
        (3_000, Way::In),
        (3_000, Way::In),
        (3_000, Way::In),
        (3_000, Way::In),
        (3_200, Way::Damaged),
        (3_300, Way::Out),
    ];
    assert_eq!(ways, expected);
    for k in 0..2_500 {
        receive(&mut state, 4_000 + k, &["noise"]);
    }
    assert_eq!(state.log.len(), 2_000);
}

/// In an emulator a scan takes longer than the maximum age of an answer, and the module is connected after the
/// self-test.
#[test]
fn an_emulated_scanner_is_slow_and_begins_without_its_module() {
    let boot = scan(0, Status::Fault, &[Reason::LinkSilent]);
    for emulated in [false, true] {
        let mut state = State::new("pts", 0);
        if emulated {
            state = state.emulated();
        }
        state.take(100, &Event::Opened);
        receive(&mut state, 200, &[&boot]);
        assert_eq!(state.answer.is_none(), emulated, "the self-test's fault");
        receive(&mut state, 28_000, &STAIR_A);
        receive(&mut state, 56_000, &[&live(60_000, Some(28_200))]);
        let expected = if emulated {
            Validity::Fresh
        } else {
            Validity::Old
        };
        assert_eq!(state.standing(56_100), expected);
    }
}
