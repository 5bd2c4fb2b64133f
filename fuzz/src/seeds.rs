//! Valid inputs, from which `corpus/` is generated.
//!
//! `cargo run -p stairscan-fuzz --example mutate -- --write-corpus` writes them. This is necessary when a
//! target changes its input format.

mod files;
mod radars;
mod report_port;

use files::{files, recordings, scenes, update};
use radars::{bgt60, radar_link, sirad};
use report_port::{commands, motion, sentences};

/// An input: target, name, bytes.
pub type Seed = (&'static str, String, Vec<u8>);

/// Returns all inputs.
pub fn all() -> Vec<Seed> {
    let mut seeds = Vec::new();
    let mut put = |target: &'static str, inputs: Vec<(&str, Vec<u8>)>| {
        seeds.extend(
            inputs
                .into_iter()
                .map(|(name, bytes)| (target, name.to_owned(), bytes)),
        );
    };
    put("radar_link", radar_link());
    put("sirad", sirad());
    put("bgt60", bgt60());
    put("commands", commands());
    put("sentences", sentences());
    put("motion", motion());
    put("recordings", recordings());
    put("scenes", scenes());
    put("scanner", scanner());
    put("pipeline", pipeline());
    put("update", update());
    put("files", files());
    seeds
}

/// Returns bytes with a leading length byte.
fn counted(bytes: &[u8]) -> Vec<u8> {
    let count = bytes.len().min(255);
    [&[count as u8], &bytes[..count]].concat()
}

fn scanner() -> Vec<(&'static str, Vec<u8>)> {
    let wait = |steps: usize| [0, 255].repeat(steps.div_ceil(256));
    let line = |text: &str| [vec![3], counted(text.as_bytes())].concat();
    let moods = (0..10_u8).flat_map(|mood| [vec![4, mood], wait(600)].concat());
    let stalls = [
        wait(400),
        vec![5, 1],
        wait(3000),
        vec![5, 2],
        wait(3000),
        vec![5, 4],
        wait(3000),
    ];
    let reported = [
        wait(300),
        line("status"),
        line("set,angle-count,40"),
        line("get"),
        wait(256),
        line("stop"),
        line("selftest"),
        wait(300),
        line("scan"),
        line("scan"),
        wait(300),
        line("MOTION,7,123.4,-250"),
        vec![2],
        counted(b"start\r\nversion\n\xFF\xFEhello\n$PSTC,stop*12345678\n"),
        wait(300),
    ];
    let encoded = [
        line("set,encoder,as5600"),
        wait(1000),
        vec![8, 40],
        wait(3000),
        vec![8, 1],
        wait(1000),
        line("set,encoder-home,77000"),
        vec![8, 0],
        wait(1000),
    ];
    let full = [
        vec![6, 0],
        wait(2000),
        line("get"),
        wait(256),
        vec![6, 3],
        line("stop"),
        wait(256),
        line("start"),
    ];
    let verdicts = [
        vec![7, 2],
        wait(512),
        vec![7, 4],
        wait(512),
        vec![7, 1],
        line("stop"),
        line("selftest"),
        wait(256),
    ];
    let slow = [
        line("set,settle,600000000"),
        line("set,fault-hold,600000000"),
        line("set,angle-count,8000"),
        line("set,angle-step,40"),
        wait(500),
        vec![4, 1],
        vec![1, 255, 255],
        wait(500),
    ];
    vec![
        ("moods", moods.collect()),
        ("stalls", stalls.concat()),
        ("told", reported.concat()),
        ("full", full.concat()),
        ("encoded", encoded.concat()),
        ("verdicts", verdicts.concat()),
        ("slow", slow.concat()),
    ]
}

fn pipeline() -> Vec<(&'static str, Vec<u8>)> {
    // In this order: 200 samples, 10 GHz, 281 rows of 0.25 degrees, 22 cm, 40 cm.
    let setup = |bits: u8, rows: u16| {
        let [low, high] = rows.to_le_bytes();
        vec![199, 199, low, high, 25, bits, 22, 40]
    };
    let cfar = (3 << 2) | (7 << 5);
    let points = |points: &[[i16; 3]]| -> Vec<u8> {
        let point = |&[x, y, level]: &[i16; 3]| [x as u8, y as i8 as u8, level as u8, 37];
        [
            vec![points.len() as u8],
            points.iter().flat_map(point).collect(),
        ]
        .concat()
    };
    // Edges and inner corners of three steps, and the ground in front of them.
    let stairs = points(&[
        [50, -24, 30],
        [78, -7, 33],
        [106, 9, 36],
        [50, -39, 40],
        [78, -23, 42],
        [106, -7, 42],
        [44, -40, 55],
        [38, -40, 52],
        [56, -40, 60],
    ]);
    let wall = points(&[
        [150, -40, 20],
        [150, -20, 30],
        [150, 0, 25],
        [150, 12, 30],
        [40, -40, 50],
    ]);
    let [low, high] = 20_000_i16.to_le_bytes();
    let tone = [5, 0x33, 0x33, 0, 0x20];
    let raw = [vec![4], counted(&(0..240).collect::<Vec<u8>>())].concat();
    vec![
        ("stairs", [setup(cfar, 281), stairs.clone()].concat()),
        (
            "stairs-paper",
            [setup(cfar | 2, 281), stairs.clone()].concat(),
        ),
        (
            "stairs-height",
            [setup(cfar | 1, 281), stairs.clone()].concat(),
        ),
        (
            "stairs-real",
            [setup(cfar, 1 << 15 | 281), stairs.clone()].concat(),
        ),
        ("wall", [setup(cfar, 281), wall].concat()),
        (
            "tone",
            [
                setup(cfar, 281),
                stairs.clone(),
                tone.repeat(60),
                vec![1, 40],
                tone.repeat(20),
            ]
            .concat(),
        ),
        (
            "shifted",
            [setup(cfar, 281), stairs.clone(), [7, 6].repeat(281)].concat(),
        ),
        (
            "lost",
            [setup(cfar, 281), stairs.clone(), [1, 30, 2, 2, 2].repeat(8)].concat(),
        ),
        (
            "repeated",
            [setup(cfar, 281), stairs, vec![1, 90], vec![6; 120]].concat(),
        ),
        ("silent", [setup(cfar, 60), vec![0]].concat()),
        (
            "constant",
            [
                setup(cfar, 60),
                vec![0],
                [3, low, high, high, low].repeat(120),
            ]
            .concat(),
        ),
        ("raw", [setup(cfar, 24), vec![0], raw.repeat(6)].concat()),
        (
            "short-chirps",
            [
                vec![15, 255, 40, 0, 100, cfar, 1, 40],
                vec![0],
                tone.repeat(40),
            ]
            .concat(),
        ),
    ]
}
