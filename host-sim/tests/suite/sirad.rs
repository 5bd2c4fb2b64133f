//! Tests of a staircase scanned with a SiRad: each chirp from its model, through its protocol, to the
//! scanner's answer.

use std::cell::RefCell;
use std::task::Poll;

use host_sim::modules::sirad::{SiRadPort, converted};
use host_sim::recording::Recording;
use host_sim::replay::{self, Options};
use host_sim::scene::Scene;
use host_sim::scene::spec::SceneSpec;
use host_sim::score;
use stairscan::Iq;
use stairscan::config::RadarConfig;
use stairscan::scanner::Micros;
use stairscan::signal::radar::module::{ModuleKind, Wish};
use stairscan::signal::radar::sirad::SiRad;
use stairscan::verdict::Status;

const TIMEOUT_US: u32 = 500_000;
const STEP_US: u32 = 1_000;

/// Waits for an answer that must be delivered.
fn wait<T, E: std::fmt::Debug>(
    now: &mut u32,
    mut poll: impl FnMut(Micros) -> Poll<Result<T, E>>,
) -> T {
    for _ in 0..2 * TIMEOUT_US / STEP_US {
        *now = now.wrapping_add(STEP_US);
        if let Poll::Ready(answer) = poll(Micros(*now)) {
            return answer.unwrap();
        }
    }
    panic!("no answer")
}

/// Returns the radar with the module's default settings.
fn programmed() -> RadarConfig {
    let mut port = SiRadPort::new(Box::new(|samples| Some(vec![[0; 2]; samples])));
    let (mut module, mut now) = (SiRad::new(), 0);
    let wish = Wish {
        kind: ModuleKind::SiRad,
        ..Wish::default()
    };
    module.program(&mut port, Micros(now), &wish, TIMEOUT_US);
    wait(&mut now, |at| module.settings(&mut port, at))
}

/// Simulates the staircase with that radar.
fn simulated(radar: &RadarConfig) -> Recording {
    let mut spec: SceneSpec = toml::from_str(include_str!("../../../scenes/stair_a.toml")).unwrap();
    spec.radar.carrier_hz = 1e3 * f64::from(radar.carrier_khz);
    spec.radar.bandwidth_hz = 1e3 * f64::from(radar.bandwidth_khz);
    spec.radar.samples_per_chirp = radar.samples.into();
    spec.receiver.adc_bits = 12;
    Scene::new(spec).unwrap().simulate("stair_a", 0)
}

/// Returns the recording with each chirp requested and sent by the module's protocol.
fn sent(recording: &Recording, radar: &RadarConfig) -> Recording {
    let angle = RefCell::new(0);
    let source = |samples: usize| {
        let chirp = recording.chirp(*angle.borrow()).unwrap();
        assert_eq!(chirp.len(), samples);
        Some(converted(chirp))
    };
    let mut port = SiRadPort::new(Box::new(source));
    let (mut module, mut now) = (SiRad::new(), 0);
    let wish = Wish {
        kind: ModuleKind::SiRad,
        ..Wish::default()
    };
    module.program(&mut port, Micros(now), &wish, TIMEOUT_US);
    let set = wait(&mut now, |at| module.settings(&mut port, at));
    assert_eq!(set, *radar);
    let mut samples = Vec::new();
    for row in 0..recording.chirps() {
        *angle.borrow_mut() = row;
        let mut chirp = vec![Iq::default(); radar.samples.into()];
        module.trigger(&mut port, Micros(now), 0, TIMEOUT_US);
        wait(&mut now, |at| module.poll(&mut port, at, &mut chirp));
        samples.extend(chirp);
    }
    Recording {
        samples,
        ..recording.clone()
    }
}

#[test]
fn finds_the_stairs() {
    let radar = programmed();
    assert_eq!((radar.samples, radar.bandwidth_khz), (256, 5_233_390));
    let recording = sent(&simulated(&radar), &radar);
    let answer = replay::answer(&recording, &Options::default()).unwrap();
    let truth = recording.meta.truth.clone().unwrap();
    let score = score::scene(&answer, &truth);
    assert_ne!(score.status, Status::Fault, "{score:?}");
    assert!(score.exact, "{score:?}");
    for found in &score.matches {
        assert!(found.distance_error.abs() < 0.03, "{found:?}");
        assert!(found.height_error.abs() < 0.03, "{found:?}");
    }
}
