//! State of the guard between two sweeps: the trigger of `watch`, the last full scan's hazard, and whether the
//! settings allow a guard.
//!
//! `guarding` executes the commands on the state machine.

use crate::config::ConfigError;
use crate::drive::{Drive, Mode};
use crate::scanner::encoder::REST_US;
use crate::scanner::pace::{Cruise, RowWork};
use crate::scanner::settings::{Encoder, Settings, SweepMode};
use crate::schedule::Schedule;
use crate::setting::check;
use crate::signal::radar::wire::RowTimes;
use crate::time::Micros;
use crate::verdict::{GuardResult, HazardKind, Outcome, Status};

/// Operating mode of the guard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum GuardMode {
    /// No guard: the scanner scans or is idle.
    #[default]
    Off,
    /// Guard sweeps.
    Guard,
    /// Guard sweeps, with a full scan of each hazard that comes near.
    Watch,
}

/// Time for which a full scan's hazard limits guard sweeps, µs: 5 s. After that a chair has passed it, or an
/// odometer's error has grown to centimetres.
const SCAN_COUNTS_US: u32 = 5_000_000;
/// Speed below which a chair counts as standing, m/s: twice the speed that an odometer's resolution of a
/// millimetre a sweep shows at standstill.
const STANDING_M_S: f32 = 0.03;
/// Ratio of a chair's speed to its mean over some sweeps below which it counts as slowing.
const SLOWING: f32 = 0.8;
/// Weight of the newest sweep in the mean speed of the chair.
const NEWEST: f32 = 0.25;

/// State of the guard between two sweeps.
#[derive(Clone, Copy, Debug)]
pub(super) struct GuardState {
    pub mode: GuardMode,
    /// Whether a full scan, requested by `scan` or `watch`, comes next instead of a guard sweep.
    pub asked: bool,
    /// Whether a full scan has been requested for the hazard that is near now: each gets only one.
    pub hazard_scanned: bool,
    /// Whether the mirror may still be moving after the last sweep.
    pub mirror_moving: bool,
    /// Number of the last guard sweep since the guard was switched on; 0 before the first.
    pub sweep: u32,
    /// Number of the sweep that is under way or reported. It differs from `sweep` when the guard has been switched off
    /// and on within one sweep.
    pub reported_sweep: u32,
    /// Mean speed of the chair over the last sweeps, in which newer sweeps weigh more, m/s.
    speed_m_s: f32,
    /// Nearest hazard of the last full scan; `None` without one, or once it is older than 5 s.
    hazard: Option<Hazard>,
}

/// The nearest hazard that a full scan has reported.
#[derive(Clone, Copy, Debug)]
struct Hazard {
    /// Time at which the full scan ended.
    at: Micros,
    /// Shortest distance at which the hazard may be, by its uncertainty, metres from the mirror at the scan's
    /// last row.
    from_m: f32,
    kind: HazardKind,
}

impl GuardState {
    /// The guard switched off.
    pub const OFF: Self = Self {
        mode: GuardMode::Off,
        asked: false,
        hazard_scanned: false,
        mirror_moving: false,
        sweep: 0,
        reported_sweep: 0,
        speed_m_s: 0.0,
        hazard: None,
    };

    /// Whether the scanner guards.
    pub fn is_on(&self) -> bool {
        self.mode != GuardMode::Off
    }

    /// Keeps the hazard's age from wrapping with the clock; to be called every few minutes.
    pub fn keep_ages(&mut self, now: Micros) {
        if let Some(hazard) = &mut self.hazard {
            hazard.at = hazard.at.aged(now);
        }
    }

