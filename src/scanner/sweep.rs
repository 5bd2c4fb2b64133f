//! One scan as a polled state machine: configure, move, settle, trigger, receive, retry, row after row; or all
//! rows in passing.
//!
//! In: settings, mirror and radar module. Out: the rows' samples, handed to the [`DataPath`], and [`Rows`] at
//! the end.
//!
//! `sweep-mode stop`: the mirror stands still for each trigger and for the duration of the chirp. Then it moves
//! to the next row while the chirp's samples are received and processed. If they do not arrive, it returns to
//! the row.
//!
//! `sweep-mode continuous`: the mirror turns through the sector at constant speed ([`Cruise`]). Each row is
//! triggered in passing so that its angle is reached in mid chirp (`passing`). A row whose chirp was lost, or
//! that could not be triggered in time, is reported as lost. It is not repeated on the way back, since the
//! chair may have moved by then.
//!
//! The link matches an answer to its request by the sequence number, so no row gets another row's chirp in
//! either mode.

mod holding;
mod passing;
mod rows;
mod turning;

use core::task::Poll;

use super::chain::DataPath;
use super::mirror::{Mirror, Motion};
use super::pace::{Cruise, RowWork};
use super::rest::Rest;
use super::settings::{Settings, SweepMode};
use crate::config::Plane;
use crate::schedule::{MICROSTEPS_PER_TURN, Schedule, shaft_angle};
use crate::signal::radar::module::RadarModule;
use crate::time::Micros;
use crate::verdict::Reason;
use holding::CaptureTimer;
use rows::{LOST_STREAK, MARGIN_US, RowState, later};
use turning::ContinuousSweep;

/// Time before the end of settling from which on the next poll is due at once, µs: two of the short rests.
const SETTLED_US: u32 = 100;

pub use rows::{Rows, link_reason, mirror_reason};

/// Number of rows of a guard sweep for each row that may be lost: a tenth, as for a scan. More make it a fault.
const GUARD_ROWS_PER_LOST: u16 = 10;

/// The rows of one scan, as a polled state machine.
#[derive(Debug)]
pub struct Sweep {
    settings: Settings,
    schedule: Schedule,
    scan: u32,
    backward: bool,
    at: RowState,
    /// Number of rows received or lost so far, in the order of the sweep.
    done: u16,
    attempt: u8,
    lost: u16,
    streak: u16,
    /// Row, as an index of the map, whose samples have been received and not processed yet.
    pending: Option<u16>,
    /// Row, as an index of the map, that was triggered last, and when; until [`Sweep::triggered`] takes it.
    triggered: Option<(u16, Micros)>,
    /// Number of requests to the radar module without a correct answer since the last call of [`Sweep::failed`].
    failed: u16,
    deadline: Micros,
    /// Deadline of the mirror's current move.
    move_deadline: Micros,
    /// Detects the end of the chirp's capture, until which the mirror must stand.
    capture_timer: CaptureTimer,
    /// Whether the mirror has moved on to the next row before this row's chirp has been received.
    moved_on: bool,
    /// Whether the mirror's current move has another target than the row needs; a second move follows when it
    /// stands.
    needs_second_move: bool,
    /// Time at which the shaft was first seen at rest at its target; `None` while it moves.
    rest: Option<Micros>,
    /// State of a continuous sweep; `None` if the mirror stops at every row.
    turning: Option<ContinuousSweep>,
    /// Whether it is a guard sweep, after which the next one follows at once.
    guard: bool,
    /// Whether the encoder check at the turning point before a guard sweep has been started.
    encoder_checked: bool,
}

/// Number, plane and kind of a sweep that is to begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Task {
    /// Number of the scan or guard sweep.
    pub number: u32,
    /// Plane in which the mirror sweeps.
    pub plane: Plane,
    /// Whether it is a guard sweep, over the angles of [`GuardConfig`](super::settings::GuardConfig), or else a
    /// scan.
    pub guard: bool,
    /// Whether the mirror may still be moving after a guard sweep.
    pub mirror_moving: bool,
}

