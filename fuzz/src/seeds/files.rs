//! Inputs that are files: keys, packages and images of an update, recordings, scenes; and the requests that send an update.

use super::counted;
use crate::targets;
use ed25519_dalek::SigningKey;
use host_sim::update::{keys, package::Package};
use stairscan_boot::header::{Header, NAME, PAYLOAD};
use stairscan_boot::layout::SLOTS;

/// Files of signed updates, each behind its kind's number.
pub(super) fn files() -> Vec<(&'static str, Vec<u8>)> {
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

pub(super) fn update() -> Vec<(&'static str, Vec<u8>)> {
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

pub(super) fn recordings() -> Vec<(&'static str, Vec<u8>)> {
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

pub(super) fn scenes() -> Vec<(&'static str, Vec<u8>)> {
    let odd = "[radar]\ncarrier_hz = 94e9\nsamples_per_chirp = 128\n[mount]\nheight_m = 0.5\npitch_deg = 1.0\n\
               [sweep]\nfirst_deg = -10.0\nlast_deg = 40.0\nstep_deg = 0.5\n[mirror]\njitter_deg = 0.01\n\
               [material.rubber]\nroughness_m = 1e-3\n[[floor]]\nfrom_m = -1.0\nto_m = 1.0\nmaterial = \"rubber\"\n\
               [[box]]\nfrom_m = 0.6\nto_m = 0.8\ntop_m = 0.3\nmaterial = \"metal\"\n\
               [[polyline]]\npoints = [[1.0, 0.0], [1.2, 0.3], [1.4, 0.3]]\nmaterial = \"wood\"\n";
    let file = |text: &str| text.as_bytes().to_vec();
    vec![
        (
            "stair_a",
            file(include_str!("../../../scenes/stair_a.toml")),
        ),
        (
            "stair_b",
            file(include_str!("../../../scenes/stair_b.toml")),
        ),
        (
            "stair_c",
            file(include_str!("../../../scenes/stair_c.toml")),
        ),
        (
            "descending",
            file(include_str!("../../../scenes/descending.toml")),
        ),
        ("empty", file(include_str!("../../../scenes/empty.toml"))),
        ("odd", file(odd)),
    ]
}