    /// Stores the nearest hazard of a full scan that ended at `now`.
    pub fn note(&mut self, now: Micros, outcome: &Outcome) {
        let first = outcome.answer.steps.first();
        let step = first.map(|step| {
            let ending = match step.height_m < 0.0 {
                true => HazardKind::Drop,
                false => HazardKind::Rise,
            };
            let margin_m = crate::estimate::expanded(step.distance_sigma_m);
            (step.distance_m - margin_m, ending)
        });
        let drop = outcome.answer.drop.as_ref();
        let drop = drop.map(|edge| (edge.nearest_m(), HazardKind::Drop));
        let nearest = [step, drop]
            .into_iter()
            .flatten()
            .filter(|&(m, _)| m > 0.0)
            .reduce(|a, b| if b.0 < a.0 { b } else { a });
        self.hazard =
            nearest
                .filter(|_| outcome.status() != Status::Fault)
                .map(|(from_m, kind)| Hazard {
                    at: now,
                    from_m,
                    kind,
                });
    }

    /// Limits the result of a sweep to the last full scan's hazard. `moved_m` is the travel since, metres; 0 if
    /// it is unknown: the hazard is then no farther than without travel.
    pub fn compare(&mut self, now: Micros, moved_m: f32, result: &mut GuardResult) {
        self.hazard = (self.hazard).filter(|hazard| now.since(hazard.at) < SCAN_COUNTS_US);
        if let Some(hazard) = self.hazard {
            result.limit(hazard.from_m - moved_m, hazard.kind);
        }
    }

    /// Whether the chair is known to stand or to slow down.
    fn slows(&mut self, drive: &Drive<'_>) -> bool {
        if drive.mode == Mode::Standing {
            return true;
        }
        let Some((moved_m, since_s)) = drive.moved_m.zip(drive.since_s) else {
            return false;
        };
        let speed = moved_m.abs() / crate::math::max(since_s, 1e-3);
        let slower = speed < STANDING_M_S || speed < SLOWING * self.speed_m_s;
        self.speed_m_s += NEWEST * (speed - self.speed_m_s);
        slower
    }

    /// Requests a full scan if `watch` is on, a rise or a drop has come nearer than `within_m`, and the chair
    /// stands or slows down: one scan of each hazard.
    pub fn watch(&mut self, result: &GuardResult, drive: &Drive<'_>, within_m: f32) {
        let slows = self.slows(drive);
        let ends = matches!(result.hazard(), HazardKind::Rise | HazardKind::Drop);
        let near = ends && result.free_m().is_some_and(|free_m| free_m < within_m);
        self.hazard_scanned &= near;
        if self.mode == GuardMode::Watch && near && slows && !self.hazard_scanned {
            (self.hazard_scanned, self.asked) = (true, true);
        }
    }
}

/// Checks whether the scanner can guard with these settings: whether the guard's angles cover the ground ahead,
/// and whether motor and link reach the minimum sweep rate `guard-rate`. `times` are those of a row; `None` if
/// the module cannot be triggered while the mirror turns.
#[inline(never)]
pub(super) fn fit(settings: &Settings, times: Option<RowTimes>) -> Result<(), ConfigError> {
    settings.guard.check(&settings.config)?;
    let rate = u32::from(settings.guard.rate);
    if rate == 0 {
        return Ok(());
    }
    check(
        settings.sweep_mode == SweepMode::Continuous,
        "sweep-mode",
        "continuous, or guard-rate 0",
    )?;
    let Some(times) = times else {
        return check(false, "module", "pstr or bgt60, or guard-rate 0");
    };
    let mut settings = *settings;
    let chirps = settings.module.chirps;
    settings.config.sweep = settings.guard.sweep();
    if period_us(&settings, times)?.saturating_mul(rate) <= SECOND_US {
        return Ok(());
    }
    settings.module.chirps = 1;
    check(
        chirps == 1 || period_us(&settings, times)?.saturating_mul(rate) > SECOND_US,
        "chirps-per-row",
        "fewer for guard-rate: the rows take too long",
    )?;
    settings.motor.acceleration = 0;
    check(
        period_us(&settings, times)?.saturating_mul(rate) > SECOND_US,
        "acceleration",
        "more for guard-rate: the ramps take too long",
    )?;
    let expected = "more for guard-rate: the rows take too long";
    let speed = settings.motor.speed;
    settings.motor.speed = u32::MAX;
    let faster = period_us(&settings, times)?.saturating_mul(rate) <= SECOND_US;
    check(!faster || speed == u32::MAX, "speed", expected)?;
    check(false, "link-rate", expected)
}

