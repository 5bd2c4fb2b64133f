//! An absolute encoder on the mirror's shaft: its angle is measured, not only counted.
//!
//! Steps that are lost, a coupling that slips and a home switch that is not where it was all leave the count
//! of the pulses as it is. An encoder sees the shaft itself: [`EncodedMirror`] has it read behind homing and
//! behind every sweep, before that sweep's answer, and calls the mirror slipped where it says something else
//! than the count.
//!
//! What an encoder may differ by. Its readings of one place repeat to a few hundredths of a degree, those of
//! two places are as far apart as they should be to twice its linearity error only. So a place is held against
//! the first reading behind homing that was taken there, within [`REPEATS`]; and only that first one against
//! home, within [`LINEARITY`]. Home itself is held against `encoder-home`, what a calibration has read there.
//!
//! | module | what it does |
//! |---|---|
//! | [`as5600`] | an AS5600 over I²C |
//! | [`bus`] | I²C over two pins, for which every wait has an end |

pub mod as5600;
pub mod bus;

use super::mirror::{Mirror, MirrorError, Motion};
use super::settings::{Encoder, MotorConfig};
use crate::schedule::MICROSTEPS_PER_TURN;
use crate::time::Micros;

/// What can be wrong with an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EncoderError {
    /// It does not answer.
    Silent,
    /// It answers, and finds no magnet.
    NoMagnet,
}

/// A sensor that says where the shaft is, from the moment when it has power.
pub trait AngleEncoder {
    /// Angle of the shaft in 1/65536 turn, from any zero; it grows where positions do.
    ///
    /// # Errors
    /// Says why there is none. It must come to that by itself: nobody waits for it with a clock.
    fn angle(&mut self) -> Result<u16, EncoderError>;
}

impl<E: AngleEncoder + ?Sized> AngleEncoder for &mut E {
    fn angle(&mut self) -> Result<u16, EncoderError> {
        (**self).angle()
    }
}

/// Readings of one place lie within this of each other, 1/65536 turn: half a degree. An AS5600 has 0.09° a
/// count and noise of 0.015° rms (data sheet); homing repeats to two microsteps; the rest is for a shaft
/// that is held by a magnetic field and temperature.
pub const REPEATS: u16 = 91;
/// A place's first reading lies within this of where home says, 1/65536 turn: 2.25°, for an AS5600 may be off
/// by 1° at either of the two places (data sheet, INL), and [`REPEATS`] aside from that.
pub const LINEARITY: u16 = 410;
/// The shaft has stood so long before it is read, µs: twice what `settle` allows it, and the AS5600's slowest
/// filter takes 2.2 ms (data sheet).
pub(super) const REST_US: u32 = 10_000;
/// Readings, each after as long a rest, of which one must be right: one disturbed byte is no slip.
const READINGS: u8 = 3;
/// Two places are one within this, microsteps: a tenth of a degree.
const SAME_PLACE: u32 = (MICROSTEPS_PER_TURN / 3600) as u32;
/// Home, and both ends of a sweep in each plane.
const PLACES: usize = 5;

/// 1/65536 turn of a microstep, as a ratio in lowest terms.
const MICROSTEP: (i32, i32) = (32, 25);
const _: () = assert!(MICROSTEPS_PER_TURN * MICROSTEP.0 == 65_536 * MICROSTEP.1);
/// 0.001° of 1/65536 turn, likewise.
const THOUSANDTHS: (i32, i32) = (5_625, 1_024);
const _: () = assert!(65_536 / THOUSANDTHS.1 * THOUSANDTHS.0 == 360_000);

/// A reading in 0.001°, from 0 on.
fn thousandths(reading: u16) -> i32 {
    i32::from(reading) * THOUSANDTHS.0 / THOUSANDTHS.1
}

/// The reading of 0.001°, up to a turn.
fn reading_of(angle: u32) -> u16 {
    (angle.saturating_mul(THOUSANDTHS.1 as u32) / THOUSANDTHS.0 as u32) as u16
}

/// How far two readings are apart, the shorter way round.
fn apart(a: u16, b: u16) -> u16 {
    (a.wrapping_sub(b) as i16).unsigned_abs()
}

/// What the encoder has read at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct ShaftReading {
    /// Microsteps from the horizontal, as the pulses have it.
    position: i32,
    /// 1/65536 turn.
    reading: u16,
}

impl ShaftReading {
    /// What is to be read at `position`.
    fn expects(&self, position: i32) -> u16 {
        let way = position.wrapping_sub(self.position);
        let turned = way.wrapping_mul(MICROSTEP.0) / MICROSTEP.1;
        self.reading.wrapping_add(turned as u16)
    }
}

