//! The mirror as the sweep sees it, and homing over any step generator.

use core::task::Poll;

use super::driver::{MotorDriver, NoWire};
use super::ramp::Ramp;
use super::settings::{Driver, DriverConfig, MotorConfig};
use crate::schedule::{MICROSTEPS_PER_TURN, microsteps};
use crate::time::Micros;

/// Whether the shaft stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// It turns.
    Moving,
    /// It stands where it was sent.
    Still,
}

/// What a motor can get wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MirrorError {
    /// The driver reported a stall: the position is lost.
    Stall,
    /// The home switch did not answer within the bounds of the search.
    HomeNotFound,
    /// The driver does not answer, was reset, or reports an error.
    Driver,
    /// The home switch is not where homing has found it, or the encoder finds the shaft elsewhere.
    Slipped,
    /// The encoder does not answer, or finds no magnet.
    Encoder,
    /// A move was asked for before homing had given the position a meaning.
    NotHomed,
}

/// The mirror's shaft.
pub trait Mirror {
    /// Starts the search for the home switch.
    fn start_home(&mut self, motor: &MotorConfig);
    /// Starts a move to `position`, microsteps from the horizontal.
    fn start_move(&mut self, position: i32, motor: &MotorConfig);
    /// Begins to look at the driver: until it is known to be well [`Mirror::poll`] says [`Motion::Moving`],
    /// and moves that are started wait. Homing was made for one driver; where `motor` has another, home is unknown again.
    fn check(&mut self, _motor: &MotorConfig) {}
    /// Begins to look whether the home switch still stands where homing has found it: until then
    /// [`Mirror::poll`] says [`Motion::Moving`], and an error where it does not.
    fn cross_home(&mut self, _motor: &MotorConfig) {}
    /// Begins to look whether the shaft is where the pulses should have brought it, once it stands: until then
    /// [`Mirror::poll`] says [`Motion::Moving`], and an error where it is not. No, where nothing can tell.
    fn prove(&mut self) -> bool {
        false
    }
    /// What an encoder has read at home, 0.001° from 0 on.
    fn home_reading(&self) -> Option<i32> {
        None
    }
    /// Whether the shaft stands by now. An error also leaves the driver off.
    fn poll(&mut self, now: Micros) -> Result<Motion, MirrorError>;
    /// Where the shaft was at the last [`Mirror::poll`], microsteps from the horizontal.
    fn position(&self) -> i32;
    /// Whether the position means anything.
    fn homed(&self) -> bool;
    /// Switches the driver off; the position is lost.
    fn disable(&mut self);
}

/// What the step generator knows at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PulseState {
    /// Where the shaft is, microsteps.
    pub position: i32,
    /// Pulses are still to come.
    pub moving: bool,
    /// The home switch's edge has come since it was armed; it ended the move.
    pub home_edge: bool,
    /// The driver reported a stall; that ended the move and switched the driver off.
    pub stalled: bool,
}

/// A step generator with its two inputs: what the chip's timer and edge interrupts provide.
pub trait StepPort {
    /// Begins a move to `target`. With `until_home` the home switch's edge ends it at once.
    fn begin(&mut self, target: i32, ramp: Ramp, until_home: bool);
    /// State of move and inputs.
    fn state(&mut self) -> PulseState;
    /// Whether the home switch is pressed now.
    fn home_pressed(&mut self) -> bool;
    /// Declares the present place to be `position`.
    fn set_position(&mut self, position: i32);
    /// Switches the driver; on also forgets an old stall.
    fn set_enabled(&mut self, on: bool);
    /// Takes over how the driver is to be told.
    fn configure(&mut self, _driver: &DriverConfig) {}
}

/// The moves of homing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Homing {
    /// Leaving a switch that was pressed from the start.
    Leave { tries: u8 },
    /// Towards the switch, at search speed.
    Search,
    /// A little away from it again; moves that it takes until the switch lets go.
    BackOff { tries: u8 },
    /// Towards it, slowly: this edge counts.
    Approach,
    /// An edge has come and the shaft stands: does the level stay?
    Confirm(Confirm),
}

