//! One scan: configure, move, settle, trigger, receive, retry, row after row; or all rows in passing.
//!
//! `sweep-mode stop`: the mirror stands still for each trigger, and for as long as the chirp itself
//! takes after it. Then it goes on to the next row while the chirp's samples are on the wire and worked
//! off. Where they do not come, it goes back for the row.
//!
//! `sweep-mode continuous`: the mirror turns through the sector at constant speed ([`Cruise`]), each row is
//! triggered in passing so that its place comes in mid chirp (`passing`). A row whose chirp was lost, or
//! that could not be triggered in time, is lost and told: filled on the way back it would be another
//! moment's, and the chair may have moved.
//!
//! Whose chirp an answer is, says the link by the sequence number of its request: in neither mode a
//! row gets another row's.

mod holding;
mod passing;
mod rows;
mod turning;

use core::task::Poll;

use super::chain::DataPath;
use super::mirror::{Mirror, Motion};
use super::pace::Cruise;
use super::settings::{Settings, SweepMode};
use crate::config::Plane;
use crate::schedule::{MICROSTEPS_PER_TURN, Schedule, shaft_angle};
use crate::signal::radar::module::RadarModule;
use crate::time::Micros;
use crate::verdict::Reason;
use holding::Hold;
use rows::{LOST_STREAK, MARGIN_US, RowState, later};
use turning::ContinuousSweep;

pub use rows::{Rows, link_reason, mirror_reason};

/// Of so many rows of a guard sweep one may be lost, a tenth as of a scan's: more make it a fault.
const GUARD_ROWS_PER_LOST: u16 = 10;

/// The rows of one scan, as a polled state machine.
#[derive(Debug)]
pub struct Sweep {
    settings: Settings,
    schedule: Schedule,
    scan: u32,
    backward: bool,
    at: RowState,
    /// Rows done, in the order of the sweep.
    done: u16,
    attempt: u8,
    lost: u16,
    streak: u16,
    /// A row whose samples have come and are not worked off yet.
    pending: Option<u16>,
    /// A row that has just been triggered, and when.
    fired: Option<(u16, Micros)>,
    /// Requests that were not answered as they should be, since the last look.
    failed: u16,
    deadline: Micros,
    /// By when the mirror's present move has ended.
    move_deadline: Micros,
    /// Keeps the mirror still until the chirp is captured.
    hold: Hold,
    /// The mirror has gone on to the next row before this one's chirp has come.
    gone_on: bool,
    /// The mirror is not on its way to where it has to go, but will be sent there when it stands.
    astray: bool,
    /// Since when the shaft has been seen at rest where it was sent.
    rest: Option<Micros>,
    /// In `continuous`, how; none: the mirror stops at every row.
    turning: Option<ContinuousSweep>,
    /// One of many guard sweeps: the next one follows at once.
    guard: bool,
    /// An encoder has been asked where the shaft is before it turns.
    proven: bool,
}

/// Purpose of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Task {
    /// Number of the scan, or of the guard sweep.
    pub number: u32,
    /// The plane that it is made in.
    pub plane: Plane,
    /// Whether it is a guard sweep: over the angles of [`GuardConfig`](super::settings::GuardConfig).
    pub guard: bool,
    /// Whether the mirror may still run out behind a guard sweep.
    pub running: bool,
}

