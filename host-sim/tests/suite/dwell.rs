//! Tests of several chirps per row: simulated, in recordings, played by the emulated module.

use std::path::{Path, PathBuf};

use host_sim::emulate::Module;
use host_sim::playback::Playback;
use host_sim::recording::Recording;
use host_sim::scene::Scene;
use serde_json::{Value, json};
use stairscan::Iq;
use stairscan::config::{Config, RadarConfig};
use stairscan::signal::radar::frame::{
    Decoder, FrameKind, MAX_FRAME, Progress, encode, parse_settings, requested_payload,
};
use stairscan::signal::radar::module::RequestedSettings;

use crate::common::{Scratch, refused, sim};

const SCENE: &str = "[sweep]\nfirst_deg = 0.0\nlast_deg = 20.0\n\
                     [[wall]]\nat_m = 1.2\nmaterial = \"concrete\"\n\
                     [[floor]]\nmaterial = \"concrete\"\n";

/// Returns a scan of a wall and the floor with `chirps` chirps per row, and with further lines of the scene file.
fn scan(chirps: u8, further: &str) -> Recording {
    let scene = Scene::parse(&format!("{further}\n{SCENE}")).unwrap();
    scene.with_chirps(chirps).unwrap().simulate("scan", 3)
}

fn written(scratch: &Scratch, recording: &Recording) -> PathBuf {
    let path = scratch.path().join("scan");
    recording.write(&path).unwrap();
    path
}

fn run(args: &[&str]) -> String {
    let out = sim(args);
    let message = String::from_utf8_lossy(&out.stderr).into_owned();
    assert_eq!(out.status.code(), Some(0), "{args:?}: {message}");
    String::from_utf8(out.stdout).unwrap()
}

/// Returns the mean square of the differences of two recordings' samples.
fn difference(a: &Recording, b: &Recording) -> f64 {
    let square = |a: i16, b: i16| (f64::from(a) - f64::from(b)).powi(2);
    let pair = |(a, b): (&Iq, &Iq)| square(a.i, b.i) + square(a.q, b.q);
    let sum: f64 = a.samples.iter().zip(&b.samples).map(pair).sum();
    sum / a.samples.len() as f64
}

#[test]
fn the_noise_of_a_row_falls_by_the_number_of_its_chirps() {
    // Without leakage, whose phase has the error with which that of the mirror's echo is measured.
    const SILENT: &str = "[receiver]\nleakage_dbfs = -100\ndc_i = 0\ndc_q = 0\n";
    let silent =
        format!("{SILENT}noise_figure_db = -100\nphase_noise_dbc_hz = -300\nadc_bits = 16");
    let clean = scan(1, &silent);
    let one = difference(&scan(1, SILENT), &clean);
    for chirps in [2, 8, 32] {
        let share = one / difference(&scan(chirps, SILENT), &clean) / f64::from(chirps);
        // The error of the measured phase stays, in the mirror's own echo, too.
        assert!((0.75..1.1).contains(&share), "{chirps}: {share}");
    }
}

#[test]
fn one_chirp_per_row_is_the_recording_without_the_key() {
    let (plain, one) = (
        Scene::parse(SCENE).unwrap().simulate("scan", 3),
        scan(1, ""),
    );
    assert_eq!(plain.samples, one.samples);
    assert_eq!(one.meta.chirps_per_row, None);
    for bad in [0, 33] {
        let error = Scene::parse(SCENE).unwrap().with_chirps(bad).err().unwrap();
        assert!(
            error.to_string().contains("radar.chirps_per_row"),
            "{error}"
        );
    }
}

#[test]
fn a_recording_states_its_chirps_per_row_and_keeps_them() {
    let scratch = Scratch::new("dwell-keys");
    let path = written(&scratch, &scan(4, ""));
    let (path, copy) = (path.to_str().unwrap(), scratch.path().join("copy"));
    let (array, again) = (scratch.path().join("a.npy"), scratch.path().join("again"));
    let [copy, array, again] = [&copy, &array, &again].map(|path| path.to_str().unwrap());
    run(&["convert", path, "-o", copy]);
    run(&["convert", path, "-o", array]);
    run(&["convert", array, "--keys-of", path, "-o", again]);
    for name in [path, copy, again] {
        let recording = Recording::read(Path::new(name)).unwrap();
        assert_eq!(recording.meta.chirps_per_row, Some(4), "{name}");
    }
    assert!(run(&["inspect", path]).contains("4 chirps per row"));
    let json: Value = serde_json::from_str(&run(&["inspect", path, "--format", "json"])).unwrap();
    assert_eq!(json["chirps_per_row"], 4);
}

#[test]
fn a_wrong_number_of_chirps_per_row_is_refused() {
    for bad in [json!(0), json!(33), json!(1.5), json!("four")] {
        let scratch = Scratch::new("dwell-bad");
        let captures = [json!({"core:sample_start": 0, "core:frequency": 94e9})];
        let key = json!({"stairscan:chirps_per_row": bad});
        let recording = scratch.damaged(&captures, key, |_| ());
        let printed = ["bad.sigmf-meta", "stairscan:chirps_per_row", "from 1 to 32"];
        refused(&recording, &printed);
    }
}

/// Returns the kind and the payload of the module's answer to a request.
fn answer(module: &mut Module<'_>, kind: FrameKind, payload: &[u8]) -> (FrameKind, Vec<u8>) {
    let mut request = heapless::Vec::<u8, MAX_FRAME>::new();
    encode(kind, 1, payload, &mut request);
    let (bytes, _) = module.receive(&request);
    let mut decoder = Decoder::new();
    let last = bytes.iter().map(|&byte| decoder.push(byte)).last();
    assert_eq!(last, Some(Ok(Progress::Complete)));
    let frame = decoder.frame().unwrap();
    (frame.kind, frame.payload.to_vec())
}

#[test]
fn the_emulated_module_answers_only_who_asked_for_the_recordings_chirps() {
    for recorded in [1, 8] {
        let recording = scan(recorded, "");
        let playback = Playback::new(&recording, &Config::default()).unwrap();
        assert_eq!(playback.settings().module.chirps, recorded);
        let mut module = Module::new(&playback);
        module.get_ready();
        for chirps in [1, 8] {
            let requested = RequestedSettings {
                chirps,
                ..RequestedSettings::DEFAULT
            };
            let payload = requested_payload(&requested);
            let (kind, payload) = answer(&mut module, FrameKind::Program, &payload);
            assert_eq!(kind, FrameKind::Settings);
            let (radar, ability) = parse_settings(&payload).unwrap();
            assert_eq!(
                (radar, ability.adds),
                (RadarConfig::default(), recorded > 1)
            );
            let (kind, _) = answer(&mut module, FrameKind::Trigger, &0_i32.to_le_bytes());
            let expected = match chirps == recorded {
                true => FrameKind::Chirp,
                false => FrameKind::Error,
            };
            assert_eq!(kind, expected, "{recorded} {chirps}");
        }
        // A plain request for the settings stands for one chirp per row.
        answer(&mut module, FrameKind::Configure, &[]);
        let (kind, _) = answer(&mut module, FrameKind::Trigger, &0_i32.to_le_bytes());
        assert_eq!(kind == FrameKind::Chirp, recorded == 1);
    }
}
