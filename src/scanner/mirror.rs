//! The mirror as the sweep sees it, and homing over any step generator.
//!
//! In: target positions and motor settings. Out: position, motion and errors of the shaft. Homing finds the
//! home switch twice and rejects spurious edges.

use core::task::Poll;

use super::driver::{MotorDriver, NoUart};
use super::ramp::Ramp;
use super::settings::{Driver, DriverConfig, MotorConfig};
use crate::schedule::{MICROSTEPS_PER_TURN, microsteps};
use crate::time::Micros;

/// Motion state of the shaft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// The shaft turns, or a check is under way.
    Moving,
    /// The shaft stands where it was sent.
    Still,
}

/// Error of the mirror's motor, its driver, or a sensor of its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MirrorError {
    /// The driver reported a stall: the position is lost.
    Stall,
    /// The home switch did not close or open within the search range.
    HomeNotFound,
    /// The driver does not answer, was reset, or reports an error.
    Driver,
    /// The home switch is not where homing found it, or the encoder reads another angle than expected.
    Slipped,
    /// The encoder does not answer, or reports no magnet.
    Encoder,
    /// A move was requested before homing.
    NotHomed,
}

/// The shaft of the mirror: homing, moves and checks of its position.
pub trait Mirror {
    /// Starts the search for the home switch.
    fn start_home(&mut self, motor: &MotorConfig);
    /// Starts a move to `position`, microsteps from the horizontal.
    fn start_move(&mut self, position: i32, motor: &MotorConfig);
    /// Starts a check of the driver. Until the driver has passed it, [`Mirror::poll`] returns
    /// [`Motion::Moving`], and new moves wait. Homing holds for one driver configuration: if `motor` has
    /// another, the home position is lost.
    fn check(&mut self, _motor: &MotorConfig) {}
    /// Starts a check that the home switch is still where homing found it. Until the check ends [`Mirror::poll`]
    /// returns [`Motion::Moving`]; it returns an error if the switch is elsewhere.
    fn check_home(&mut self, _motor: &MotorConfig) {}
    /// Starts a check, once the shaft stands, that it is where the pulses should have brought it. Until the check
    /// ends [`Mirror::poll`] returns [`Motion::Moving`], or an error if the shaft is elsewhere. Returns whether a
    /// check was started: `false` without a sensor of the shaft's angle.
    fn check_position(&mut self) -> bool {
        false
    }
    /// Returns the encoder's reading at home, 0.001°, at least 0; `None` without an encoder, or before homing.
    fn home_reading(&self) -> Option<i32> {
        None
    }
    /// Continues homing, move or check; returns whether the shaft stands. An error also switches the driver off.
    fn poll(&mut self, now: Micros) -> Result<Motion, MirrorError>;
    /// Returns the position of the shaft at the last [`Mirror::poll`], microsteps from the horizontal.
    fn position(&self) -> i32;
    /// Whether homing has succeeded, so that the position is valid.
    fn homed(&self) -> bool;
    /// Switches the driver off; the position is lost.
    fn disable(&mut self);
}

/// State of the step generator and its two inputs, home switch and stall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PulseState {
    /// Position of the shaft by the pulse count, microsteps.
    pub position: i32,
    /// Whether pulses are still to come.
    pub moving: bool,
    /// Whether an edge of the home switch has ended the current move, which was to end by it.
    pub home_edge: bool,
    /// Whether the driver reported a stall; that ended the move and switched the driver off.
    pub stalled: bool,
}

/// A generator of step pulses with two inputs, home switch and stall: on the chip a timer and edge interrupts.
pub trait StepPort {
    /// Begins a move to `target`, microsteps. With `until_home` an edge of the home switch ends it at once.
    fn begin(&mut self, target: i32, ramp: Ramp, until_home: bool);
    /// Returns the state of move and inputs.
    fn state(&mut self) -> PulseState;
    /// Whether the home switch is pressed now.
    fn home_pressed(&mut self) -> bool;
    /// Counts the current position of the shaft as `position`, microsteps, from now on.
    fn set_position(&mut self, position: i32);
    /// Switches the driver on or off; on also clears a previous stall.
    fn set_enabled(&mut self, on: bool);
    /// Takes over the driver's microsteps, pulse width and signal levels.
    fn configure(&mut self, _driver: &DriverConfig) {}
}

