//! Valid inputs, from which `corpus/` is generated.
//!
//! `cargo run -p stairscan-fuzz --example mutate -- --write-corpus` writes them. This is necessary when a
//! target changes its input format.

use crate::targets;
use ed25519_dalek::SigningKey;
use host_sim::update::{keys, package::Package};
use stairscan::answer::{Direction, DropEdge, PossibleStep, Step};
use stairscan::motion::Agreement;
use stairscan::report::sentence::{ScanId, write_scan};
use stairscan::report::{BootLine, CrashSite, LiveLine, Sentence};
use stairscan::scanner::Settings;
use stairscan::verdict::{Assessment, Conditions, Evidence, Outcome, Reason, Reasons, Validity};
use stairscan_boot::header::{Header, NAME, PAYLOAD};
use stairscan_boot::layout::SLOTS;

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

/// Files of signed updates, each behind its kind's number.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let key = SigningKey::from_bytes(&[7; 32]);
    let package = Package::of(&key, |slot| {
        let payload = vec![slot as u8; 64];
        // Without the revision of this build, so that the corpus stays as it is.
        let name = [0; NAME];
        let header = Header {
            name,
            ..Package::header(&payload, slot, 3, &key)
        };
        (header, payload)
    });
    let key_file = |kind, bytes: [u8; 32]| format!("stairscan {kind} key {}\n", keys::hex(&bytes));
    let public = key_file("public", key.verifying_key().to_bytes());
    let secret = key_file("secret", key.to_bytes());
    let file = |kind: u8, bytes: &[u8]| [&[kind], bytes].concat();
    vec![
        ("package", file(0, &package.bytes())),
        ("public", file(1, public.as_bytes())),
        ("secret", file(1, secret.as_bytes())),
        ("elf", file(2, &elf(0x240, 0x220, SLOTS + PAYLOAD))),
        ("elf-short", file(2, &elf(0x204, 0x10, SLOTS + PAYLOAD))),
        ("elf-high", file(2, &elf(0x240, 0x220, u32::MAX))),
    ]
}