/// A look at the encoder, under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Look {
    /// When the shaft has rested; none before it stands.
    until: Option<Micros>,
    /// Readings that failed, or were of another place.
    failed: u8,
}

/// A mirror whose shaft an encoder checks, where the setting `encoder` says so.
#[derive(Debug)]
pub struct EncodedMirror<M, E> {
    mirror: M,
    encoder: E,
    /// Which one there is, as of the last homing.
    kind: Encoder,
    /// What is to be read at home, once that is known.
    home: Option<u16>,
    /// What has been read since the last homing: there, then where sweeps have ended.
    seen: heapless::Vec<ShaftReading, PLACES>,
    look: Option<Look>,
}

impl<M: Mirror, E: AngleEncoder> EncodedMirror<M, E> {
    /// A mirror, and the encoder that may be on its shaft.
    pub fn new(mirror: M, encoder: E) -> Self {
        Self {
            mirror,
            encoder,
            kind: Encoder::None,
            home: None,
            seen: heapless::Vec::new(),
            look: None,
        }
    }

    /// Whether what is read now is what must be read there.
    fn agrees(&mut self, now: ShaftReading) -> bool {
        let near = |seen: &&ShaftReading| seen.position.abs_diff(now.position) <= SAME_PLACE;
        let known = self.seen.iter().find(near);
        let (expected, within) = match (known, self.seen.first()) {
            (Some(seen), _) => (seen.expects(now.position), REPEATS),
            (None, Some(home)) => (home.expects(now.position), LINEARITY),
            (None, None) => (*self.home.get_or_insert(now.reading), REPEATS),
        };
        let agrees = apart(now.reading, expected) <= within;
        if agrees && known.is_none() {
            if self.seen.is_full() {
                // Sweeps end elsewhere than they did.
                self.seen.truncate(1);
            }
            // There is room by now.
            let _ = self.seen.push(now);
        }
        agrees
    }

    /// Reads the encoder on a shaft that rests.
    #[inline(never)]
    fn read(&mut self) -> Result<(), MirrorError> {
        let reading = self.encoder.angle().map_err(|_| MirrorError::Encoder)?;
        let position = self.mirror.position();
        match self.agrees(ShaftReading { position, reading }) {
            true => Ok(()),
            false => Err(MirrorError::Slipped),
        }
    }

    /// Goes on with a look at the encoder while the shaft stands.
    fn look_on(&mut self, now: Micros, look: Look) -> Result<Motion, MirrorError> {
        let until = look.until.unwrap_or(now.plus(REST_US));
        let next = |until, failed| Look {
            until: Some(until),
            failed,
        };
        if !now.reached(until) {
            self.look = Some(next(until, look.failed));
            return Ok(Motion::Moving);
        }
        self.look = None;
        let Err(error) = self.read() else {
            return Ok(Motion::Still);
        };
        let failed = look.failed + 1;
        if failed >= READINGS {
            self.disable();
            return Err(error);
        }
        self.look = Some(next(now.plus(REST_US), failed));
        Ok(Motion::Moving)
    }
}

impl<M: Mirror, E: AngleEncoder> Mirror for EncodedMirror<M, E> {
    fn start_home(&mut self, motor: &MotorConfig) {
        self.kind = motor.encoder.kind;
        self.home = u32::try_from(motor.encoder.home)
            .ok()
            .map(reading_of)
            .or(self.home);
        self.seen.clear();
        self.look = match self.kind {
            Encoder::None => None,
            Encoder::As5600 => Some(Look::default()),
        };
        self.mirror.start_home(motor);
    }

    fn start_move(&mut self, position: i32, motor: &MotorConfig) {
        self.mirror.start_move(position, motor);
    }

    fn check(&mut self, motor: &MotorConfig) {
        // One that is new has not seen home.
        if motor.encoder.kind != self.kind {
            self.disable();
        }
        self.mirror.check(motor);
    }

    fn cross_home(&mut self, motor: &MotorConfig) {
        self.mirror.cross_home(motor);
    }

    fn prove(&mut self) -> bool {
        if !self.seen.is_empty() {
            self.look = Some(Look::default());
        }
        self.look.is_some()
    }

    fn poll(&mut self, now: Micros) -> Result<Motion, MirrorError> {
        match (self.mirror.poll(now)?, self.look) {
            (Motion::Still, Some(look)) => self.look_on(now, look),
            (motion, _) => Ok(motion),
        }
    }

    fn position(&self) -> i32 {
        self.mirror.position()
    }

    fn homed(&self) -> bool {
        self.mirror.homed()
    }

    fn home_reading(&self) -> Option<i32> {
        self.seen.first().map(|home| thousandths(home.reading))
    }

    fn disable(&mut self) {
        self.look = None;
        self.seen.clear();
        self.mirror.disable();
    }
}

#[cfg(test)]
mod tests;