impl Sweep {
    /// Begins the sweep of `task`, from the last row to the first if `backward`.
    ///
    /// `settings` must be valid; they are copied, so that what a command changes meanwhile is for
    /// the next scan.
    pub fn start(
        now: Micros,
        settings: &Settings,
        task: Task,
        backward: bool,
        mirror: &mut impl Mirror,
        link: &mut impl RadarModule,
    ) -> Result<Self, Reason> {
        let angles = match task.guard {
            true => settings.guard.sweep(),
            false => settings.config.sweep,
        };
        let schedule = Schedule::in_plane(angles, task.plane);
        let schedule = schedule.map_err(|_| Reason::ModuleConfig)?;
        let mut sweep = Self {
            settings: *settings,
            schedule,
            scan: task.number,
            backward,
            at: RowState::Configure,
            done: 0,
            attempt: 0,
            lost: 0,
            streak: 0,
            pending: None,
            fired: None,
            failed: 0,
            deadline: now,
            move_deadline: now,
            hold: Hold::default(),
            gone_on: false,
            astray: false,
            rest: None,
            turning: None,
            guard: task.guard,
            proven: false,
        };
        sweep.settings.config.mount.plane = task.plane.into();
        if task.guard {
            sweep.settings.config.sweep = angles;
            let most = angles.angle_count / GUARD_ROWS_PER_LOST;
            sweep.settings.timing.max_lost = sweep.settings.timing.max_lost.min(most);
        }
        sweep.plan(link);
        sweep.approach(now, mirror, task.running);
        sweep.ask(now, link);
        Ok(sweep)
    }

    /// Sends the mirror to where the first row, or the ramp before it, begins: at once, or when it stands, since it may
    /// still run out behind a guard sweep.
    fn approach(&mut self, now: Micros, mirror: &mut impl Mirror, running: bool) {
        let target = self.target();
        // An error is told by the next look.
        if running && mirror.poll(now) == Ok(Motion::Moving) {
            self.astray = true;
            let bound = self
                .settings
                .motor
                .ramp()
                .bound_us(MICROSTEPS_PER_TURN as u32);
            self.move_deadline = now.plus(bound).plus(MARGIN_US);
        } else {
            self.start_move(now, mirror, target);
        }
    }

    /// How the mirror is to turn, with what is known of module and link.
    fn plan(&mut self, link: &impl RadarModule) {
        let cruise = match self.settings.sweep_mode {
            SweepMode::Stop => None,
            SweepMode::Continuous => {
                let times = link.row_times(self.settings.config.radar.samples);
                times.and_then(|times| Cruise::new(&self.settings, &self.schedule, times))
            }
        };
        self.turning = cruise.map(ContinuousSweep::new);
    }

    /// The moment by which the row must have got further.
    pub fn deadline(&self) -> Micros {
        self.deadline
    }

    /// What the radar module said at the beginning of this scan.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The row that was triggered since the last call, and when.
    pub fn fired(&mut self) -> Option<(u16, Micros)> {
        self.fired.take()
    }

    /// How many requests the module did not answer as it should since the last call.
    pub fn failed(&mut self) -> u16 {
        core::mem::take(&mut self.failed)
    }

    /// The row that comes after `place` others, in the order of the map.
    fn nth(&self, place: u16) -> u16 {
        if self.backward {
            let last = self.schedule.rows().saturating_sub(1);
            last.saturating_sub(place)
        } else {
            place
        }
    }

    /// Row that is due, in the order of the map.
    fn row(&self) -> u16 {
        self.nth(self.done)
    }

    /// Where the mirror has to be for what is due.
    fn target(&self) -> i32 {
        match &self.turning {
            Some(turning) => turning.start(&self.schedule, self.backward),
            None => self.schedule.position(self.row()),
        }
    }

    fn ask(&mut self, now: Micros, link: &mut impl RadarModule) {
        let timeout = self.settings.timing.configure_timeout;
        link.program(now, &self.settings.module, timeout);
        self.at = RowState::Configure;
        self.deadline = now.plus(timeout).plus(MARGIN_US);
    }

    fn start_move(&mut self, now: Micros, mirror: &mut impl Mirror, target: i32) {
        let ramp = self.settings.motor.ramp();
        let bound = ramp.bound_us(mirror.position().abs_diff(target));
        mirror.start_move(target, &self.settings.motor);
        self.rest = None;
        self.move_deadline = now.plus(bound).plus(MARGIN_US);
        self.deadline = self.move_deadline;
    }

