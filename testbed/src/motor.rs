//! Stepper motor with the mirror's shaft, home switch and stall output.
//!
//! In: moves. Out: position by pulses, place of the shaft, edges of the switch and stalls, one microstep after the other,
//! with faults on command: a switch that is dead, jammed, bounces, sticks or has spikes, stalls, mechanical ends.

use std::fmt;

use stairscan::scanner::mirror::{PulseState, StepPort};
use stairscan::scanner::ramp::Ramp;

use super::shared::Shared;

/// When the motor makes its pulses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// All pulses of a move at its beginning.
    AtOnce,
    /// A number of pulses each time that the scanner reads the state.
    PerRead(u32),
    /// Pulses by [`Motor::turn`] only.
    ByTurn,
}

/// Motor and shaft, whose home switch is pressed at and below place 0.
pub struct Motor {
    /// When the motor makes its pulses.
    pub pace: Pace,
    /// Place of the shaft, microsteps from the home switch.
    pub place: i32,
    /// Position by pulses, with any zero, microsteps.
    pub position: i32,
    /// Position at which the current move ends, microsteps.
    pub target: i32,
    /// Ramp of the last move.
    pub ramp: Ramp,
    /// Whether the driver is on.
    pub enabled: bool,
    /// Number of times that the driver was switched on.
    pub enables: u32,
    /// Whether the motor has stalled.
    pub stalled: bool,
    /// Place at which the motor stalls; `None`: it does not.
    pub stall_at: Option<i32>,
    /// First and last place that the shaft can reach; pulses beyond them are lost.
    pub ends: Option<(i32, i32)>,
    /// Whether the home switch works; else it is never pressed.
    pub switch_works: bool,
    /// Whether the switch's level can be read; its edges always work.
    pub level_works: bool,
    /// Whether the switch is pressed at every place.
    pub jammed: bool,
    /// Places at which the next passage causes one spurious edge of the home switch.
    pub spikes: Vec<i32>,
    /// Number of readings of a pressed switch that still find it open.
    pub bounces: u32,
    /// Largest place at which a switch that has been pressed still reads as pressed.
    pub sticks_below: i32,
    /// Distances of the moves so far, microsteps.
    pub moves: Vec<i32>,
    /// Called when a move begins, for a test's own checks.
    pub before_move: Option<Box<dyn FnMut()>>,
    until_home: bool,
    edge: bool,
    stuck: bool,
}

impl Motor {
    /// Returns a motor at rest with its driver off and its shaft at `place`, microsteps from the home switch.
    pub fn at(place: i32, pace: Pace) -> Self {
        Self {
            pace,
            place,
            position: 0,
            target: 0,
            ramp: Ramp {
                speed: 0,
                acceleration: 0,
            },
            enabled: false,
            enables: 0,
            stalled: false,
            stall_at: None,
            ends: None,
            switch_works: true,
            level_works: true,
            jammed: false,
            spikes: Vec::new(),
            bounces: 0,
            sticks_below: 0,
            moves: Vec::new(),
            before_move: None,
            until_home: false,
            edge: false,
            stuck: false,
        }
    }

    /// Whether a move is under way.
    pub fn moving(&self) -> bool {
        self.position != self.target && !self.stalled
    }

    /// Makes up to `pulses` pulses of the current move.
    pub fn turn(&mut self, pulses: u32) {
        for _ in 0..pulses {
            if !self.enabled || !self.moving() {
                break;
            }
            self.pulse();
        }
    }

    fn pressed(&self) -> bool {
        let below = match self.stuck {
            true => self.sticks_below,
            false => 0,
        };
        self.jammed || self.switch_works && self.place <= below
    }

    fn pulse(&mut self) {
        let before = self.pressed();
        let step = (self.target - self.position).signum();
        self.position += step;
        self.place += step;
        if let Some((first, last)) = self.ends {
            self.place = self.place.clamp(first, last);
        }
        let pressed = self.pressed();
        self.stuck = pressed;
        let spike = self.spikes.iter().position(|&place| place == self.place);
        if self.until_home && (!before && pressed || spike.is_some()) {
            spike.map(|k| self.spikes.remove(k));
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

impl fmt::Debug for Motor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Motor")
            .field("place", &self.place)
            .field("position", &self.position)
            .field("target", &self.target)
            .finish_non_exhaustive()
    }
}

impl StepPort for Motor {
    fn begin(&mut self, target: i32, ramp: Ramp, until_home: bool) {
        assert!(self.enabled, "a move with the driver off");
        if let Some(check) = &mut self.before_move {
            check();
        }
        self.moves.push(target - self.position);
        self.ramp = ramp;
        (self.target, self.until_home, self.edge) = (target, until_home, false);
        if self.pace == Pace::AtOnce {
            self.turn(u32::MAX);
        }
    }

    fn state(&mut self) -> PulseState {
        if let Pace::PerRead(pulses) = self.pace {
            self.turn(pulses);
        }
        PulseState {
            position: self.position,
            moving: self.moving(),
            home_edge: self.edge,
            stalled: self.stalled,
        }
    }

    fn home_pressed(&mut self) -> bool {
        let pressed = self.level_works && self.pressed();
        if pressed && self.bounces > 0 {
            self.bounces -= 1;
            return false;
        }
        pressed
    }

    fn set_position(&mut self, position: i32) {
        (self.position, self.target) = (position, position);
    }

    fn set_enabled(&mut self, on: bool) {
        self.enables += u32::from(on);
        self.enabled = on;
        self.stalled &= !on;
        // Without current the shaft stays where it is.
        self.target = self.position;
    }
}

impl<T: StepPort> StepPort for Shared<T> {
    fn begin(&mut self, target: i32, ramp: Ramp, until_home: bool) {
        self.get().begin(target, ramp, until_home);
    }

    fn state(&mut self) -> PulseState {
        self.get().state()
    }

    fn home_pressed(&mut self) -> bool {
        self.get().home_pressed()
    }

    fn set_position(&mut self, position: i32) {
        self.get().set_position(position);
    }

    fn set_enabled(&mut self, on: bool) {
        self.get().set_enabled(on);
    }
}