/// A look at the switch's level after an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Confirm {
    /// Whether the edge came on the slow approach.
    slow: bool,
    /// The first look.
    begun: Micros,
    /// The last look that found the switch released; the first look.
    since: Micros,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MirrorState {
    Unknown,
    /// The driver is told over its wire what to do; EN follows.
    SettingUp,
    /// EN is on, and the driver wakes until then; none before the first look.
    Waking(Option<Micros>),
    Homing(Homing),
    Homed,
    /// On the way to the home switch once more.
    Crossing(Crossing),
    Failed(MirrorError),
}

/// The moves of a look at the home switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Crossing {
    /// Slowly towards it, and not yet fast to a place before it.
    slow: bool,
    /// Looks that found it elsewhere.
    tries: u8,
}

/// What the search for home has found so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct HomeSearch {
    /// Where the search ends.
    end: i32,
    /// The last edge that was not refuted; none before the first.
    edge: Option<i32>,
    /// Slow approaches that ended at one place, one after the other.
    agreeing: u8,
    /// Edges that came to nothing.
    spurious: u8,
}

/// A stepper motor: moves and homing over a [`StepPort`], and a [`MotorDriver`] where the settings say so.
///
/// The home switch stands at the negative end of the shaft's way and is found twice, the second
/// time slowly, so that its place does not depend on where the shaft was at power-up. Every search
/// is bounded by the way that the shaft can have.
///
/// An edge alone is no switch: a spike on the wire makes one, too. So after each edge the level must
/// stay for 5 ms; the switch must let go on the way back; and the slow approach must end about where
/// the search ended. What is refuted is forgotten and the search goes on, a few times. A level is only
/// believed to be low once it has been seen high, since an input that has edges and no level could
/// never home otherwise; until then an edge counts when two slow approaches have ended at one place.
#[derive(Debug)]
pub struct Stepper<P, D = NoWire> {
    port: P,
    driver: D,
    state: MirrorState,
    /// As of the last look at the port.
    position: i32,
    motor: MotorConfig,
    found: HomeSearch,
    /// Whether the switch's level has ever been seen high.
    level_seen: bool,
    /// Whether the driver is being looked at: a move waits for that, since one that was reset makes other
    /// steps of its pulses.
    looking: bool,
    /// The move that waits.
    next: Option<(i32, Ramp)>,
}

/// Off the switch before the slow approach: 5°.
const BACK_OFF: i32 = MICROSTEPS_PER_TURN / 72;
/// Longest way to the switch: a whole turn is more than the shaft has.
const SEARCH: i32 = MICROSTEPS_PER_TURN;
/// Moves of [`BACK_OFF`] that must release a pressed switch.
const LEAVE_TRIES: u8 = 6;
/// The level must stay so long after an edge, µs: contacts bounce for a few ms, spikes last less.
const LEVEL_US: u32 = 5_000;
/// A level that has not stayed by then will not, µs.
const BOUNCE_US: u32 = 20_000;
/// The first slow approach ends so near where the fast search did: 2.5°, for a search does not stop dead.
const NEAR_SEARCH: i32 = BACK_OFF / 2;
/// A look at the switch begins so far before it, and ends as far behind it at last: 1°.
const CROSSING: i32 = BACK_OFF / 5;
/// Slow approaches to one switch end so near each other, microsteps: what motors and switches repeat to.
const REPEATS: u32 = 2;
/// Looks that may find the switch elsewhere: one spike on its wire is no slip.
const CROSSING_TRIES: u8 = 2;
/// Two slow approaches end so near each other: 1°.
const NEAR_APPROACH: i32 = BACK_OFF / 5;
/// Slow approaches to one place that prove a switch whose level was never seen.
const AGREEING: u8 = 2;
/// Edges that may come to nothing before the switch is given up: the ways of all of them, and the
/// search, are within the three turns that the self-test allows.
const MOST_SPURIOUS: u8 = 4;

impl<P: StepPort> Stepper<P> {
    /// A motor that has not been homed, with a driver that nothing but its pins lead to.
    pub fn new(port: P) -> Self {
        Self::with_driver(port, NoWire)
    }
}

impl<P: StepPort, D: MotorDriver> Stepper<P, D> {
    /// A motor that has not been homed.
    pub fn with_driver(port: P, driver: D) -> Self {
        Self {
            port,
            driver,
            state: MirrorState::Unknown,
            position: 0,
            motor: MotorConfig::default(),
            found: HomeSearch::default(),
            level_seen: false,
            looking: false,
            next: None,
        }
    }

