use super::*;

const ANSWER: [&str; 4] = [
    "$PSTR,SCAN,1,ok,up,3,0,,1000.0,98.9,0,100152FB,0*48425B4C",
    "$PSTR,STEP,1,1,3,500.5,165.4,279.5,165.4,1.5,3.7,100*2688B9C3",
    "$PSTR,STEP,1,2,3,780.0,330.7,280.6,165.3,1.5,13.6,100*252F41B4",
    "$PSTR,STEP,1,3,3,1060.7,495.1,,164.4,1.5,23.0,100*25D20E0E",
];

/// Returns the times of the answers in a log of two, and its clock.
fn times(bytes: &[u8]) -> (Vec<Ms>, &'static str, Option<u64>) {
    let log = Log::read("log", bytes).unwrap();
    let answers = log.answers();
    assert!(answers.iter().all(|(_, answer)| answer.sentences == ANSWER));
    let times = answers.iter().map(|(at, _)| *at).collect();
    (times, log.clock, log.begun_ms)
}

/// Returns a log of two answers with `before` before each line of the first and of the second, and `end` after it.
fn log(before: [&str; 2], end: &str) -> String {
    let lines = |before: &str| -> String {
        ANSWER
            .iter()
            .map(|line| format!("{before}{line}{end}"))
            .collect()
    };
    lines(before[0]) + &lines(before[1])
}

#[test]
fn any_loggers_times_are_read() {
    let day = 86_400_000;
    for (before, gap, begun) in [
        (["0 < ", "2500 < "], 2_500, None),
        (["[23:59:59.900] ", "[00:00:00.100] "], 200, None),
        (["12:00:01 -> ", "12:00:02 -> "], 1_000, None),
        (
            ["2026-11-27T10:00:00.5Z ", "2026-11-28 10:00:01.250 "],
            day + 750,
            Some(1_795_773_600_500),
        ),
        (
            ["[2026/11/27 9:00:00,5]", "[2026/11/27 9:00:00,75]"],
            250,
            Some(1_795_770_000_500),
        ),
        (["Nov 27 23:50:13 ", "Nov 27 23:50:15 "], 2_000, None),
        (["[0.500000 0.000012] ", "[1.750000 1.2] "], 1_250, None),
        (
            ["1795773600.25 ", "1795773601.5 "],
            1_250,
            Some(1_795_773_600_250),
        ),
        (
            ["1795773600250,", "1795773600750,"],
            500,
            Some(1_795_773_600_250),
        ),
        (["40 ms: ", "90 ms: "], 50, None),
        (["12\t", "15\t"], 3, None),
    ] {
        for end in ["\r\n", "\n", "\r", "\n\r"] {
            let (times, clock, read) = times(log(before, end).as_bytes());
            let first = times[0];
            assert_eq!(
                (times[1] - first, clock, read),
                (gap, "log", begun),
                "{before:?}"
            );
        }
    }
}

#[test]
fn without_times_those_of_live_count() {
    let live = |ms: u32| {
        let body = format!("PSTR,LIVE,scanning,1,{ms},,absent,0,0,0,0");
        format!(
            "${body}*{:08X}\n",
            stairscan::report::sentence::crc32(&body)
        )
    };
    let answer = log(["", ""], "\n");
    let half = answer.len() / 2;
    let with = [
        &live(5_000)[..],
        &answer[..half],
        &live(5_200),
        &answer[half..],
        &live(100),
        &live(300),
    ];
    let text = with.concat();
    assert_eq!(times(text.as_bytes()), (vec![0, 200], "LIVE", None));
    // A restart: the clock of the scanner begins anew.
    assert_eq!(Log::read("log", text.as_bytes()).unwrap().length(), 400);
    assert_eq!(times(answer.as_bytes()), (vec![0, 1_000], "none", None));
    // Digits of noise are no times.
    assert_eq!(times(log(["3", "7"], "\n").as_bytes()).1, "none");
}

#[test]
fn marks_noise_and_wide_letters_are_taken() {
    let text = log(["0 < ", "900 < "], "\r\n");
    let noise =
        format!("\u{feff}login: \r\n0 # the port is open\r\n{text}900 < \\x00\\xff\n\0\0\n");
    assert_eq!(times(noise.as_bytes()).0, [0, 900]);
    let wide: Vec<u8> = (noise.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    assert_eq!(times(&wide).0, [0, 900]);
    assert!(may_be(&wide) && !may_be(b"PSTR"));
    // What `live` tells in its first line, what it sent, and what `replay` gave.
    let kept = format!(
        "0 # live of p, begun 7 s after 1970\n{text}1000 > stop\n5 r {}\n",
        ANSWER[0]
    );
    let read = Log::read("log", kept.as_bytes()).unwrap();
    assert_eq!(
        (read.begun_ms, read.answers().len(), read.length()),
        (Some(7_000), 2, 1_000)
    );
    assert_eq!(read.lines.last().unwrap().way, Way::Out);
}

#[test]
fn a_log_without_sentences_is_explained() {
    for (bytes, part) in [
        (&b""[..], "it is empty"),
        (b"boot\nlogin:\n", "another device"),
        (b"$GPGGA,1,2*47\r\n", "a GPS receiver"),
        (b"$PSTR,DONE,stop*00000000\n", "damaged"),
        (b"\xff\xfe\x80\n", "not text"),
        (b"\xf0\xfe\x80\n", "not text"),
    ] {
        let error = Log::read("log", bytes).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}
