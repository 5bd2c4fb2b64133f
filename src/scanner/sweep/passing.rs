//! Rows in passing: the mirror turns at constant speed, and the step counter determines when a row is due.

use core::task::Poll;

use super::Sweep;
use super::rows::{LOST_STREAK, MARGIN_US, RowState, Rows, later, link_reason};
use crate::scanner::chain::DataPath;
use crate::scanner::mirror::{Mirror, Motion};
use crate::scanner::settings::MotorConfig;
use crate::schedule::shaft_angle;
use crate::signal::radar::module::{LinkError, RadarModule};
use crate::time::Micros;
use crate::verdict::Reason;

/// Maximum delay of a trigger behind its row's position, microsteps: 0.02°, the jitter of a shaft at rest
/// (docs/generated/accuracy.md).
const LATE: i32 = 3;

impl Sweep {
    /// Begins the turn at constant speed once the mirror stands where its ramp begins.
    pub(super) fn begin_turn(&mut self, now: Micros, mirror: &mut impl Mirror) {
        if core::mem::take(&mut self.needs_second_move) {
            let target = self.target();
            return self.start_move(now, mirror, target);
        }
        // At the turning points of guard sweeps the shaft rests, so that an encoder can be read.
        if self.guard
            && !core::mem::replace(&mut self.encoder_checked, true)
            && mirror.check_position()
        {
            self.deadline = now.plus(MARGIN_US);
            return;
        }
        let Some(turning) = &self.turning else { return };
        let motor = MotorConfig {
            speed: turning.cruise.speed,
            ..self.settings.motor
        };
        let (start, end) = turning.cruise.ends(&self.schedule, self.backward);
        mirror.start_move(end, &motor);
        let bound = motor.ramp().bound_us(start.abs_diff(end));
        self.deadline = now.plus(bound).plus(MARGIN_US);
        self.at = RowState::Turn;
    }

    /// Triggers the row that is due, receives chirps, and processes the one received before.
    #[inline(never)]
    pub(super) fn turn(
        &mut self,
        now: Micros,
        motion: Motion,
        mirror: &mut impl Mirror,
        link: &mut impl RadarModule,
        data: &mut impl DataPath,
    ) -> Poll<Rows> {
        if let Some(reason) = self.fire(now, mirror.position(), link, data) {
            return self.end(Some(reason));
        }
        // In a separate call of `poll`: processing takes time, and `now` is stale after it.
        if let Some(row) = self.pending.take() {
            data.row(row);
            return Poll::Pending;
        }
        let flying = self
            .turning
            .as_ref()
            .is_some_and(|t| !t.in_flight.is_empty());
        if flying {
            return match link.poll(now, data.samples()) {
                Poll::Ready(answer) => self.take(now, answer, data),
                Poll::Pending => Poll::Pending,
            };
        }
        if self.guard && self.untriggered().is_none() {
            // The result does not wait for the shaft, which moves on to the start of the next sweep.
            return self.end(None);
        }
        if motion == Motion::Moving {
            return Poll::Pending;
        }
        // The shaft stands behind the sector: the remaining rows are lost.
        while self.untriggered().is_some() {
            if let Some(reason) = self.miss(data) {
                return self.end(Some(reason));
            }
        }
        self.finish(now, mirror)
    }

    /// Returns the next row to be triggered, as an index of the map; `None` after the last.
    fn untriggered(&self) -> Option<u16> {
        let turning = self.turning.as_ref()?;
        (turning.next < self.schedule.rows()).then(|| self.nth(turning.next))
    }

    /// Triggers the row that is due with the shaft at `position`, microsteps, and marks rows as lost for whose
    /// triggers it is too late; returns a reason if the scan must end.
    fn fire(
        &mut self,
        now: Micros,
        position: i32,
        link: &mut impl RadarModule,
        data: &mut impl DataPath,
    ) -> Option<Reason> {
        loop {
            let row = self.untriggered()?;
            let turning = self.turning.as_mut()?;
            let past = turning.distance_past(&self.schedule, self.backward, row, position);
            if past < 0 {
                return None;
            }
            if past <= LATE {
                // A trigger that is late by less than the tolerance leaves at once.
                let wait = if past == 0 {
                    turning.cruise.delay_us
                } else {
                    0
                };
                let due = *turning.due.get_or_insert(now.plus(wait));
                if now.reached(due) || past > 0 {
                    self.fire_row(now, row, link);
                }
                return None;
            }
            if let Some(reason) = self.miss(data) {
                return Some(reason);
            }
        }
    }

    /// Triggers `row` if the link accepts another request now.
    fn fire_row(&mut self, now: Micros, row: u16, link: &mut impl RadarModule) {
        let angle = shaft_angle(self.schedule.position(row));
        let Some(turning) = &mut self.turning else {
            return;
        };
        let timeout = turning.cruise.chirp_timeout_us;
        if turning.in_flight.is_full() || turning.skip_next {
            return;
        }
        if turning.in_flight.is_empty() {
            link.trigger(now, angle, timeout);
        } else if !link.trigger_ahead(now, angle, timeout) {
            return;
        }
        // `in_flight` is not full here.
        let _ = turning.in_flight.push_back((row, now.plus(timeout)));
        turning.next += 1;
        turning.due = None;
        self.triggered = Some((row, now));
        self.deadline = later(self.deadline, now.plus(timeout).plus(MARGIN_US));
    }

    /// Marks the next row as lost because it was not triggered in time; returns a reason if too many are lost.
    fn miss(&mut self, data: &mut impl DataPath) -> Option<Reason> {
        let row = self.untriggered()?;
        let turning = self.turning.as_mut()?;
        turning.next += 1;
        (turning.due, turning.skip_next) = (None, false);
        self.lose(row, data)
    }

    /// Marks `row` as lost; returns a reason if too many are lost.
    fn lose(&mut self, row: u16, data: &mut impl DataPath) -> Option<Reason> {
        data.lost(row);
        self.lost = self.lost.saturating_add(1);
        (self.lost > self.settings.timing.max_lost).then_some(Reason::TooManyLost)
    }

    /// Handles the answer to the oldest trigger under way: a chirp, or an error, by which its row is lost.
    fn take(
        &mut self,
        now: Micros,
        answer: Result<(), LinkError>,
        data: &mut impl DataPath,
    ) -> Poll<Rows> {
        self.failed += u16::from(answer.is_err());
        let Some(turning) = &mut self.turning else {
            return Poll::Pending;
        };
        let Some((row, until)) = turning.in_flight.pop_front() else {
            return Poll::Pending;
        };
        match answer {
            Ok(()) => {
                self.pending = Some(row);
                self.streak = 0;
            }
            Err(error) => {
                self.streak += 1;
                // The late answer has used wire time that the following chirps need.
                turning.skip_next |= now.reached(until);
                let reason = self.lose(row, data);
                if self.streak >= LOST_STREAK {
                    return self.end(Some(link_reason(error)));
                }
                if reason.is_some() {
                    return self.end(reason);
                }
            }
        }
        Poll::Pending
    }
}
