//! All kinds of faults, with their strengths and the reasons that report them.

use anyhow::{Result, ensure};
use stairscan::verdict::Reason::{self, *};

use super::{converter, mounting, reference, rows, signal::Signal, world};
use host_sim::recording::Recording;
use host_sim::scene::maths::Random;

/// First stream of the random numbers of faults, separate from those of scenes and scans: the fault at index `k` of
/// [`ALL`] uses `STREAM + k`.
const STREAM: u64 = 0x4641_554C_5400;

/// One kind of fault.
pub struct Fault {
    /// Name of the fault in commands and tables.
    pub name: &'static str,
    /// Strengths to test, in `unit`.
    pub strengths: &'static [f64],
    /// Unit of the strengths as text; empty for a fault without strengths.
    pub unit: &'static str,
    /// Reasons that report the fault: any one of them is enough.
    pub reasons: &'static [Reason],
    /// Applies the fault to a scan, in place; the second argument is the strength, in `unit`.
    apply: fn(&mut Signal, f64),
}

impl Fault {
    /// Returns the fault of this name; `None` if there is none.
    pub fn named(name: &str) -> Option<&'static Fault> {
        ALL.iter().find(|fault| fault.name == name)
    }

    /// Returns `recording` with the fault of this strength applied. The random numbers of the fault are determined by
    /// `seed`.
    ///
    /// # Errors
    /// The fault cannot be applied to this recording; the message names it.
    pub fn on(&self, recording: &Recording, strength: f64, seed: u64) -> Result<Recording> {
        ensure!(
            recording.scans() == 1,
            "{}: {} scans: expected one, faults are applied to single scans",
            recording.name,
            recording.scans()
        );
        ensure!(
            !recording.meta.real,
            "{}: real samples: expected I and Q, to which faults are applied",
            recording.name
        );
        let place = ALL.iter().position(|f| core::ptr::eq(f, self));
        let random = Random::new(seed, STREAM + place.unwrap_or(ALL.len()) as u64);
        let mut signal = Signal::new(recording.clone(), random)?;
        (self.apply)(&mut signal, strength);
        Ok(signal.into_recording())
    }
}

const fn fault(
    name: &'static str,
    apply: fn(&mut Signal, f64),
    strengths: &'static [f64],
    unit: &'static str,
    reasons: &'static [Reason],
) -> Fault {
    Fault {
        name,
        strengths,
        unit,
        reasons,
        apply,
    }
}

const BITS: &[f64] = &[
    0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0,
];
const ROWS: &[f64] = &[10.0, 20.0, 40.0, 80.0, 120.0];
const NEAR: &[f64] = &[0.1, 0.2, 0.3, 0.4];
const ONCE: &[f64] = &[1.0];
const SHARES: &[f64] = &[0.05, 0.2, 0.5];

const CHANNELS: &[Reason] = &[AdcBit, ChannelDead, IqImbalance, IqSwapped];
const LEVELS: &[Reason] = &[GainDrift, MirrorMissing];
const ANGLES: &[Reason] = &[AngleJump, MirrorStuck, Mount];
const REFERENCE: &[Reason] = &[MirrorMissing, GainDrift, Moving, AngleJump];
const VIEW: &[Reason] = &[BlockedView, NoEcho];