/// Phase of homing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Homing {
    /// Moves off a switch that was pressed from the start. `tries` counts the earlier moves after which it still
    /// was.
    Leave { tries: u8 },
    /// Moves towards the switch, at search speed.
    Search,
    /// Moves off the switch. `tries` counts the earlier moves after which it was still pressed.
    BackOff { tries: u8 },
    /// Moves slowly towards the switch, whose edge then defines home.
    Approach,
    /// An edge of the switch has ended the move: waits for a stable level.
    Confirm(Confirm),
}

/// Check of the home switch's level after an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Confirm {
    /// Whether the edge came on the slow approach.
    slow: bool,
    /// Time at which the edge of the home switch was seen.
    begun: Micros,
    /// Time of the last reading that found the switch open; before any, the time at which the edge was seen.
    since: Micros,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MirrorState {
    Unknown,
    /// The driver is being configured over its UART; it is switched on by EN afterwards.
    SettingUp,
    /// EN is on. Time at which the driver is awake; `None` before the first poll.
    Waking(Option<Micros>),
    Homing(Homing),
    Homed,
    /// A check of the home switch is under way.
    Crossing(Crossing),
    Failed(MirrorError),
}

/// State of a check that the home switch is where homing found it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Crossing {
    /// Whether the shaft approaches the switch slowly; otherwise it moves fast to a position 1° before the
    /// switch.
    slow: bool,
    /// Number of tries so far that found the switch elsewhere.
    tries: u8,
}

/// Intermediate results of homing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct HomeSearch {
    /// Position at which the search ends without a switch, microsteps.
    end: i32,
    /// Position of the last edge of the switch that was not rejected, microsteps; `None` before the first.
    edge: Option<i32>,
    /// Number of consecutive slow approaches that ended at the position of the edge before.
    agreeing: u8,
    /// Number of spurious edges of the home switch so far.
    spurious: u8,
}

/// A stepper motor: moves and homing over a [`StepPort`], and a [`MotorDriver`] where the settings select one.
///
/// The home switch is at the negative end of the shaft's range and is found twice, the second time slowly, so
/// that its position does not depend on where the shaft was at power-up. Every search is bounded by the shaft's
/// range.
///
/// An edge alone does not prove the switch: a spike on the wire causes one, too. So after each edge the level
/// must stay for 5 ms; the switch must open on the way back; and the slow approach must end close to where the
/// search ended. A rejected edge is discarded and the search continues, up to a limit. A low level rejects an
/// edge only once a high level has been seen, since an input with edges but no level could never home
/// otherwise. Until then an edge counts when two slow approaches have ended at one position.
#[derive(Debug)]
pub struct Stepper<P, D = NoUart> {
    port: P,
    driver: D,
    state: MirrorState,
    /// Position of the shaft at the last reading of the step generator, microsteps from the horizontal.
    position: i32,
    motor: MotorConfig,
    found: HomeSearch,
    /// Whether the input of the home switch has ever read as pressed.
    level_seen: bool,
    /// Whether a check of the driver is under way. A move waits for it, since a driver that was reset makes
    /// steps of another size from its pulses.
    driver_check: bool,
    /// Move that waits for the check of the driver: target, microsteps, and ramp.
    next: Option<(i32, Ramp)>,
}

