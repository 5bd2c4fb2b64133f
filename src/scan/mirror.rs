//! The mirror as the sweep sees it, and homing over any step generator.

use super::ramp::Ramp;
use super::schedule::{MICROSTEPS_PER_TURN, microsteps};
use super::settings::MotorConfig;

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
    /// A move was asked for before homing had given the position a meaning.
    NotHomed,
}

/// The mirror's shaft.
pub trait Mirror {
    /// Starts the search for the home switch.
    fn start_home(&mut self, motor: &MotorConfig);
    /// Starts a move to `position`, microsteps from the horizontal.
    fn start_move(&mut self, position: i32, motor: &MotorConfig);
    /// Whether the shaft stands by now. An error also leaves the driver off.
    fn poll(&mut self) -> Result<Motion, MirrorError>;
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
}

/// The moves of homing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Homing {
    /// Leaving a switch that was pressed from the start.
    Leave { tries: u8 },
    /// Towards the switch, at search speed.
    Search,
    /// A little away from it again.
    BackOff,
    /// Towards it, slowly: this edge counts.
    Approach,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Unknown,
    Homing(Homing),
    Homed,
    Failed(MirrorError),
}

/// A stepper motor: moves and homing over a [`StepPort`].
///
/// The home switch stands at the negative end of the shaft's way and is found twice, the second
/// time slowly, so that its place does not depend on where the shaft was at power-up. Every search
/// is bounded by the way that the shaft can have.
#[derive(Debug)]
pub struct Stepper<P> {
    port: P,
    state: State,
    /// As of the last look at the port.
    position: i32,
    motor: MotorConfig,
}

/// Off the switch before the slow approach: 5°.
const BACK_OFF: i32 = MICROSTEPS_PER_TURN / 72;
/// Longest way to the switch: a whole turn is more than the shaft has.
const SEARCH: i32 = MICROSTEPS_PER_TURN;
/// Moves of [`BACK_OFF`] that must release a pressed switch.
const LEAVE_TRIES: u8 = 6;