/// All kinds of faults. The index of a fault selects its stream of random numbers.
#[rustfmt::skip] // One fault a line.
pub static ALL: &[Fault] = &[
    fault("bit-high", converter::bit_high, BITS, "bit", CHANNELS),
    fault("bit-low", converter::bit_low, BITS, "bit", CHANNELS),
    fault("sign-lost", converter::sign_lost, ONCE, "", CHANNELS),
    fault("iq-swapped", converter::swapped, ONCE, "", &[IqSwapped]),
    fault("conjugated", converter::conjugated, ONCE, "", &[IqSwapped]),
    fault("channel-dead", converter::dead, ONCE, "", &[ChannelDead]),
    fault("channels-equal", converter::equal, ONCE, "", &[ChannelDead]),
    fault("iq-gain", converter::gain_imbalance, &[1.0, 3.0, 6.0, 12.0], "dB", &[IqImbalance]),
    fault("iq-phase", converter::phase_imbalance, &[5.0, 10.0, 20.0, 40.0], "deg", &[IqImbalance]),
    fault("dc-drift", converter::offset_drift, &[0.05, 0.2, 0.5], "of full scale", &[DcDrift, Saturated]),
    fault("gain-falls", converter::gain_falls, &[6.0, 10.0, 20.0, 40.0], "dB", LEVELS),
    fault("window", world::window, &[10.0, 15.0, 25.0, 35.0], "dB", &[WeakEchoes, NoEcho]),
    fault("blocked", world::blocked, NEAR, "m", VIEW),
    fault("blocked-below", world::blocked_below, NEAR, "m", VIEW),
    fault("blocked-above", world::blocked_above, NEAR, "m", VIEW),
    fault("mirror-stuck", rows::stuck, &[20.0, 60.0, 120.0, 200.0], "rows before the end", &[MirrorStuck]),
    fault("mirror-sticks", rows::sticks, &[20.0], "rows", ANGLES),
    fault("mirror-slips", rows::slipped, &[0.25, 0.5, 1.0, 2.0, 4.0, 8.0], "deg", ANGLES),
    fault("microsteps", rows::microsteps, &[0.25, 0.5, 0.8, 1.25, 2.0, 4.0], "of a step", ANGLES),
    fault("angle-offset", mounting::angle_offset, &[1.0, 2.0, 3.0, 4.0], "deg", &[Mount]),
    fault("mount-height", mounting::height, &[0.03, 0.04, 0.06, 0.08], "m", &[Mount]),
    fault("mirror-offset", mounting::offset, &[0.01, 0.02, 0.03], "m", &[RangeScale, MirrorMissing]),
    fault("bandwidth", mounting::bandwidth, &[0.01, 0.02, 0.03, 0.05], "of it", &[RangeScale, MirrorMissing]),
    fault("rows-swapped", rows::swapped, ROWS, "rows", ANGLES),
    fault("rows-shuffled", rows::shuffled, ROWS, "rows", ANGLES),
    fault("rows-reversed", rows::reversed, ROWS, "rows", ANGLES),
    fault("rows-repeated", rows::repeated, ROWS, "rows", &[StaleChirp, MirrorFrozen]),
    fault("rows-empty", rows::empty, ROWS, "rows", &[GainDrift, MirrorMissing, Silent]),
    fault("stale-chirps", rows::stale, &[0.02, 0.1, 0.5], "of the rows", &[StaleChirp, MirrorFrozen]),
    fault("bursts", converter::bursts, &[0.05, 0.1, 0.25, 0.5], "of the rows", &[Interference, Saturated]),
    fault("tone", converter::tone, &[-10.0, 0.0, 10.0, 20.0], "dB", &[Interference]),
    fault("clipped", converter::clipped, &[0.9, 0.7, 0.5, 0.3], "of the swing", &[Clipped]),
    fault("person-crosses", world::person_crosses, &[0.5, 1.0, 1.5], "m", &[BlockedView, AngleJump]),
    fault("person-approaches", world::person_approaches, &[0.6, 1.0], "m", &[BlockedView, AngleJump]),
    fault("chair-creeps", world::chair_moves, &[0.01, 0.02, 0.04, 0.08], "m", &[Moving, Mount]),
    fault("chair-rocks", world::rocks, &[0.25, 0.5, 1.0], "deg", &[Moving, AngleJump, MirrorStuck, Mount]),
    fault("reference-lost", reference::lost, SHARES, "of the rows", REFERENCE),
    fault("reference-weak", reference::weak, &[10.0, 20.0, 30.0, 40.0], "dB", REFERENCE),
    fault("reference-jumps", reference::jumps, SHARES, "of the rows", REFERENCE),
    fault("reference-flips", reference::flips, SHARES, "of the rows", REFERENCE),
];