/// Distance that the shaft backs off the switch before the slow approach, microsteps: 5°.
const BACK_OFF: i32 = MICROSTEPS_PER_TURN / 72;
/// Maximum travel of the search for the switch, microsteps: a whole turn is more than the shaft's range.
const SEARCH: i32 = MICROSTEPS_PER_TURN;
/// Maximum number of moves by [`BACK_OFF`], after the first one, until a pressed switch opens.
const LEAVE_TRIES: u8 = 6;
/// Time for which the switch must read as pressed after an edge, µs: contacts bounce for a few ms, spikes last
/// less.
const LEVEL_US: u32 = 5_000;
/// Timeout of the level check after an edge, µs: by then the switch must have read as pressed for [`LEVEL_US`].
const BOUNCE_US: u32 = 20_000;
/// Maximum distance between the switch positions by the fast search and by the first slow approach, microsteps:
/// 2.5°, since the shaft does not stop dead at the end of a search.
const NEAR_SEARCH: i32 = BACK_OFF / 2;
/// Distance before the expected switch position at which the slow approach of a check begins, and beyond it at
/// which the approach ends, microsteps: 1°.
const CROSSING: i32 = BACK_OFF / 5;
/// Maximum deviation of the switch position in a check, microsteps: repeatability of motors and switches.
const REPEATABILITY: u32 = 2;
/// Number of failed tries after which a check of the switch fails: one spike on its wire is no slip.
const CROSSING_TRIES: u8 = 2;
/// Maximum distance between the switch positions by two slow approaches, microsteps: 1°.
const NEAR_APPROACH: i32 = BACK_OFF / 5;
/// Number of slow approaches that must end at one position to prove a switch whose input has never read as
/// pressed.
const AGREEING: u8 = 2;
/// Maximum number of spurious edges in one homing. The moves after all of them, and the search, stay within the
/// three turns that the self-test allows.
const MAX_SPURIOUS: u8 = 4;

impl<P: StepPort> Stepper<P> {
    /// Creates a motor that has not been homed, with a driver that is connected by its pins only.
    pub fn new(port: P) -> Self {
        Self::with_driver(port, NoUart)
    }
}

impl<P: StepPort, D: MotorDriver> Stepper<P, D> {
    /// Creates a motor that has not been homed, with `driver` for the settings that select one with a UART.
    pub fn with_driver(port: P, driver: D) -> Self {
        Self {
            port,
            driver,
            state: MirrorState::Unknown,
            position: 0,
            motor: MotorConfig::default(),
            found: HomeSearch::default(),
            level_seen: false,
            driver_check: false,
            next: None,
        }
    }

    /// Returns the step generator.
    pub fn port(&self) -> &P {
        &self.port
    }

    /// Returns the state of the step generator, and stores its position.
    fn read_port(&mut self) -> PulseState {
        let pulses = self.port.state();
        self.position = pulses.position;
        pulses
    }

    fn pressed(&mut self) -> bool {
        let pressed = self.port.home_pressed();
        self.level_seen |= pressed;
        pressed
    }

    fn begin_by(&mut self, way: i32, ramp: Ramp, until_home: bool) {
        let target = self.read_port().position.saturating_add(way);
        self.port.begin(target, ramp, until_home);
    }

    /// Returns the ramp of the slow approach, whose edge defines home: an eighth of the search speed, without
    /// acceleration.
    fn slow(&self) -> Ramp {
        Ramp {
            speed: self.motor.search_speed / 8,
            acceleration: 0,
        }
    }

    #[inline(never)]
    fn enter(&mut self, homing: Homing) {
        self.state = MirrorState::Homing(homing);
        // Start-stop speeds, since an edge ends the move at once.
        let fast = Ramp {
            speed: self.motor.search_speed,
            acceleration: 0,
        };
        let slow = self.slow();
        match homing {
            Homing::Leave { .. } | Homing::BackOff { .. } => self.begin_by(BACK_OFF, fast, false),
            Homing::Search => self.port.begin(self.found.end, fast, true),
            Homing::Approach => self.begin_by(-2 * BACK_OFF, slow, true),
            Homing::Confirm(_) => {}
        }
    }

    #[inline(never)]
    fn fail(&mut self, error: MirrorError) -> Result<Motion, MirrorError> {
        self.disable();
        self.state = MirrorState::Failed(error);
        Err(error)
    }

    fn search(&mut self) {
        self.found = HomeSearch {
            end: self.read_port().position.saturating_sub(SEARCH),
            ..HomeSearch::default()
        };
        self.enter(Homing::Search);
    }

    /// Switches the driver on by EN; then it wakes.
    fn enable(&mut self) {
        self.port.set_enabled(true);
        self.state = MirrorState::Waking(None);
    }

    fn set_up(&mut self, now: Micros) -> Result<Motion, MirrorError> {
        match self.driver.poll(now) {
            Poll::Pending => {}
            Poll::Ready(Ok(())) => self.enable(),
            Poll::Ready(Err(_)) => return self.fail(MirrorError::Driver),
        }
        Ok(Motion::Moving)
    }

