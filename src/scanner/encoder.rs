//! An absolute encoder on the mirror's shaft: the angle is measured, not only counted.
//!
//! In: the mirror's position by pulses, the encoder's reading. Out: [`MirrorError::Slipped`] if they disagree.
//!
//! Lost steps, a slipping coupling and a displaced home switch leave the pulse count unchanged. An encoder
//! measures the shaft itself: [`EncodedMirror`] reads it after homing and after every sweep, before that
//! sweep's answer, and reports a slip if the reading does not match the count.
//!
//! Error budget: readings at one position repeat to a few hundredths of a degree. The difference between two
//! positions is accurate only to twice the encoder's linearity error. So a position is compared with the first
//! reading taken there after homing, within [`MAX_REPEAT_ERROR`]; only that first reading is compared with home, within
//! [`MAX_NONLINEARITY`]. Home itself is compared with `encoder-home`, the reading of a calibration.
//!
//! | module | content |
//! |---|---|
//! | [`as5600`] | an AS5600 over I²C |
//! | [`bus`] | I²C over two pins, with a timeout of every wait |

pub mod as5600;
pub mod bus;

use super::mirror::{Mirror, MirrorError, Motion};
use super::settings::{Encoder, MotorConfig};
use crate::schedule::MICROSTEPS_PER_TURN;
use crate::time::Micros;

/// Error of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EncoderError {
    /// The encoder does not answer.
    Silent,
    /// The encoder answers, and reports no magnet.
    NoMagnet,
}

/// A sensor of the shaft's absolute angle, valid from power-up.
pub trait AngleEncoder {
    /// Returns the angle of the shaft in 1/65536 turn, counted from an arbitrary zero; it grows with the position
    /// by pulses.
    ///
    /// # Errors
    /// Returns the cause if there is no angle. The call must end by itself: the caller has no timeout.
    fn angle(&mut self) -> Result<u16, EncoderError>;
}

impl<E: AngleEncoder + ?Sized> AngleEncoder for &mut E {
    fn angle(&mut self) -> Result<u16, EncoderError> {
        (**self).angle()
    }
}

/// Maximum difference of two readings at one position, 1/65536 turn: half a degree. An AS5600 has 0.09° a count
/// and noise of 0.015° rms (data sheet); homing repeats to two microsteps; the rest is for temperature, and for
/// a shaft that is held by a magnetic field.
pub const MAX_REPEAT_ERROR: u16 = 91;
/// Maximum difference of the first reading at a position from the reading that home lets expect there, 1/65536
/// turn: 2.25°. An AS5600 may be off by 1° at either of the two positions (data sheet, INL), plus
/// [`MAX_REPEAT_ERROR`].
pub const MAX_NONLINEARITY: u16 = 410;
/// Time for which the shaft has rested before a reading, µs: twice the default of `settle`; the AS5600's
/// slowest filter takes 2.2 ms (data sheet).
pub(super) const REST_US: u32 = 10_000;
/// Maximum number of readings in one check, each after the same rest; one that matches passes the check, so that
/// one disturbed byte on the bus is not taken for a slip.
const READINGS: u8 = 3;
/// Maximum distance of two positions that count as one, microsteps: a tenth of a degree.
const SAME_PLACE: u32 = (MICROSTEPS_PER_TURN / 3600) as u32;
/// Number of positions with a stored reading: home, and both ends of a sweep in each plane.
const PLACES: usize = 5;

/// A microstep in units of 1/65536 turn: 65,536 / 51,200 in lowest terms, numerator and denominator.
const MICROSTEP: (i32, i32) = (32, 25);
const _: () = assert!(MICROSTEPS_PER_TURN * MICROSTEP.0 == 65_536 * MICROSTEP.1);
/// 1/65536 turn in units of 0.001°: 360,000 / 65,536 in lowest terms, numerator and denominator.
const THOUSANDTHS: (i32, i32) = (5_625, 1_024);
const _: () = assert!(65_536 / THOUSANDTHS.1 * THOUSANDTHS.0 == 360_000);

/// Converts a reading of the encoder, 1/65536 turn, to an angle from 0 to a turn, 0.001°.
fn thousandths(reading: u16) -> i32 {
    i32::from(reading) * THOUSANDTHS.0 / THOUSANDTHS.1
}

/// Converts an angle from 0 to a turn, 0.001°, to a reading of the encoder, 1/65536 turn.
fn reading_of(angle: u32) -> u16 {
    (angle.saturating_mul(THOUSANDTHS.1 as u32) / THOUSANDTHS.0 as u32) as u16
}

/// Returns the distance of two readings, 1/65536 turn, the shorter way round.
fn distance(a: u16, b: u16) -> u16 {
    (a.wrapping_sub(b) as i16).unsigned_abs()
}

/// Reading of the encoder at one position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct ShaftReading {
    /// Position by the pulse count, microsteps from the horizontal.
    position: i32,
    /// Encoder's reading at this position, 1/65536 turn.
    reading: u16,
}