/// A small ELF file: a segment of `size` bytes for slot A, executed at `executed`, that holds one address at the offset
/// `at`, with its relocation.
fn elf(size: u32, at: u32, executed: u32) -> Vec<u8> {
    let half = |value: u16| value.to_le_bytes().to_vec();
    let words = |values: &[u32]| {
        values
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect::<Vec<_>>()
    };
    // Sizes of the headers of file, segment and section, and of a symbol and a relocation (ELF specification).
    let (file, segment, section, symbol, relocation) = (52_u32, 32_u32, 40_u32, 16_u32, 8_u32);
    let load = SLOTS + PAYLOAD;
    let target = load + 0x30;
    let mut payload = vec![0xff; size as usize];
    payload[at as usize..][..4].copy_from_slice(&target.to_le_bytes());
    let data = file + segment;
    let symbols = data + size;
    let relocations = symbols + 2 * symbol;
    let sections = relocations + relocation;
    let magic = [0x7f, b'E', b'L', b'F', 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    // Executable for Arm; tables of one segment and five sections, the last of which holds their names.
    let header = [
        magic.to_vec(),
        [half(2), half(40)].concat(),
        words(&[1, load, file, sections, 0]),
        [52, 32, 1, 40, 5, 4].map(half).concat(),
    ];
    let program = words(&[1, data, executed, load, size, size, 5, 4]);
    let symbol_table = words(&[0, 0, 0, 0, 0, target, 4, 0x0001_0010]);
    // R_ARM_ABS32 of symbol 1 at the payload's address.
    let relocation_table = words(&[executed.wrapping_add(at), 1 << 8 | 2]);
    let table = [
        words(&[0; 10]),
        words(&[0, 1, 6, load, data, size, 0, 0, 4, 0]),
        words(&[0, 2, 0, 0, symbols, 2 * symbol, 4, 1, 4, symbol]),
        words(&[0, 9, 0, 0, relocations, relocation, 2, 1, 4, relocation]),
        // One empty name: byte 7 of the file.
        words(&[0, 3, 0, 0, 7, 1, 0, 0, 1, 0]),
    ];
    debug_assert_eq!(table.concat().len() as u32, 5 * section);
    [
        header.concat(),
        program,
        payload,
        symbol_table,
        relocation_table,
        table.concat(),
    ]
    .concat()
}

fn update() -> Vec<(&'static str, Vec<u8>)> {
    let request = |kind: u8, payload: &[u8]| [vec![1, kind], counted(payload)].concat();
    let begin = request(3, &targets::update::offered());
    let data = |offset: u16, bytes: &[u8]| {
        let [low, high] = offset.to_le_bytes();
        [vec![2, low, high], counted(bytes)].concat()
    };
    let pieces = [
        begin.clone(),
        data(0, &[7; 200]),
        data(0, &[7; 200]),
        data(200, &[9; 200]),
        request(5, &[]),
        data(400, &[3; 200]),
        request(5, &[]),
        begin.clone(),
    ];
    let cut = [begin.clone(), data(0, &[1; 128]), vec![3, 1], begin];
    let noise = [
        vec![0],
        counted(b"$PSTC,stop*00000000\r\nSUSU\x04\x01\xff\xffSU\x01\x00\x00\x00"),
        request(1, &[]),
        request(2, &3_000_000_u32.to_le_bytes()),
        request(7, &[]),
        request(0x83, &[0; 5]),
        request(6, &[]),
    ];
    vec![
        ("pieces", pieces.concat()),
        ("cut", cut.concat()),
        ("noise", noise.concat()),
    ]
}

fn radar_link() -> Vec<(&'static str, Vec<u8>)> {
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

fn sirad() -> Vec<(&'static str, Vec<u8>)> {
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

fn bgt60() -> Vec<(&'static str, Vec<u8>)> {
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

/// Example of a settings hash.
const HASH: u32 = 0xDD17_E165;

fn commands() -> Vec<(&'static str, Vec<u8>)> {
    let settings = Settings::default();
    let each = |before: &str| -> Vec<u8> {
        let line = |key: &&str| {
            format!(
                "{before}set,{key},{}\n",
                settings.get(key).unwrap_or_default()
            )
        };
        Settings::KEYS
            .iter()
            .map(line)
            .collect::<String>()
            .into_bytes()
    };
    let words =
        "save\nstart\nstop\nscan\nstatus\r\nversion\nselftest\nget\nget,seed\nget stack-used\n";
    let wrong = "set\nset,seed\nset,seed,-1\nset,nothing,1\nget,\nset,plane,sideways\nhello\nset,seed,1,2\n\
                 $PSTC,stop*00000000\n$PSTC\n$*\n";
    let extremes = "!set,first-angle,-170000\n!set,angle-count,8192\n!set,angle-step,10000\n\
                    !set,cfar-false-alarm,500000000\n!set,mirror-offset,200000\n!set,settle,600000000\n!save\n";
    let motion = "!MOTION,7,123.4,-250\n!MOTION,65535,-2147483.6,\n!MOTION,1,x,45001\n";
    vec![
        ("words", words.into()),
        ("settings", each("")),
        ("framed-settings", each("!")),
        ("wrong", wrong.into()),
        ("extremes", extremes.into()),
        ("motion", motion.into()),
        (
            "long",
            [vec![b'z'; 200], b"\nstatus\n\x01\xFF\0\nstop\n".to_vec()].concat(),
        ),
    ]
}

fn sentences() -> Vec<(&'static str, Vec<u8>)> {
    let sight = Assessment {
        echo_found: true,
        valid: Some(Validity {
            horizon_m: 1.2,
            confidence: 0.993,
            first_step: 0.99,
        }),
        ..Assessment::nothing(Agreement::STANDING)
    };
    let evidence = Evidence {
        assessment: Some(sight),
        ..Evidence::default()
    };
    let mut outcome = Outcome::silent();
    outcome.decide(&evidence);
    outcome.answer.direction = Direction::Up;
    for k in 1..=3 {
        let step = Step {
            distance_m: 0.5 + 0.28 * k as f32,
            height_m: 0.17 * k as f32,
            distance_sigma_m: 0.0015,
            height_sigma_m: 0.004,
            quality: 100,
            ..Step::default()
        };
        // The list has room for sixteen.
        let _ = outcome.answer.steps.push(step);
    }
    outcome.answer.link();
    let mut degraded = outcome.clone();
    degraded.decide(&Evidence {
        health_faults: Reasons::NONE.with(Reason::Moving).with(Reason::Mount),
        ..evidence
    });
    let fault = Outcome::broken(Reasons::NONE.with(Reason::NoEcho), Conditions::GOOD);
    let maybe = PossibleStep {
        distance_m: 1.5,
        height_m: -0.1,
        probability: 0.2,
    };
    let _ = degraded.answer.possible_steps.push(maybe);
    degraded.answer.drop = Some(DropEdge {
        distance_m: 1.45,
        distance_sigma_m: 0.015,
        depth_m: Some(0.18),
        probability: 0.974,
    });
    // Without CRC and line end, so that changes of the text are not rejected by the CRC.
    let bare = |line: &str| {
        let body = line
            .trim_start_matches('$')
            .split('*')
            .next()
            .unwrap_or_default();
        format!("!{body}\n")
    };
    let lines = |outcome: &Outcome, lost: u16| {
        let mut text = String::new();
        write_scan(
            ScanId {
                scan: 7,
                settings: HASH,
            },
            lost,
            outcome,
            |line| text += &bare(line),
        );
        text.into_bytes()
    };
    let mut whole = Vec::new();
    write_scan(
        ScanId {
            scan: 1,
            settings: HASH,
        },
        0,
        &outcome,
        |line| whole.extend(line.as_bytes()),
    );
    let others = [
        Sentence::Boot(BootLine {
            version: "0.1.0",
            revision: "abcdef",
            reset: "power-on",
            clock: "hse-168",
            boots: 3,
            serial: [0x0033_0047, 0x3439_5110, 0x3530_3834],
            settings: HASH,
            second_memory: "ccm-64",
            option_bytes: Some(0x0fff_aaed),
            crash: CrashSite {
                pc: Some(0x0802_1234),
                lr: Some(0x0802_0801),
                cfsr: Some(0x8200),
                address: Some(0x4002_3c00),
                place: Some(HASH),
            },
        }),
        Sentence::State {
            state: "scanning",
            clock: "hsi-16",
            scans: 12,
            estimator: "likelihood",
            reasons: Reasons::NONE.with(Reason::LinkSilent),
            motion: "good",
            motion_faults: 3,
            settings: HASH,
        },
        Sentence::Live(LiveLine {
            state: "scanning",
            scan: 12,
            uptime_ms: 90_600,
            age_ms: Some(731),
            motion: "good",
            motion_faults: 3,
            refused: 1,
            port_errors: 0,
            link_errors: 2,
        }),
        Sentence::Config {
            key: "seed",
            value: "1",
        },
        Sentence::Done { command: "start" },
        Sentence::Fail {
            command: "set",
            field: "seed",
            expected: "a value",
        },
        Sentence::Halt {
            reason: Reason::MotorStall,
        },
    ];
    let others: String = others.iter().map(|s| bare(&s.write())).collect();
    vec![
        ("scan", lines(&outcome, 0)),
        ("degraded", lines(&degraded, 3)),
        ("fault", lines(&fault, 0)),
        ("framed", whole),
        ("others", others.into_bytes()),
    ]
}

fn motion() -> Vec<(&'static str, Vec<u8>)> {
    let reading = |more: u8, travel: i16, pitch: i16| {
        let ([a, b], [c, d]) = (travel.to_le_bytes(), pitch.to_le_bytes());
        vec![1, more, a, b, c, d]
    };
    let begin = vec![2, 12, 0];
    let rows = |count| [3, 5, 46, 0].repeat(count);
    let good: Vec<u8> = (0..6)
        .flat_map(|k| [reading(1, 30, k), rows(2)].concat())
        .collect();
    let drive = |middle: Vec<u8>| {
        [
            reading(1, 0, 0),
            begin.clone(),
            good.clone(),
            middle,
            good.clone(),
            vec![4],
        ]
        .concat()
    };
    let text = [
        vec![0],
        counted(b"MOTION,7,123.4,-250"),
        vec![0],
        counted(b"MOTION,8,125.0,"),
    ]
    .concat();
    vec![
        ("two-scans", [drive(Vec::new()), drive(Vec::new())].concat()),
        ("late", drive(vec![5, 0xFF, 0x0F])),
        ("jump", drive(reading(1, 30_000, 4_000))),
        ("disordered", drive(reading(0xFF, 0, 0))),
        ("garbled", drive(vec![7])),
        ("text", [text, begin.clone(), rows(12), vec![4]].concat()),
        ("hours", drive(vec![6, 0xFF, 0xFF, 0xFF, 0x7F])),
    ]
}

/// Returns a recording of 16 samples a chirp with these captures and, besides the mandatory keys, those of
/// `global`.
fn recording(global: &str, captures: &[String]) -> Vec<u8> {
    let text = format!(
        "{{\"global\": {{\"core:datatype\": \"ci16_le\", \"core:version\": \"1.2.0\", \"core:sample_rate\": 2e5,\n\
         \"stairscan:bandwidth_hz\": 1e10, \"stairscan:samples_per_chirp\": 16{global}}},\n\
         \"captures\": [{}], \"annotations\": []}}",
        captures.join(",\n")
    );
    let samples = (0..captures.len() * 64).map(|k| (k * k) as u8);
    text.into_bytes()
        .into_iter()
        .chain([0])
        .chain(samples)
        .collect()
}

fn recordings() -> Vec<(&'static str, Vec<u8>)> {
    let mirror = ",\n\"stairscan:mirror_offset_m\": 0.02, \"stairscan:beamwidth_deg\": 5.0, \
                  \"stairscan:mount_height_m\": 0.4, \"stairscan:scan_plane\": \"depth\"";
    let truth = ",\n\"stairscan:truth\": {\"direction\": \"up\", \"steps\": [{\"distance_m\": 0.5, \
                 \"height_m\": 0.17, \"snr_db\": 30.0}], \"uncounted\": []}";
    let disturbed = ",\n\"stairscan:disturbance\": {\"kind\": \"rain\", \"harmful\": true, \"rate\": 3}, \
                     \"stairscan:pitch_deg\": 1.5";
    let capture = |k: usize, angle: f64, more: &str| {
        format!(
            "{{\"core:sample_start\": {}, \"core:frequency\": 9.4e10, \
             \"stairscan:mirror_angle_deg\": {angle}{more}}}",
            16 * k
        )
    };
    let single: Vec<String> = (0..4)
        .map(|k| capture(k, -1.0 + 0.5 * k as f64, ""))
        .collect();
    let back_and_forth: Vec<String> = (0..6)
        .map(|k| {
            let angle = 0.25 * if k < 3 { k as f64 } else { 5.0 - k as f64 };
            let t = k as f64;
            let more = format!(
                ", \"stairscan:travel_m\": {:.4}, \"stairscan:time_s\": {:.3}, \"stairscan:pitch_deg\": {:.2}",
                0.001 * t,
                0.005 * t,
                0.1 * t
            );
            capture(k, angle, &more)
        })
        .collect();
    let sequence = format!(
        "{mirror},\n\"stairscan:scans\": 2, \"stairscan:truth_travel_m\": [0.002, 0.005], \
         \"stairscan:truth_scans\": [{{\"direction\": \"none\", \"steps\": []}}, \
         {{\"direction\": \"none\"}}]"
    );
    let falling: Vec<String> = (0..5)
        .map(|k| capture(k, 3.0 - 0.5 * k as f64, ""))
        .collect();
    vec![
        ("single", recording(&format!("{mirror}{truth}"), &single)),
        ("sequence", recording(&sequence, &back_and_forth)),
        (
            "falling",
            recording(&format!("{mirror}{disturbed}"), &falling),
        ),
        (
            "no-mirror",
            recording("", &["{\"core:sample_start\": 0}".to_owned()]),
        ),
    ]
}

fn scenes() -> Vec<(&'static str, Vec<u8>)> {
    let odd = "[radar]\ncarrier_hz = 94e9\nsamples_per_chirp = 128\n[mount]\nheight_m = 0.5\npitch_deg = 1.0\n\
               [sweep]\nfirst_deg = -10.0\nlast_deg = 40.0\nstep_deg = 0.5\n[mirror]\njitter_deg = 0.01\n\
               [material.rubber]\nroughness_m = 1e-3\n[[floor]]\nfrom_m = -1.0\nto_m = 1.0\nmaterial = \"rubber\"\n\
               [[box]]\nfrom_m = 0.6\nto_m = 0.8\ntop_m = 0.3\nmaterial = \"metal\"\n\
               [[polyline]]\npoints = [[1.0, 0.0], [1.2, 0.3], [1.4, 0.3]]\nmaterial = \"wood\"\n";
    let file = |text: &str| text.as_bytes().to_vec();
    vec![
        ("stair_a", file(include_str!("../../scenes/stair_a.toml"))),
        ("stair_b", file(include_str!("../../scenes/stair_b.toml"))),
        ("stair_c", file(include_str!("../../scenes/stair_c.toml"))),
        (
            "descending",
            file(include_str!("../../scenes/descending.toml")),
        ),
        ("empty", file(include_str!("../../scenes/empty.toml"))),
        ("odd", file(odd)),
    ]
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
