//! One scan: configure, move, settle, trigger, receive, retry, row after row.

use core::task::Poll;

use super::chain::DataPath;
use super::link::{LinkError, RadarLink};
use super::mirror::{Mirror, MirrorError, Motion};
use super::ramp::Ramp;
use super::schedule::{Schedule, shaft_angle};
use super::settings::Settings;
use super::time::Micros;
use crate::answer::Reason;

/// So many rows in a row without a chirp are no noise on the line: the scan ends at once.
const LOST_STREAK: u16 = 8;

/// On top of every computed deadline: the main loop's own grain, a long command listing.
const MARGIN_US: u32 = 100_000;

/// What the row that is due is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RowState {
    /// The module is asked what it is set to; the mirror already moves.
    Configure,
    /// The chirp before is worked off; the mirror moves.
    Work,
    /// The mirror moves.
    Move,
    /// The mirror stands and comes to rest.
    Settle(Micros),
    /// The chirp is on its way.
    Receive,
}

/// How a scan's rows went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rows {
    /// Rows whose chirp did not come.
    pub lost: u16,
    /// What ended the scan before its last row.
    pub fault: Option<Reason>,
}

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
}

/// The reason that a link's error gives a scan.
pub fn link_reason(error: LinkError) -> Reason {
    match error {
        LinkError::Module(_) | LinkError::Answer => Reason::ModuleError,
        LinkError::Timeout | LinkError::Frame(_) | LinkError::Sequence => Reason::LinkSilent,
    }
}

/// The reason that a motor's error gives a scan.
pub fn mirror_reason(error: MirrorError) -> Reason {
    match error {
        MirrorError::Stall => Reason::MotorStall,
        MirrorError::HomeNotFound | MirrorError::NotHomed => Reason::HomeNotFound,
    }
}

impl Sweep {
    /// Begins scan number `scan`, from the last row to the first if `backward`.
    ///
    /// `settings` must be valid; they are copied, so that what a command changes meanwhile is for
    /// the next scan.
    pub fn start(
        now: Micros,
        settings: &Settings,
        scan: u32,
        backward: bool,
        mirror: &mut impl Mirror,
        link: &mut impl RadarLink,
    ) -> Result<Self, Reason> {
        let schedule = Schedule::new(&settings.config).map_err(|_| Reason::ModuleConfig)?;
        let mut sweep = Self {
            settings: *settings,
            schedule,
            scan,
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
        };
        sweep.start_move(now, mirror);
        sweep.ask(now, link);
        Ok(sweep)
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

    /// Row that is due, in the order of the map.
    fn row(&self) -> u16 {
        if self.backward {
            let last = self.schedule.rows().saturating_sub(1);
            last.saturating_sub(self.done)
        } else {
            self.done
        }
    }

    fn ask(&mut self, now: Micros, link: &mut impl RadarLink) {
        let timeout = self.settings.timing.configure_timeout;
        link.configure(now, timeout);
        self.at = RowState::Configure;
        self.deadline = now.plus(timeout).plus(MARGIN_US);
    }

    fn start_move(&mut self, now: Micros, mirror: &mut impl Mirror) {
        let target = self.schedule.position(self.row());
        let ramp = Ramp {
            speed: self.settings.motor.speed,
            acceleration: self.settings.motor.acceleration,
        };
        let bound = ramp.bound_us(mirror.position().abs_diff(target));
        mirror.start_move(target, &self.settings.motor);
        self.deadline = now.plus(bound).plus(MARGIN_US);
    }

    fn trigger(&mut self, now: Micros, mirror: &impl Mirror, link: &mut impl RadarLink) {
        let timeout = self.settings.timing.chirp_timeout;
        link.trigger(now, shaft_angle(mirror.position()), timeout);
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

    /// Gets as far as it can without waiting.
    pub fn poll(
        &mut self,
        now: Micros,
        mirror: &mut impl Mirror,
        link: &mut impl RadarLink,
        data: &mut impl DataPath,
    ) -> Poll<Rows> {
        let motion = match mirror.poll(now) {
            Ok(motion) => motion,
            Err(error) => return self.end(Some(mirror_reason(error))),
        };
        match self.at {
            RowState::Configure => return self.poll_configure(now, link, data),
            RowState::Work => return self.work(data),
            RowState::Move => {
                if motion == Motion::Still {
                    // From this moment, not from the last pulse: the shaft rests at least so long.
                    let settle = self.settings.timing.settle;
                    self.at = RowState::Settle(now.plus(settle));
                    self.deadline = now.plus(settle).plus(MARGIN_US);
                }
            }
            RowState::Settle(until) => {
                if now.reached(until) {
                    self.attempt = 0;
                    self.trigger(now, mirror, link);
                }
            }
            RowState::Receive => return self.poll_receive(now, mirror, link, data),
        }
        Poll::Pending
    }

    // Out of line: what beginning a scan takes of the stack would lie beneath the estimator.
    #[inline(never)]
    fn poll_configure(
        &mut self,
        now: Micros,
        link: &mut impl RadarLink,
        data: &mut impl DataPath,
    ) -> Poll<Rows> {
        let Poll::Ready(answer) = link.poll_settings(now) else {
            return Poll::Pending;
        };
        self.failed += u16::from(answer.is_err());
        match answer {
            Ok(radar) => {
                self.settings.config.radar = radar;
                let valid = self.settings.validate().is_ok();
                if !valid || data.begin(&self.settings.config, self.scan).is_err() {
                    return self.end(Some(Reason::ModuleConfig));
                }
                self.at = RowState::Move;
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
        link: &mut impl RadarLink,
        data: &mut impl DataPath,
    ) -> Poll<Rows> {
        let Poll::Ready(answer) = link.poll_chirp(now, data.samples()) else {
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
                self.trigger(now, mirror, link);
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
        if self.done < self.schedule.rows() {
            self.start_move(now, mirror);
        }
        // Its own call of `poll`: the arithmetic takes time, and `now` is old after it.
        self.at = RowState::Work;
        Poll::Pending
    }

    /// Works off the last chirp while the mirror is on its way to the next.
    #[inline(never)]
    fn work(&mut self, data: &mut impl DataPath) -> Poll<Rows> {
        if let Some(row) = self.pending.take() {
            data.row(row);
        }
        if self.done >= self.schedule.rows() {
            return self.end(None);
        }
        self.at = RowState::Move;
        Poll::Pending
    }
}