    fn trigger(&mut self, now: Micros, mirror: &impl Mirror, link: &mut impl RadarModule) {
        let timeout = self.settings.timing.chirp_timeout;
        let angle = shaft_angle(mirror.position());
        match self.attempt {
            0 => link.trigger(now, angle, timeout),
            _ => link.retry(now, angle, timeout),
        }
        self.hold = Hold::default();
        self.fired = Some((self.row(), now));
        self.at = RowState::Receive;
        self.deadline = now.plus(timeout).plus(MARGIN_US);
    }

    fn end(&self, fault: Option<Reason>) -> Poll<Rows> {
        Poll::Ready(Rows {
            lost: self.lost,
            fault,
        })
    }

    /// All rows are done. Where the sweep has ended on the side of the home switch and that is to be
    /// checked, or an encoder is to be read, the answer waits for it: a mirror that has slipped saw another
    /// scene than it says.
    #[inline(never)]
    fn finish(&mut self, now: Micros, mirror: &mut impl Mirror) -> Poll<Rows> {
        let motor = &self.settings.motor;
        let crosses = motor.home_check && self.backward && !self.guard;
        let mut bound = MARGIN_US;
        if crosses {
            bound = bound.saturating_add(motor.cross_bound_us());
            mirror.cross_home(motor);
        }
        // Its readings take less than the margin.
        if !mirror.prove() && !crosses {
            return self.end(None);
        }
        self.deadline = now.plus(bound);
        self.at = RowState::Prove;
        Poll::Pending
    }

    /// Gets as far as it can without waiting.
    // Out of line, like what it calls: what a sweep takes of the stack would lie beneath the estimator.
    #[inline(never)]
    pub fn poll(
        &mut self,
        now: Micros,
        mirror: &mut impl Mirror,
        link: &mut impl RadarModule,
        data: &mut impl DataPath,
    ) -> Poll<Rows> {
        let motion = match mirror.poll(now) {
            Ok(motion) => motion,
            Err(error) => return self.end(Some(mirror_reason(error))),
        };
        match self.at {
            RowState::Configure => return self.poll_configure(now, link, data),
            RowState::Work => return self.work(now, mirror, data),
            RowState::Prove if motion == Motion::Still => return self.end(None),
            RowState::Prove => {}
            RowState::Move if motion == Motion::Still => self.arrived(now, mirror),
            RowState::Move => {}
            RowState::Settle(until) => {
                if now.reached(until) {
                    self.trigger(now, mirror, link);
                }
            }
            RowState::Receive => {
                self.go_on(now, motion, mirror, link);
                return self.poll_receive(now, mirror, link, data);
            }
            RowState::Approach if motion == Motion::Still => self.set_off(now, mirror),
            RowState::Approach => {}
            RowState::Turn => return self.turn(now, motion, mirror, link, data),
        }
        Poll::Pending
    }

    /// The mirror stands, if not where it has to, then on its way there.
    fn arrived(&mut self, now: Micros, mirror: &mut impl Mirror) {
        if core::mem::take(&mut self.astray) {
            let target = self.target();
            return self.start_move(now, mirror, target);
        }
        // From the first look at it, not from the last pulse: the shaft rests at least so long.
        let since = *self.rest.get_or_insert(now);
        let settle = self.settings.timing.settle;
        self.at = RowState::Settle(since.plus(settle));
        self.deadline = now.plus(settle).plus(MARGIN_US);
    }

    /// Once the chirp is captured the mirror goes on, whether or not its samples have come.
    fn go_on(
        &mut self,
        now: Micros,
        motion: Motion,
        mirror: &mut impl Mirror,
        link: &impl RadarModule,
    ) {
        if self.gone_on {
            if motion == Motion::Still {
                self.rest.get_or_insert(now);
            }
            return;
        }
        let chirp_us = self.settings.timing.chirp_duration;
        let next = self.done.saturating_add(1);
        if self.hold.over(now, link, chirp_us) && next < self.schedule.rows() {
            let target = self.schedule.position(self.nth(next));
            let answer = self.deadline;
            self.start_move(now, mirror, target);
            self.deadline = later(answer, self.move_deadline);
            self.gone_on = true;
        }
    }

