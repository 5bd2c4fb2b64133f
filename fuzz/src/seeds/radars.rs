//! Seeds of the radar modules' protocols: bytes that a module sends.

use super::counted;

pub(super) fn radar_link() -> Vec<(&'static str, Vec<u8>)> {
    let ask = |what: u8| vec![what, 50, 0];
    let frame =
        |off: i8, kind: u8, payload: &[u8]| [vec![3, off as u8, kind], counted(payload)].concat();
    let settings = [0x80, 0x53, 0x9A, 0x05, 0x80, 0x96, 0x98, 0, 4, 0, 0, 0];
    let chirp: Vec<u8> = (0..16).collect();
    let well = [ask(0), frame(0, 0, &settings), ask(1), frame(0, 1, &chirp)].concat();
    let late = [
        ask(1),
        vec![4, 60, 0],
        ask(1),
        frame(-1, 1, &chirp),
        frame(0, 1, &chirp),
    ]
    .concat();
    let errors = [
        ask(0),
        frame(0, 2, &[1]),
        ask(1),
        frame(0, 0, &settings),
        ask(1),
        frame(0, 1, &chirp[..12]),
    ];
    let noise = [
        vec![2],
        counted(b"SSR\x01\x82SR\x02SR\x01\x77SR\x01\x82\0\0\xFF\xFF"),
        ask(1),
        frame(0, 1, &chirp),
    ];
    vec![
        ("settings-and-chirp", well),
        ("late", late),
        ("errors", errors.concat()),
        ("noise", noise.concat()),
        (
            "own-requests",
            [
                ask(1),
                frame(0, 3, &[]),
                frame(0, 4, &[1, 2, 3, 4]),
                frame(0, 5, &[0]),
            ]
            .concat(),
        ),
    ]
}

pub(super) fn sirad() -> Vec<(&'static str, Vec<u8>)> {
    let programs = vec![0, 0x80, 0x8D, 0x5B, 0, 32, 0, 244, 1];
    let trigger = vec![1, 244, 1];
    let frame = |how: u8, counter: u8, numbers: u8| vec![how, counter, 0, numbers, 1, 130, 200, 90];
    let passes = vec![6, 200, 0];
    let ready = [
        programs,
        vec![5],
        frame(3, 1, 64),
        passes.clone(),
        passes.clone(),
    ]
    .concat();
    let chirps = [
        ready.clone(),
        trigger.clone(),
        frame(3, 2, 64),
        trigger.clone(),
        frame(4, 3, 64),
    ];
    let late = [
        ready.clone(),
        trigger.clone(),
        vec![6, 245, 1],
        trigger.clone(),
        frame(3, 2, 64),
        vec![5],
        frame(3, 3, 64),
    ];
    let wrong = [
        ready.clone(),
        trigger.clone(),
        frame(3, 1, 64),
        trigger.clone(),
        vec![5],
        frame(4, 2, 62),
    ];
    let noise = [
        ready,
        trigger,
        vec![2],
        counted(b"\xAA\xAA\xBB\xCCM\x01\0\x40\0!E\t12\t3\r\n!U\t-7\r\n"),
        frame(3, 5, 64),
    ];
    vec![
        ("chirps", chirps.concat()),
        ("late", late.concat()),
        ("wrong", wrong.concat()),
        ("noise", noise.concat()),
    ]
}

pub(super) fn bgt60() -> Vec<(&'static str, Vec<u8>)> {
    let programs = vec![0, 0xC0, 0x5C, 0x54, 0, 64, 0, 200, 0];
    let passes = vec![4, 0x40, 0x9C];
    let soon = vec![4, 0xD0, 7];
    let trigger = vec![1, 63, 20, 0];
    let fault = |kind: u8, detail: u8| vec![3, kind, detail];
    let ready = [programs.clone(), passes.clone(), soon.clone()].concat();
    let chirp = [trigger, soon.clone(), soon.clone(), soon].concat();
    let damaged = |flips: &[u8]| [vec![2], counted(flips)].concat();
    let flips = [ready.clone(), damaged(&[0, 0, 1, 0, 0x80]), chirp.clone()];
    let stranger = [fault(1, 9), programs.clone(), passes.clone()];
    let stuck = [fault(2, 5), programs, passes];
    let full = [ready.clone(), fault(4, 0), chirp.clone(), fault(8, 0)];
    let short = [ready.clone(), fault(5, 3), chirp.clone(), chirp.clone()];
    vec![
        ("chirp", [ready, chirp].concat()),
        ("flips", flips.concat()),
        ("stranger", stranger.concat()),
        ("stuck", stuck.concat()),
        ("full", full.concat()),
        ("short", short.concat()),
    ]
}