impl ShaftReading {
    /// Returns the reading, 1/65536 turn, expected at `position` (microsteps) if the shaft has turned from this
    /// reading's position as the pulses say.
    fn expected_reading(&self, position: i32) -> u16 {
        let way = position.wrapping_sub(self.position);
        let turned = way.wrapping_mul(MICROSTEP.0) / MICROSTEP.1;
        self.reading.wrapping_add(turned as u16)
    }
}

/// State of one check of the shaft's position by the encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct EncoderCheck {
    /// Time at which the shaft has rested long enough; `None` until it stands.
    until: Option<Micros>,
    /// Number of readings in this check that failed or did not match.
    failed: u8,
}

/// A mirror whose position by pulses is checked by an encoder on its shaft, if the setting `encoder` selects one.
#[derive(Debug)]
pub struct EncodedMirror<M, E> {
    mirror: M,
    encoder: E,
    /// Type of the encoder that the settings selected at the last homing.
    kind: Encoder,
    /// Encoder reading expected at home, 1/65536 turn: that of the calibration, or else of the first homing;
    /// `None` until it is known.
    home: Option<u16>,
    /// Accepted readings since the last homing, one for each position: first at home, then at the ends of sweeps.
    seen: heapless::Vec<ShaftReading, PLACES>,
    check: Option<EncoderCheck>,
}

impl<M: Mirror, E: AngleEncoder> EncodedMirror<M, E> {
    /// Creates a mirror with `encoder`, which is read only if the settings select one.
    pub fn new(mirror: M, encoder: E) -> Self {
        Self {
            mirror,
            encoder,
            kind: Encoder::None,
            home: None,
            seen: heapless::Vec::new(),
            check: None,
        }
    }

    /// Whether the reading `now` matches the one expected at its position; stores it if it is the first at this
    /// position.
    fn agrees(&mut self, now: ShaftReading) -> bool {
        let near = |seen: &&ShaftReading| seen.position.abs_diff(now.position) <= SAME_PLACE;
        let known = self.seen.iter().find(near);
        let (expected, within) = match (known, self.seen.first()) {
            (Some(seen), _) => (seen.expected_reading(now.position), MAX_REPEAT_ERROR),
            (None, Some(home)) => (home.expected_reading(now.position), MAX_NONLINEARITY),
            (None, None) => (*self.home.get_or_insert(now.reading), MAX_REPEAT_ERROR),
        };
        let agrees = distance(now.reading, expected) <= within;
        if agrees && known.is_none() {
            if self.seen.is_full() {
                // The ends of the sweeps have changed.
                self.seen.truncate(1);
            }
            // There is room now.
            let _ = self.seen.push(now);
        }
        agrees
    }

    /// Reads the encoder once while the shaft rests, and checks the reading against the pulse count.
    #[inline(never)]
    fn read(&mut self) -> Result<(), MirrorError> {
        let reading = self.encoder.angle().map_err(|_| MirrorError::Encoder)?;
        let position = self.mirror.position();
        match self.agrees(ShaftReading { position, reading }) {
            true => Ok(()),
            false => Err(MirrorError::Slipped),
        }
    }

    /// Continues `check` while the shaft stands: [`Motion::Moving`] until a reading matches or [`READINGS`] of
    /// them have failed.
    fn continue_check(&mut self, now: Micros, check: EncoderCheck) -> Result<Motion, MirrorError> {
        let until = check.until.unwrap_or(now.plus(REST_US));
        let next = |until, failed| EncoderCheck {
            until: Some(until),
            failed,
        };
        if !now.reached(until) {
            self.check = Some(next(until, check.failed));
            return Ok(Motion::Moving);
        }
        self.check = None;
        let Err(error) = self.read() else {
            return Ok(Motion::Still);
        };
        let failed = check.failed + 1;
        if failed >= READINGS {
            self.disable();
            return Err(error);
        }
        self.check = Some(next(now.plus(REST_US), failed));
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
        self.check = match self.kind {
            Encoder::None => None,
            Encoder::As5600 => Some(EncoderCheck::default()),
        };
        self.mirror.start_home(motor);
    }

    fn start_move(&mut self, position: i32, motor: &MotorConfig) {
        self.mirror.start_move(position, motor);
    }

    fn check(&mut self, motor: &MotorConfig) {
        // Another encoder has no reading at home yet.
        if motor.encoder.kind != self.kind {
            self.disable();
        }
        self.mirror.check(motor);
    }

    fn check_home(&mut self, motor: &MotorConfig) {
        self.mirror.check_home(motor);
    }

    fn check_position(&mut self) -> bool {
        if !self.seen.is_empty() {
            self.check = Some(EncoderCheck::default());
        }
        self.check.is_some()
    }

    fn poll(&mut self, now: Micros) -> Result<Motion, MirrorError> {
        match (self.mirror.poll(now)?, self.check) {
            (Motion::Still, Some(look)) => self.continue_check(now, look),
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
        self.check = None;
        self.seen.clear();
        self.mirror.disable();
    }
}

#[cfg(test)]
mod tests;
