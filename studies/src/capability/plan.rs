//! Plan of the capability sheet's measurement: bodies, conditions, numbers of scenes and seeds.

use host_sim::seeds::Draw;

use super::body::Body;
use super::condition::{Condition, GROUNDS, REFERENCE_M, WET};

/// Short names of all test bodies without their sizes, as [`Body::kind`] returns them.
pub const KINDS: [&str; 7] = [
    "rise",
    "drop",
    "post",
    "closed-stairs",
    "open-stairs",
    "stairs-down",
    "level",
];
/// Heights of the rises that are measured, centimetres.
pub const RISES_CM: [u32; 8] = [2, 4, 6, 8, 10, 15, 20, 25];
/// Depths of the drops that are measured, centimetres.
pub const DROPS_CM: [u32; 7] = [4, 6, 8, 10, 15, 30, 50];
/// Measured distances of a body other than the reference distance, metres.
const DISTANCES_M: [f64; 6] = [0.4, 0.6, 0.8, 1.25, 1.5, 2.0];
/// Measured yaws of the chair other than the reference 0°, degrees. The simulator takes up to 15°, and each scene
/// deviates by up to 1°.
const YAWS_DEG: [f64; 3] = [5.0, 10.0, 14.0];
/// Measured pitches of the chair other than the reference 0°, degrees: up to a ramp of 1:14.
const PITCHES_DEG: [f64; 4] = [-4.0, -2.0, 2.0, 4.0];
/// Measured two-way losses of the window other than the reference of 0 dB, dB.
pub const LOSSES_DB: [f64; 3] = [3.0, 10.0, 20.0];
/// Speeds at which a chair drives towards a body, m/s.
const SPEEDS: [f64; 2] = [0.3, 0.8];
/// Bodies that a chair drives towards.
const DRIVEN: [Body; 3] = [Body::Rise(10), Body::Drop(15), Body::Post];

/// Number of scenes of a cell of level ground as a multiple of most cells'.
const LEVEL_TIMES: usize = 4;
/// Divisor that gives the number of drives of a cell with a driving chair from the number of scenes of most cells: a
/// drive takes as long to simulate as 40 scenes.
const DRIVE_SHARE: usize = 4;
/// Number of seeds reserved for each cell.
const CELL_SEEDS: u64 = 1000;
/// Maximum number of scenes of most cells: level ground has four times as many, and its seeds must suffice.
pub const MAX_SCENES: u64 = CELL_SEEDS / LEVEL_TIMES as u64;
/// Maximum number of scenes of one rise or drop at the reference condition.
pub const MAX_OF_A_SIZE: u64 = CELL_SEEDS;

/// The quantity that changes within a group of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Series {
    /// Height of a rise or depth of a drop, at the reference condition.
    Size,
    /// Height of a rise or depth of a drop, behind a window with loss.
    SizeAndWindow,
    /// Material of ground and body. The dry materials together are the reference condition.
    Ground,
    /// Distance of the body from the mirror.
    Distance,
    /// Yaw of the chair.
    Yaw,
    /// Pitch of the chair.
    Pitch,
    /// Two-way loss of the window.
    Window,
    /// Speed of a chair that drives towards the body.
    Speed,
}

impl Series {
    /// Returns the name of the series in JSON and tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Size => "size",
            Self::SizeAndWindow => "size and window",
            Self::Ground => "ground",
            Self::Distance => "distance",
            Self::Yaw => "yaw",
            Self::Pitch => "pitch",
            Self::Window => "window",
            Self::Speed => "speed",
        }
    }
}

/// One cell: a number of scenes of a body under a condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Index of the cell in the plan of all bodies, from 0, which selects its seeds.
    pub number: u64,
    /// Quantity that changes within the group of cells to which this one belongs.
    pub series: Series,
    /// Test body of the cell.
    pub body: Body,
    /// Condition under which the body is measured.
    pub condition: Condition,
    /// Number of scenes of the cell, or of drives.
    pub scenes: usize,
}

impl Cell {
    /// Returns the value of the quantity that changes in the cell's series, such as the distance, as text with the
    /// unit.
    pub fn value(&self) -> String {
        let c = &self.condition;
        match self.series {
            Series::Size | Series::SizeAndWindow => self.body.name(),
            Series::Ground => ground_name(c.ground).into(),
            Series::Distance => format!("{} m", c.distance_m),
            Series::Yaw => format!("{}°", c.yaw_deg),
            Series::Pitch if c.pitch_deg == 0.0 => "0°".into(),
            Series::Pitch => format!("{:+}°", c.pitch_deg),
            Series::Window => format!("{} dB", c.loss_db),
            Series::Speed => format!("{} m/s", c.speed),
        }
    }