    fn wake(&mut self, now: Micros, until: Option<Micros>) {
        let DriverConfig {
            kind, enable_wake, ..
        } = self.motor.driver;
        let tuning = match kind {
            Driver::StepDir => 0,
            Driver::Tmc2209 => self.driver.tuning_us(),
        };
        let until = until.unwrap_or(now.plus(tuning.max(enable_wake.into())));
        if !now.reached(until) {
            self.state = MirrorState::Waking(Some(until));
        } else if self.pressed() {
            self.enter(Homing::Leave { tries: 0 });
        } else {
            self.search();
        }
    }

    /// Continues the check of the driver; when it has passed, begins the pending move, if there is one.
    fn look_on(&mut self, now: Micros) -> Result<Motion, MirrorError> {
        match self.driver.poll(now) {
            Poll::Pending => return Ok(Motion::Moving),
            Poll::Ready(Ok(())) => self.driver_check = false,
            Poll::Ready(Err(_)) => return self.fail(MirrorError::Driver),
        }
        let Some((target, ramp)) = self.next.take() else {
            return Ok(Motion::Still);
        };
        self.port.begin(target, ramp, false);
        Ok(Motion::Moving)
    }

    fn crossing(&mut self, slow: bool, tries: u8) {
        self.state = MirrorState::Crossing(Crossing { slow, tries });
        let home = microsteps(self.motor.home_angle);
        if slow {
            let slow = self.slow();
            self.port.begin(home - CROSSING, slow, true);
        } else {
            self.port.begin(home + CROSSING, self.motor.ramp(), false);
        }
    }

    /// Continues a check of the home switch after a move of it has ended, by an edge of the switch if `edge`:
    /// begins the next move, or ends the check.
    #[inline(never)]
    fn cross_on(&mut self, at: Crossing, edge: bool) -> Result<Motion, MirrorError> {
        let off = self.position.abs_diff(microsteps(self.motor.home_angle));
        if at.slow && edge && off <= REPEATABILITY {
            self.state = MirrorState::Homed;
            return Ok(Motion::Still);
        }
        // A switch that is pressed before it is reached has moved, too.
        let elsewhere = at.slow || self.pressed();
        let tries = at.tries + u8::from(elsewhere);
        if tries >= CROSSING_TRIES {
            return self.fail(MirrorError::Slipped);
        }
        self.crossing(!elsewhere, tries);
        Ok(Motion::Moving)
    }

    /// Rejects the last edge of the home switch as spurious: the search continues from the current position.
    #[inline(never)]
    fn refute(&mut self) -> Result<Motion, MirrorError> {
        self.found.spurious += 1;
        self.found.edge = None;
        self.found.agreeing = 0;
        if self.found.spurious > MAX_SPURIOUS {
            return self.fail(MirrorError::HomeNotFound);
        }
        self.enter(Homing::Search);
        Ok(Motion::Moving)
    }

    /// Begins the next move of homing after that of phase `homing` has ended, by an edge of the switch if `edge`.
    fn advance(&mut self, now: Micros, homing: Homing, edge: bool) -> Result<Motion, MirrorError> {
        match homing {
            Homing::Leave { tries } if self.pressed() => {
                if tries >= LEAVE_TRIES {
                    return self.fail(MirrorError::HomeNotFound);
                }
                self.enter(Homing::Leave { tries: tries + 1 });
            }
            Homing::Leave { .. } => self.search(),
            Homing::BackOff { tries } if self.pressed() => {
                if tries >= LEAVE_TRIES {
                    return self.fail(MirrorError::HomeNotFound);
                }
                self.enter(Homing::BackOff { tries: tries + 1 });
            }
            Homing::BackOff { .. } => self.enter(Homing::Approach),
            Homing::Search | Homing::Approach if edge => {
                self.enter(Homing::Confirm(Confirm {
                    slow: homing == Homing::Approach,
                    begun: now,
                    since: now,
                }));
            }
            Homing::Search => return self.fail(MirrorError::HomeNotFound),
            // The switch is not where the search ended.
            Homing::Approach => return self.refute(),
            Homing::Confirm(look) => return self.confirm(now, look),
        }
        Ok(Motion::Moving)
    }