impl Sweep {
    /// Begins the sweep of `task`, from the last row to the first if `backward`.
    ///
    /// `settings` must be valid. They are copied, so that commands during the sweep take effect in the next
    /// scan.
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
            triggered: None,
            failed: 0,
            deadline: now,
            move_deadline: now,
            capture_timer: CaptureTimer::default(),
            moved_on: false,
            needs_second_move: false,
            rest: None,
            turning: None,
            guard: task.guard,
            encoder_checked: false,
        };
        sweep.settings.config.mount.plane = task.plane.into();
        if task.guard {
            sweep.settings.config.sweep = angles;
            let most = angles.angle_count / GUARD_ROWS_PER_LOST;
            sweep.settings.timing.max_lost = sweep.settings.timing.max_lost.min(most);
        }
        sweep.plan(link);
        sweep.approach(now, mirror, task.mirror_moving);
        sweep.ask(now, link);
        Ok(sweep)
    }

    /// Sends the mirror to the first row, or to the start of the ramp before it: at once, or when it stands if
    /// it may still be moving after a guard sweep.
    fn approach(&mut self, now: Micros, mirror: &mut impl Mirror, mirror_moving: bool) {
        let target = self.target();
        // An error is reported by the next poll.
        if mirror_moving && mirror.poll(now) == Ok(Motion::Moving) {
            self.needs_second_move = true;
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

    /// Decides whether the mirror turns at constant speed, and how fast, by the settings and the timing of module
    /// and link.
    fn plan(&mut self, link: &impl RadarModule) {
        let cruise = match self.settings.sweep_mode {
            SweepMode::Stop => None,
            SweepMode::Continuous => {
                let times = link.row_times(self.settings.config.radar.samples);
                let work = match self.guard {
                    true => RowWork::Guard,
                    false => RowWork::Scan,
                };
                times.and_then(|times| Cruise::new(&self.settings, &self.schedule, times, work))
            }
        };
        self.turning = cruise.map(ContinuousSweep::new);
    }

    /// Returns the time by which the sweep must have left its current state.
    pub fn deadline(&self) -> Micros {
        self.deadline
    }

    /// Returns the settings of this sweep, with the radar module's data read at its beginning.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Returns the row that was triggered since the last call, as an index of the map, and when; `None` if there
    /// was none.
    pub fn triggered(&mut self) -> Option<(u16, Micros)> {
        self.triggered.take()
    }

    /// Returns the number of requests to the radar module without a correct answer since the last call.
    pub fn failed(&mut self) -> u16 {
        core::mem::take(&mut self.failed)
    }

    /// Returns the row with index `place` in the order of the sweep, as an index of the map.
    fn nth(&self, place: u16) -> u16 {
        if self.backward {
            let last = self.schedule.rows().saturating_sub(1);
            last.saturating_sub(place)
        } else {
            place
        }
    }

    /// Returns the row that is due, as an index of the map.
    fn row(&self) -> u16 {
        self.nth(self.done)
    }

    /// Returns the position to which the mirror must move next, microsteps from the horizontal.
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
        let timeout = self.settings.row_timeout_us();
        let angle = shaft_angle(mirror.position());
        match self.attempt {
            0 => link.trigger(now, angle, timeout),
            _ => link.retry(now, angle, timeout),
        }
        self.capture_timer = CaptureTimer::default();
        self.triggered = Some((self.row(), now));
        self.at = RowState::Receive;
        self.deadline = now.plus(timeout).plus(MARGIN_US);
    }

    fn end(&self, fault: Option<Reason>) -> Poll<Rows> {
        Poll::Ready(Rows {
            lost: self.lost,
            fault,
        })
    }

    /// Ends the sweep after all rows. If it was backward, towards the home switch in the depth plane, and the
    /// switch is to be checked, or an encoder is to be read, the answer waits for the check: after a slip the
    /// rows belong to other angles.
    #[inline(never)]
    fn finish(&mut self, now: Micros, mirror: &mut impl Mirror) -> Poll<Rows> {
        let motor = &self.settings.motor;
        let crosses = motor.home_check && self.backward && !self.guard;
        let mut bound = MARGIN_US;
        if crosses {
            bound = bound.saturating_add(motor.cross_bound_us());
            mirror.check_home(motor);
        }
        // Reading the encoder takes less than the margin.
        if !mirror.check_position() && !crosses {
            return self.end(None);
        }
        self.deadline = now.plus(bound);
        self.at = RowState::Prove;
        Poll::Pending
    }

    /// Returns how long the next poll may wait if no interrupt comes: of the shaft's steps, or of bytes that `link`
    /// waits for.
    pub fn may_rest(&self, now: Micros, link: &impl RadarModule) -> Rest {
        match self.at {
            RowState::Configure => Rest::Reply.only_if(link.waits()),
            RowState::Move | RowState::Approach | RowState::Prove => Rest::Short,
            // A trigger is not to be late.
            RowState::Settle(until) => Rest::Short.only_if(!now.plus(SETTLED_US).reached(until)),
            RowState::Receive => Rest::Reply.only_if(self.moved_on && link.waits()),
            RowState::Turn => {
                let Some(turning) = &self.turning else {
                    return Rest::None;
                };
                let due = self.pending.is_some() || turning.due.is_some();
                match turning.in_flight.is_empty() {
                    true => Rest::Short.only_if(!due),
                    false => Rest::Reply.only_if(!due && link.waits()),
                }
            }
            RowState::Work => Rest::None,
        }
    }

    /// Advances the sweep as far as possible without waiting; ready with its result at the end.
    // Out of line, like the functions it calls: its stack frame would otherwise stay beneath the estimator.
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
                self.move_on(now, motion, mirror, link);
                return self.poll_receive(now, mirror, link, data);
            }
            RowState::Approach if motion == Motion::Still => self.begin_turn(now, mirror),
            RowState::Approach => {}
            RowState::Turn => return self.turn(now, motion, mirror, link, data),
        }
        Poll::Pending
    }

    /// Handles a mirror that stands: begins the second move if the position is not the one that the row needs,
    /// else the settling time.
    fn arrived(&mut self, now: Micros, mirror: &mut impl Mirror) {
        if core::mem::take(&mut self.needs_second_move) {
            let target = self.target();
            return self.start_move(now, mirror, target);
        }
        // From the first poll that sees it, not from the last pulse: the shaft has rested at least that long.
        let since = *self.rest.get_or_insert(now);
        let settle = self.settings.timing.settle;
        self.at = RowState::Settle(since.plus(settle));
        self.deadline = now.plus(settle).plus(MARGIN_US);
    }

    /// Sends the mirror to the next row once the chirp is captured, whether or not its samples have been
    /// received.
    fn move_on(
        &mut self,
        now: Micros,
        motion: Motion,
        mirror: &mut impl Mirror,
        link: &impl RadarModule,
    ) {
        if self.moved_on {
            if motion == Motion::Still {
                self.rest.get_or_insert(now);
            }
            return;
        }
        let chirp_us = self.settings.capture_us();
        let next = self.done.saturating_add(1);
        if self.capture_timer.captured(now, link, chirp_us) && next < self.schedule.rows() {
            let target = self.schedule.position(self.nth(next));
            let answer = self.deadline;
            self.start_move(now, mirror, target);
            self.deadline = later(answer, self.move_deadline);
            self.moved_on = true;
        }
    }

    // Out of line: the stack frame of a scan's start would otherwise stay beneath the estimator.
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
                // Another module may have been connected since the mirror was sent off.
                let (before, last) = (self.target(), self.move_deadline);
                self.plan(link);
                self.needs_second_move |= self.target() != before;
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
        if core::mem::take(&mut self.moved_on) {
            self.deadline = later(now.plus(MARGIN_US), self.move_deadline);
        } else if self.done < self.schedule.rows() {
            let target = self.target();
            self.start_move(now, mirror, target);
        }
        // In a separate call of `poll`: processing takes time, and `now` is stale after it.
        self.at = RowState::Work;
        Poll::Pending
    }

    /// Triggers the current row once more. If the mirror has moved on, the trigger waits until it has returned.
    fn again(&mut self, now: Micros, mirror: &impl Mirror, link: &mut impl RadarModule) {
        if core::mem::take(&mut self.moved_on) {
            self.needs_second_move = true;
            self.at = RowState::Move;
            self.deadline = later(now.plus(MARGIN_US), self.move_deadline);
        } else {
            self.trigger(now, mirror, link);
        }
    }

    /// Processes the samples of the last chirp while the mirror moves to the next row.
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