    /// The step generator.
    pub fn port(&self) -> &P {
        &self.port
    }

    /// What the port knows now.
    fn look(&mut self) -> PulseState {
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
        let target = self.look().position.saturating_add(way);
        self.port.begin(target, ramp, until_home);
    }

    /// How the switch's edge is approached where its place counts.
    fn slow(&self) -> Ramp {
        Ramp {
            speed: self.motor.search_speed / 8,
            acceleration: 0,
        }
    }

    #[inline(never)]
    fn enter(&mut self, homing: Homing) {
        self.state = MirrorState::Homing(homing);
        // Speeds from which the motor can stop dead, since an edge ends the move at once.
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
            end: self.look().position.saturating_sub(SEARCH),
            ..HomeSearch::default()
        };
        self.enter(Homing::Search);
    }

    /// EN: from now on the driver wakes.
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

    /// Goes on with the look at the driver; the move that waits for it follows.
    fn look_on(&mut self, now: Micros) -> Result<Motion, MirrorError> {
        match self.driver.poll(now) {
            Poll::Pending => return Ok(Motion::Moving),
            Poll::Ready(Ok(())) => self.looking = false,
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

    /// The next move of a look at the switch once the present one has ended.
    #[inline(never)]
    fn cross_on(&mut self, at: Crossing, edge: bool) -> Result<Motion, MirrorError> {
        let off = self.position.abs_diff(microsteps(self.motor.home_angle));
        if at.slow && edge && off <= REPEATS {
            self.state = MirrorState::Homed;
            return Ok(Motion::Still);
        }
        // A switch that is pressed before it is reached is not where it was either.
        let elsewhere = at.slow || self.pressed();
        let tries = at.tries + u8::from(elsewhere);
        if tries >= CROSSING_TRIES {
            return self.fail(MirrorError::Slipped);
        }
        self.crossing(!elsewhere, tries);
        Ok(Motion::Moving)
    }

    /// The edge was none of the switch's: the search goes on where it was.
    #[inline(never)]
    fn refute(&mut self) -> Result<Motion, MirrorError> {
        self.found.spurious += 1;
        self.found.edge = None;
        self.found.agreeing = 0;
        if self.found.spurious > MOST_SPURIOUS {
            return self.fail(MirrorError::HomeNotFound);
        }
        self.enter(Homing::Search);
        Ok(Motion::Moving)
    }

    /// The next move once the present one's move has ended.
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
            // What ended the search does not stand where it ended.
            Homing::Approach => return self.refute(),
            Homing::Confirm(look) => return self.confirm(now, look),
        }
        Ok(Motion::Moving)
    }

    fn confirm(&mut self, now: Micros, look: Confirm) -> Result<Motion, MirrorError> {
        let pressed = self.pressed();
        let since = if pressed { look.since } else { now };
        if pressed && now.since(since) >= LEVEL_US {
            return self.proven(look.slow);
        }
        if now.since(look.begun) < BOUNCE_US {
            self.state = MirrorState::Homing(Homing::Confirm(Confirm { since, ..look }));
            return Ok(Motion::Moving);
        }
        if self.level_seen {
            self.refute()
        } else {
            self.proven(look.slow)
        }
    }

    /// Nothing speaks against the edge at which the shaft stands.
    fn proven(&mut self, slow: bool) -> Result<Motion, MirrorError> {
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
            // Another place than before: this one is to be proven now.
            self.found.agreeing = 0;
            self.found.spurious += 1;
            if self.found.spurious > MOST_SPURIOUS {
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
        (self.looking, self.next) = (false, None);
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
            self.driver.look();
            self.looking = true;
        }
    }

    fn cross_home(&mut self, motor: &MotorConfig) {
        if self.state == MirrorState::Homed {
            (self.motor.speed, self.motor.acceleration) = (motor.speed, motor.acceleration);
            self.crossing(false, 0);
        }
    }

    fn start_move(&mut self, position: i32, motor: &MotorConfig) {
        if self.state == MirrorState::Homed {
            let ramp = motor.ramp();
            if self.looking {
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
        let pulses = self.look();
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
            _ if self.looking => self.look_on(now),
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
        (self.looking, self.next) = (false, None);
    }
}

#[cfg(test)]
mod tests;