    // Out of line: what beginning a scan takes of the stack would lie beneath the estimator.
    #[inline(never)]
    fn poll_configure<D: DataPath>(
        &mut self,
        now: Micros,
        link: &mut impl RadarModule,
        data: &mut D,
    ) -> Poll<Rows> {
        let Poll::Ready(answer) = link.settings(now) else {
            return Poll::Pending;
        };
        self.failed += u16::from(answer.is_err());
        match answer {
            Ok(radar) => {
                self.settings.config.radar = radar;
                let config = &self.settings.config;
                let begin = |data: &mut D| match self.guard {
                    true => data.begin_guard(config, self.scan),
                    false => data.begin(config, self.scan),
                };
                if self.settings.validate().is_err() || begin(data).is_err() {
                    return self.end(Some(Reason::ModuleConfig));
                }
                self.attempt = 0;
                self.at = RowState::Move;
                // The module may have become another one since the mirror was sent off.
                let (before, last) = (self.target(), self.move_deadline);
                self.plan(link);
                self.astray |= self.target() != before;
                if self.turning.is_some() {
                    self.at = RowState::Approach;
                }
                self.deadline = later(now.plus(MARGIN_US), last);
            }
            Err(_) if self.attempt < self.settings.timing.retries => {
                self.attempt += 1;
                self.ask(now, link);
            }
            Err(error) => return self.end(Some(link_reason(error))),
        }
        Poll::Pending
    }

    fn poll_receive(
        &mut self,
        now: Micros,
        mirror: &mut impl Mirror,
        link: &mut impl RadarModule,
        data: &mut impl DataPath,
    ) -> Poll<Rows> {
        let Poll::Ready(answer) = link.poll(now, data.samples()) else {
            return Poll::Pending;
        };
        self.failed += u16::from(answer.is_err());
        match answer {
            Ok(()) => {
                self.pending = Some(self.row());
                self.streak = 0;
            }
            Err(_) if self.attempt < self.settings.timing.retries => {
                self.attempt += 1;
                self.again(now, mirror, link);
                return Poll::Pending;
            }
            Err(error) => {
                data.lost(self.row());
                self.lost = self.lost.saturating_add(1);
                self.streak += 1;
                if self.streak >= LOST_STREAK {
                    return self.end(Some(link_reason(error)));
                }
                if self.lost > self.settings.timing.max_lost {
                    return self.end(Some(Reason::TooManyLost));
                }
            }
        }
        self.done += 1;
        self.attempt = 0;
        if core::mem::take(&mut self.gone_on) {
            self.deadline = later(now.plus(MARGIN_US), self.move_deadline);
        } else if self.done < self.schedule.rows() {
            let target = self.target();
            self.start_move(now, mirror, target);
        }
        // Its own call of `poll`: the arithmetic takes time, and `now` is old after it.
        self.at = RowState::Work;
        Poll::Pending
    }

    /// Triggers the row once more, from where it is seen: where the mirror has gone on, it ends that move
    /// and comes back.
    fn again(&mut self, now: Micros, mirror: &impl Mirror, link: &mut impl RadarModule) {
        if core::mem::take(&mut self.gone_on) {
            self.astray = true;
            self.at = RowState::Move;
            self.deadline = later(now.plus(MARGIN_US), self.move_deadline);
        } else {
            self.trigger(now, mirror, link);
        }
    }

    /// Works off the last chirp while the mirror is on its way to the next.
    #[inline(never)]
    fn work(
        &mut self,
        now: Micros,
        mirror: &mut impl Mirror,
        data: &mut impl DataPath,
    ) -> Poll<Rows> {
        if let Some(row) = self.pending.take() {
            data.row(row);
        }
        if self.done >= self.schedule.rows() {
            return self.finish(now, mirror);
        }
        self.at = RowState::Move;
        Poll::Pending
    }
}

#[cfg(test)]
mod tests;