    fn confirm(&mut self, now: Micros, look: Confirm) -> Result<Motion, MirrorError> {
        let pressed = self.pressed();
        let since = if pressed { look.since } else { now };
        if pressed && now.since(since) >= LEVEL_US {
            return self.accept_edge(look.slow);
        }
        if now.since(look.begun) < BOUNCE_US {
            self.state = MirrorState::Homing(Homing::Confirm(Confirm { since, ..look }));
            return Ok(Motion::Moving);
        }
        if self.level_seen {
            self.refute()
        } else {
            self.accept_edge(look.slow)
        }
    }

    /// Accepts the edge of the switch at the current position, on the slow approach if `slow`: as home if it
    /// confirms the edge before, otherwise as a position that the next slow approach must confirm.
    fn accept_edge(&mut self, slow: bool) -> Result<Motion, MirrorError> {
        let HomeSearch { edge, agreeing, .. } = self.found;
        let near = match agreeing {
            0 => NEAR_SEARCH,
            _ => NEAR_APPROACH,
        };
        let same = edge.is_some_and(|edge| edge.abs_diff(self.position) <= near as u32);
        self.found.edge = Some(self.position);
        if slow && same {
            self.found.agreeing += 1;
            if self.level_seen || self.found.agreeing >= AGREEING {
                self.position = microsteps(self.motor.home_angle);
                self.port.set_position(self.position);
                self.state = MirrorState::Homed;
                return Ok(Motion::Still);
            }
        } else if slow {
            // Another position than before: it is to be confirmed from now on.
            self.found.agreeing = 0;
            self.found.spurious += 1;
            if self.found.spurious > MAX_SPURIOUS {
                return self.fail(MirrorError::HomeNotFound);
            }
        }
        self.enter(Homing::BackOff { tries: 0 });
        Ok(Motion::Moving)
    }
}

impl<P: StepPort, D: MotorDriver> Mirror for Stepper<P, D> {
    #[inline(never)]
    fn start_home(&mut self, motor: &MotorConfig) {
        self.motor = *motor;
        (self.driver_check, self.next) = (false, None);
        self.port.configure(&motor.driver);
        match motor.driver.kind {
            Driver::StepDir => self.enable(),
            Driver::Tmc2209 => {
                self.driver.set_up(motor);
                self.state = MirrorState::SettingUp;
            }
        }
    }

    #[inline(never)]
    fn check(&mut self, motor: &MotorConfig) {
        if self.state != MirrorState::Homed {
            return;
        }
        if motor.driver != self.motor.driver {
            self.disable();
        } else if motor.driver.kind == Driver::Tmc2209 {
            self.driver.read_status();
            self.driver_check = true;
        }
    }

    fn check_home(&mut self, motor: &MotorConfig) {
        if self.state == MirrorState::Homed {
            (self.motor.speed, self.motor.acceleration) = (motor.speed, motor.acceleration);
            self.crossing(false, 0);
        }
    }

    fn start_move(&mut self, position: i32, motor: &MotorConfig) {
        if self.state == MirrorState::Homed {
            let ramp = motor.ramp();
            if self.driver_check {
                self.next = Some((position, ramp));
            } else {
                self.port.begin(position, ramp, false);
            }
        }
    }

    fn poll(&mut self, now: Micros) -> Result<Motion, MirrorError> {
        match self.state {
            MirrorState::Failed(error) => return Err(error),
            MirrorState::SettingUp => return self.set_up(now),
            _ => {}
        }
        let pulses = self.read_port();
        if pulses.stalled {
            return self.fail(MirrorError::Stall);
        }
        match self.state {
            MirrorState::Unknown => Err(MirrorError::NotHomed),
            MirrorState::Waking(until) => {
                self.wake(now, until);
                Ok(Motion::Moving)
            }
            _ if pulses.moving => Ok(Motion::Moving),
            _ if self.driver_check => self.look_on(now),
            MirrorState::Crossing(at) => self.cross_on(at, pulses.home_edge),
            MirrorState::Homing(homing) => self.advance(now, homing, pulses.home_edge),
            _ => Ok(Motion::Still),
        }
    }

    fn position(&self) -> i32 {
        self.position
    }

    fn homed(&self) -> bool {
        self.state == MirrorState::Homed
    }

    #[inline(never)]
    fn disable(&mut self) {
        self.port.set_enabled(false);
        self.state = MirrorState::Unknown;
        (self.driver_check, self.next) = (false, None);
    }
}

#[cfg(test)]
mod tests;
