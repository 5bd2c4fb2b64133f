//! Tests of `plane both`: the scanner's own loop scans a scene in the depth plane, and in the height plane when the
//! chair stands in front of a drop.
//!
//! The simulator renders a scene in one plane at a time, so that each scene is two recordings: the same surfaces,
//! scanned with one shaft, which turns from row to row of either recording.

use std::cell::RefCell;
use std::rc::Rc;

use host_sim::playback::{Playback, SimShaft};
use host_sim::recording::Recording;
use host_sim::scene::Scene;
use host_sim::volatile::{Volatile, identity};
use stairscan::Iq;
use stairscan::answer::Direction;
use stairscan::config::{Config, Plane, Planes, RadarConfig};
use stairscan::motion::{Mode, Odometry};
use stairscan::pipeline::Pipeline;
use stairscan::report::{ScanLine, Sentence, StepLine};
use stairscan::scanner::command::framed;
use stairscan::scanner::{Hardware, LentParts, Micros, Reports, Scanner, Settings};
use stairscan::signal::radar::LinkError;
use stairscan::verdict::{Reason, Status};
use testbed::{Echoes, Module, Port};

/// Renders a scene 0.4 m below the mirror in one plane. The angles go from 20° above the horizontal, or behind
/// straight down, to 70°.
fn recording(plane: &str, ground: &str) -> Recording {
    let scene = Scene::parse(&format!(
        "[mount]\nheight_m = 0.40\nplane = \"{plane}\"\n[sweep]\nfirst_deg = -20.0\nlast_deg = 70.0\n{ground}"
    ));
    scene.unwrap().simulate(plane, 0)
}

/// Four steps down, 60 cm ahead.
const DOWN: &str = "[[floor]]\nmaterial = \"concrete\"\nto_m = 0.6\n[[stairs]]\ndirection = \"down\"\ndistance_m = 0.6\n\
                    count = 4\nrise_m = 0.16\ngoing_m = 0.30\nnosing_radius_m = 0.004\nlanding_m = 2.5\nmaterial = \"concrete\"\n";
/// Level ground up to a wall.
const LEVEL: &str =
    "[[floor]]\nmaterial = \"concrete\"\n[[wall]]\nat_m = 1.6\nmaterial = \"concrete\"\n";

/// Both recordings of a scene. Each answers the scans that begin at one of its own ends.
struct TwoPlanes<'a> {
    planes: [&'a Playback<'a>; 2],
    recordings: [&'a Recording; 2],
    /// Plane of the current scan; `None` before its first row.
    plane: Option<usize>,
    /// Planes of the scans so far.
    begun: Rc<RefCell<Vec<usize>>>,
}

impl Echoes for TwoPlanes<'_> {
    fn radar(&self) -> Option<RadarConfig> {
        Some(self.planes[0].radar())
    }

    fn programmed(&mut self) {
        self.plane = None;
    }

    fn triggered(&mut self, shaft_angle: i32) {
        // Within half a microstep.
        let begins = |end: i32| (shaft_angle - end).abs() < 10;
        let height = usize::from(begins(110_000) || begins(20_000));
        if self.plane.is_none() {
            assert!(
                height == 1 || begins(-20_000) || begins(70_000),
                "{shaft_angle}"
            );
            self.plane = Some(height);
            self.begun.borrow_mut().push(height);
        }
    }

    fn chirp(&mut self, shaft_angle: i32, samples: &mut [Iq]) -> Result<(), LinkError> {
        let plane = self.plane.unwrap();
        let chirp = self.planes[plane].chirp(0, shaft_angle).unwrap();
        samples.copy_from_slice(self.recordings[plane].chirp(chirp).unwrap());
        Ok(())
    }
}

/// An answer: its head and its steps.
type ScanLines = (ScanLine, Vec<StepLine>);

/// Motion of the chair.
#[derive(Clone, Copy, PartialEq)]
enum Chair {
    /// At standstill, by the setting.
    Standing,
    /// At standstill, by its controller's sentences.
    SaidToStand,
    /// Driving, by its controller's sentences.
    Driving,
}