    /// Returns the seeds of the cell's scenes on a draw: consecutive ones that no other cell uses.
    pub fn seeds(&self, draw: Draw) -> impl Iterator<Item = u64> {
        let first = draw.seeds().start + self.number * CELL_SEEDS;
        (0..self.scenes as u64).map(move |k| first + k)
    }
}

/// Returns the printed name of a ground's material; `None` gives that of all dry grounds together.
pub fn ground_name(ground: Option<&str>) -> &'static str {
    match ground {
        Some("painted-wood") => "wood",
        Some("dark-ceramic") => "ceramic",
        Some("concrete") => "concrete",
        Some("carpet") => "carpet",
        Some("grating") => "grating",
        Some(_) => "wet",
        None => "all dry",
    }
}

/// Returns all cells of the plan, with `scenes` scenes in most, and `of_a_size` for each rise and drop at the reference
/// condition.
pub fn cells(scenes: usize, of_a_size: usize) -> Vec<Cell> {
    let mut all = Vec::new();
    let mut add = |series, body, condition, scenes| {
        let number = all.len() as u64;
        all.push(Cell {
            number,
            series,
            body,
            condition,
            scenes,
        });
    };
    for body in Body::STANDARD {
        grounds().for_each(|c| add(Series::Ground, body, c, scenes));
        changed().for_each(|(series, c)| add(series, body, c, scenes));
    }
    for body in sizes() {
        add(Series::Size, body, Condition::REFERENCE, of_a_size);
        windows().for_each(|c| add(Series::SizeAndWindow, body, c, scenes));
    }
    let level = LEVEL_TIMES * scenes;
    grounds().for_each(|c| add(Series::Ground, Body::Level, c, level));
    windows().for_each(|c| add(Series::Window, Body::Level, c, level));
    for body in DRIVEN {
        for speed in SPEEDS {
            let condition = Condition {
                speed,
                ..Condition::REFERENCE
            };
            add(Series::Speed, body, condition, scenes / DRIVE_SHARE);
        }
    }
    all
}

/// Returns a rise of every height, then a drop of every depth.
pub fn sizes() -> impl Iterator<Item = Body> {
    let drops = DROPS_CM.into_iter().map(Body::Drop);
    RISES_CM.into_iter().map(Body::Rise).chain(drops)
}

fn grounds() -> impl Iterator<Item = Condition> {
    GROUNDS.into_iter().chain([WET]).map(|ground| Condition {
        ground: Some(ground),
        ..Condition::REFERENCE
    })
}

fn windows() -> impl Iterator<Item = Condition> {
    LOSSES_DB.into_iter().map(|loss_db| Condition {
        loss_db,
        ..Condition::REFERENCE
    })
}

/// Returns the conditions that differ from the reference in distance, yaw, pitch or window loss alone, each with the
/// series to which it belongs.
fn changed() -> impl Iterator<Item = (Series, Condition)> {
    debug_assert!(!DISTANCES_M.contains(&REFERENCE_M));
    let plain = Condition::REFERENCE;
    let distances = DISTANCES_M.into_iter().map(move |distance_m| {
        (
            Series::Distance,
            Condition {
                distance_m,
                ..plain
            },
        )
    });
    let yaws = YAWS_DEG
        .into_iter()
        .map(move |yaw_deg| (Series::Yaw, Condition { yaw_deg, ..plain }));
    let pitches = PITCHES_DEG
        .into_iter()
        .map(move |pitch_deg| (Series::Pitch, Condition { pitch_deg, ..plain }));
    let windows = windows().map(|condition| (Series::Window, condition));
    distances.chain(yaws).chain(pitches).chain(windows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_seed_serves_two_cells_and_none_leaves_its_draw() {
        let all = cells(MAX_SCENES as usize, MAX_OF_A_SIZE as usize);
        for draw in Draw::ALL {
            let mut seen = std::collections::HashSet::new();
            for seed in all.iter().flat_map(|cell| cell.seeds(draw)) {
                assert!(draw.seeds().contains(&seed) && seen.insert(seed), "{draw}");
            }
        }
    }

    #[test]
    fn kinds_are_those_of_the_bodies() {
        let all = cells(4, 4);
        let known = |kind: &&str| all.iter().any(|cell| cell.body.kind() == *kind);
        assert!(KINDS.iter().all(known));
        assert!(all.iter().all(|cell| KINDS.contains(&cell.body.kind())));
    }
}