/// Microseconds in a second.
const SECOND_US: u32 = 1_000_000;

/// Returns the time from one guard sweep to the next, µs, with the check by the encoder; `settings.config.sweep`
/// must have the angles of the guard.
fn period_us(settings: &Settings, times: RowTimes) -> Result<u32, ConfigError> {
    let schedule = Schedule::in_plane(settings.config.sweep, crate::config::Plane::Depth)?;
    let cruise = Cruise::new(settings, &schedule, times, RowWork::Guard).ok_or(ConfigError {
        field: "guard-first",
        expected: "room for the ramps, and rows that come fast enough",
    })?;
    let looks = match settings.motor.encoder.kind {
        Encoder::None => 0,
        Encoder::As5600 => REST_US,
    };
    let sweep = cruise.sweep_us(&settings.motor, &schedule);
    Ok(sweep.saturating_add(looks))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::{Direction, Step};
    use crate::motion::Agreement;
    use crate::verdict::{Assessment, Evidence, FreeGround, GuardEvidence, Validity};

    /// Returns the free distance of a sweep that sees 2 m, `us` after a scan with a step at 1 m.
    fn free_after(us: u64) -> f32 {
        let mut outcome = Outcome::silent();
        outcome.answer.direction = Direction::Up;
        let step = Step {
            distance_m: 1.0,
            ..Step::default()
        };
        outcome.answer.steps.push(step).unwrap();
        let valid = Validity {
            horizon_m: 1.5,
            confidence: 0.99,
            first_step: 0.99,
        };
        let assessment = Assessment {
            echo_found: true,
            valid: Some(valid),
            ..Assessment::nothing(Agreement::STANDING)
        };
        outcome.decide(&Evidence {
            assessment: Some(assessment),
            ..Evidence::default()
        });
        let then = Micros(77);
        let mut guard = GuardState::OFF;
        guard.note(then, &outcome);
        for k in 1..=us / 300_000_000 {
            guard.keep_ages(then.plus((k * 300_000_000) as u32));
        }
        let ground = FreeGround {
            free_m: 2.0,
            hazard: HazardKind::None,
            confidence: 0.99,
        };
        let mut result = GuardResult::new(&GuardEvidence {
            echo_found: true,
            ground: Some(ground),
            ..GuardEvidence::default()
        });
        guard.compare(then.plus(us as u32), 0.0, &mut result);
        result.free_m().unwrap()
    }

    #[test]
    fn a_guard_that_several_chirps_slow_down_is_refused_for_them() {
        let wire = crate::signal::radar::wire::Wire {
            baud: 3_000_000,
            ahead: true,
            pin: false,
        };
        let mut settings = Settings::default();
        let fits = |settings: &Settings| {
            let times = wire.row_times(settings.config.radar.samples);
            fit(settings, Some(times)).map_err(|error| error.field)
        };
        assert_eq!(fits(&settings), Ok(()));
        settings.set("chirps-per-row", "2").unwrap();
        assert_eq!(fits(&settings), Ok(()));
        settings.set("chirps-per-row", "16").unwrap();
        assert_eq!(fits(&settings), Err("chirps-per-row"));
        settings.set("guard-rate", "0").unwrap();
        assert_eq!(fits(&settings), Ok(()));
    }

    #[test]
    fn a_scan_counts_for_five_seconds_and_not_again_when_the_counter_wraps() {
        assert!(free_after(4_000_000) < 1.0);
        assert_eq!(free_after(6_000_000), 2.0);
        assert_eq!(free_after((1 << 32) + 4_000_000), 2.0);
    }
}