impl<P: StepPort> Stepper<P> {
    /// A motor that has not been homed.
    pub fn new(port: P) -> Self {
        Self {
            port,
            state: State::Unknown,
            position: 0,
            motor: MotorConfig::default(),
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

    fn begin_by(&mut self, way: i32, ramp: Ramp, until_home: bool) {
        let target = self.look().position.saturating_add(way);
        self.port.begin(target, ramp, until_home);
    }

    fn enter(&mut self, homing: Homing) {
        self.state = State::Homing(homing);
        // Speeds from which the motor can stop dead, since an edge ends the move at once.
        let fast = Ramp {
            speed: self.motor.search_speed,
            acceleration: 0,
        };
        let slow = Ramp {
            speed: self.motor.search_speed / 8,
            acceleration: 0,
        };
        match homing {
            Homing::Leave { .. } | Homing::BackOff => self.begin_by(BACK_OFF, fast, false),
            Homing::Search => self.begin_by(-SEARCH, fast, true),
            Homing::Approach => self.begin_by(-2 * BACK_OFF, slow, true),
        }
    }

    fn fail(&mut self, error: MirrorError) -> MirrorError {
        self.port.set_enabled(false);
        self.state = State::Failed(error);
        error
    }

    /// The next move once the present one's move has ended.
    fn advance(&mut self, homing: Homing, edge: bool) -> Result<Motion, MirrorError> {
        match (homing, edge) {
            (Homing::Leave { tries }, _) => {
                if !self.port.home_pressed() {
                    self.enter(Homing::Search);
                } else if tries < LEAVE_TRIES {
                    self.enter(Homing::Leave { tries: tries + 1 });
                } else {
                    return Err(self.fail(MirrorError::HomeNotFound));
                }
            }
            (Homing::Search, true) => self.enter(Homing::BackOff),
            (Homing::BackOff, _) => self.enter(Homing::Approach),
            (Homing::Approach, true) => {
                self.position = microsteps(self.motor.home_angle);
                self.port.set_position(self.position);
                self.state = State::Homed;
                return Ok(Motion::Still);
            }
            (Homing::Search | Homing::Approach, false) => {
                return Err(self.fail(MirrorError::HomeNotFound));
            }
        }
        Ok(Motion::Moving)
    }
}

impl<P: StepPort> Mirror for Stepper<P> {
    fn start_home(&mut self, motor: &MotorConfig) {
        self.motor = *motor;
        self.port.set_enabled(true);
        if self.port.home_pressed() {
            self.enter(Homing::Leave { tries: 0 });
        } else {
            self.enter(Homing::Search);
        }
    }

    fn start_move(&mut self, position: i32, motor: &MotorConfig) {
        if self.state == State::Homed {
            let ramp = Ramp {
                speed: motor.speed,
                acceleration: motor.acceleration,
            };
            self.port.begin(position, ramp, false);
        }
    }

    fn poll(&mut self) -> Result<Motion, MirrorError> {
        if let State::Failed(error) = self.state {
            return Err(error);
        }
        let pulses = self.look();
        if pulses.stalled {
            return Err(self.fail(MirrorError::Stall));
        }
        match self.state {
            State::Unknown => Err(MirrorError::NotHomed),
            _ if pulses.moving => Ok(Motion::Moving),
            State::Homing(homing) => self.advance(homing, pulses.home_edge),
            _ => Ok(Motion::Still),
        }
    }

    fn position(&self) -> i32 {
        self.position
    }

    fn homed(&self) -> bool {
        self.state == State::Homed
    }

    fn disable(&mut self) {
        self.port.set_enabled(false);
        self.state = State::Unknown;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// A shaft whose own coordinate starts anywhere; the switch is pressed at and below 0.
    struct Bench {
        place: i32,
        position: i32,
        target: i32,
        until_home: bool,
        edge: bool,
        enabled: bool,
        stall_at: Option<i32>,
        stalled: bool,
        switch_works: bool,
        moves: Vec<i32>,
    }

    impl Bench {
        fn at(place: i32) -> Self {
            Self {
                place,
                position: 0,
                target: 0,
                until_home: false,
                edge: false,
                enabled: false,
                stall_at: None,
                stalled: false,
                switch_works: true,
                moves: Vec::new(),
            }
        }

        fn pressed(&self) -> bool {
            self.switch_works && self.place <= 0
        }

        fn pulse(&mut self) {
            let before = self.pressed();
            let step = (self.target - self.position).signum();
            self.position += step;
            self.place += step;
            if self.until_home && !before && self.pressed() {
                self.edge = true;
                self.target = self.position;
            }
            if self.stall_at == Some(self.place) {
                self.stalled = true;
                self.enabled = false;
                self.target = self.position;
            }
        }
    }

    impl StepPort for Bench {
        fn begin(&mut self, target: i32, _: Ramp, until_home: bool) {
            assert!(self.enabled, "a move with the driver off");
            self.moves.push(target - self.position);
            (self.target, self.until_home, self.edge) = (target, until_home, false);
        }
        fn state(&mut self) -> PulseState {
            for _ in 0..7 {
                if self.position != self.target {
                    self.pulse();
                }
            }
            PulseState {
                position: self.position,
                moving: self.position != self.target,
                home_edge: self.edge,
                stalled: self.stalled,
            }
        }
        fn home_pressed(&mut self) -> bool {
            self.pressed()
        }
        fn set_position(&mut self, position: i32) {
            (self.position, self.target) = (position, position);
        }
        fn set_enabled(&mut self, on: bool) {
            self.enabled = on;
            if on {
                self.stalled = false;
            } else {
                self.target = self.position;
            }
        }
    }

    fn settle(stepper: &mut Stepper<Bench>) -> Result<(), MirrorError> {
        for _ in 0..100_000 {
            match stepper.poll() {
                Ok(Motion::Still) => return Ok(()),
                Ok(Motion::Moving) => {}
                Err(error) => return Err(error),
            }
        }
        panic!("never settled");
    }

    #[test]
    fn homing_finds_the_same_place_from_anywhere() {
        let motor = MotorConfig::default();
        for place in [-3000, -5, 0, 1, 300, 20_000, 48_000] {
            let mut stepper = Stepper::new(Bench::at(place));
            assert_eq!(stepper.poll(), Err(MirrorError::NotHomed));
            stepper.start_home(&motor);
            settle(&mut stepper).unwrap();
            assert!(stepper.homed());
            let home = microsteps(motor.home_angle);
            assert_eq!(stepper.position() - stepper.port().place, home, "{place}");
            stepper.start_move(1234, &motor);
            settle(&mut stepper).unwrap();
            assert_eq!(
                (stepper.position(), stepper.port().place),
                (1234, 1234 - home)
            );
        }
    }

    #[test]
    fn dead_switch_ends_the_search_with_the_driver_off() {
        let mut bench = Bench::at(100);
        bench.switch_works = false;
        let mut stepper = Stepper::new(bench);
        stepper.start_home(&MotorConfig::default());
        assert_eq!(settle(&mut stepper), Err(MirrorError::HomeNotFound));
        assert!(!stepper.port().enabled && !stepper.homed());
        assert_eq!(stepper.port().moves, [-SEARCH]);
    }

    #[test]
    fn jammed_switch_ends_the_search() {
        let mut stepper = Stepper::new(Bench::at(-1_000_000));
        stepper.start_home(&MotorConfig::default());
        assert_eq!(settle(&mut stepper), Err(MirrorError::HomeNotFound));
        assert!(!stepper.port().enabled);
    }

    #[test]
    fn stall_switches_off_and_needs_homing() {
        let motor = MotorConfig::default();
        let mut stepper = Stepper::new(Bench::at(100));
        stepper.start_home(&motor);
        settle(&mut stepper).unwrap();
        stepper.port.stall_at = Some(500);
        stepper.start_move(stepper.position() + 1000, &motor);
        assert_eq!(settle(&mut stepper), Err(MirrorError::Stall));
        assert!(!stepper.port().enabled && !stepper.homed());
        stepper.port.stall_at = None;
        stepper.start_home(&motor);
        settle(&mut stepper).unwrap();
        assert!(stepper.homed());
    }
}