/// Returns the answers to the first `scans` scans of `ground`.
fn answers(ground: &str, chair: Chair, scans: usize) -> Vec<ScanLines> {
    let (depth, height) = (recording("depth", ground), recording("height", ground));
    let planes = [&depth, &height].map(|r| Playback::new(r, &Config::default()).unwrap());
    let mut settings = planes[0].settings();
    settings.config.mount.plane = Planes::Both;
    settings.motion = match chair {
        Chair::Standing => Mode::Standing,
        _ => Mode::Auto,
    };
    settings.validate().unwrap();
    let begun = Rc::new(RefCell::new(Vec::new()));
    let link = TwoPlanes {
        planes: [&planes[0], &planes[1]],
        recordings: [&depth, &height],
        plane: None,
        begun: Rc::clone(&begun),
    };
    let printed = run(link, settings, chair, scans);
    let planes: Vec<usize> = (printed.iter())
        .map(|(head, _)| usize::from(head.plane == Some(Plane::Height)))
        .collect();
    assert_eq!(begun.borrow()[..scans], planes, "as told, and as turned");
    printed
}

/// Scans until `scans` answers have been reported.
fn run(link: TwoPlanes<'_>, settings: Settings, chair: Chair, scans: usize) -> Vec<ScanLines> {
    let (mut reports, mut odometry) = (Reports::new(), Odometry::new());
    let mut pipeline = Box::new(Pipeline::new());
    let hardware = Hardware {
        mirror: SimShaft::default(),
        link: Module::new(link),
        port: Port::default(),
        board: Volatile::SCANNING,
    };
    let mut scanner = Scanner::new(
        hardware,
        &mut *pipeline,
        LentParts {
            reports: &mut reports,
            odometry: &mut odometry,
        },
        Some(settings),
        identity("test"),
        Micros(0),
    );
    let mut sequence = 0u32;
    for step in 0..200_000u32 {
        let now = Micros(1_000 * step);
        if chair != Chair::Standing && step % 20 == 0 {
            let travel = if chair == Chair::Driving { sequence } else { 0 };
            let [number, way] = [sequence.to_string(), format!("{travel}.0")];
            let line = framed(&["MOTION", &number, &way, ""]);
            scanner.port_mut().type_in(&*line);
            sequence += 1;
        }
        scanner.step(now);
        if scanner.scans() as usize > scans {
            break;
        }
    }
    let said = String::from_utf8(std::mem::take(&mut scanner.port_mut().device)).unwrap();
    let mut printed: Vec<ScanLines> = Vec::new();
    for line in said.lines() {
        match Sentence::parse(line).unwrap() {
            Sentence::Scan(head) => printed.push((head, Vec::new())),
            Sentence::Step(step) => printed.last_mut().unwrap().1.push(step),
            _ => {}
        }
    }
    assert!(printed.len() >= scans, "{said}");
    printed.truncate(scans);
    printed
}

#[test]
fn before_a_flight_going_down_a_standing_chair_looks_down_it() {
    for chair in [Chair::Standing, Chair::SaidToStand] {
        let printed = answers(DOWN, chair, 4);
        let planes: Vec<_> = printed
            .iter()
            .map(|(head, _)| head.plane.unwrap())
            .collect();
        let (depth, height) = (Plane::Depth, Plane::Height);
        assert_eq!(planes, [depth, height, depth, height]);
        let numbers: Vec<u32> = printed.iter().map(|(head, _)| head.scan).collect();
        assert_eq!(numbers, [1, 2, 3, 4]);
        for (head, steps) in &printed {
            if head.plane == Some(depth) {
                assert_eq!((head.drops, head.steps), (1, 0));
                continue;
            }
            assert_eq!((head.direction, head.drops), (Direction::Down, 0));
            // Its distances are unreliable: docs/user/hardware.md.
            assert_eq!(head.status, Status::Degraded);
            assert!(head.reasons.has(Reason::Unconfirmed));
            let heights: Vec<i32> = steps.iter().map(|step| step.height.0).collect();
            assert_eq!(heights.len(), 4);
            for (printed, true_height) in heights.iter().zip([-1600, -3200, -4800, -6400]) {
                assert!((printed - true_height).abs() < 100, "{heights:?}");
            }
        }
    }
}

/// The depth plane's history continues over a scan of the other plane: a confirmed answer stays confirmed.
#[test]
fn a_scan_in_between_leaves_the_depth_plane_as_it_was() {
    let both = answers(DOWN, Chair::SaidToStand, 5);
    let answered = |k: usize| (both[k].0.status, both[k].0.horizon, both[k].0.reasons);
    assert_eq!(answered(2), answered(4));
}

#[test]
fn a_chair_that_drives_keeps_looking_ahead() {
    for (head, _) in answers(DOWN, Chair::Driving, 3) {
        assert_eq!((head.plane, head.drops), (Some(Plane::Depth), 1));
    }
}

#[test]
fn level_ground_asks_for_nothing() {
    for (head, _) in answers(LEVEL, Chair::Standing, 3) {
        assert_eq!((head.plane, head.drops), (Some(Plane::Depth), 0));
    }
}
