//! Demo image: the scanner's own loop over a recording in flash, on a board without radar module and motor.
//!
//! In: the recording `stair_a`, in the sectors of slot B. Out: the settings, shaft and radar module that take the place
//! of the board's. The image is linked and sealed as the one that is flashed, and starts without the boot loader, so
//! that one file holds all that the chip needs (`demo.x`). It cannot be signed: `cargo sim keys sign` refuses it.

use core::arch::naked_asm;
use core::task::Poll;

use stairscan::Iq;
use stairscan::config::{Config, RadarConfig};
use stairscan::motion::Mode;
use stairscan::scanner::settings::{SweepMode, Switch};
use stairscan::scanner::{Micros, Settings};
use stairscan::signal::radar::frame;
use stairscan::signal::radar::module::{LinkError, RadarModule, RequestedSettings};

/// Seed of the particles with which `cargo sim replay` scans.
const SEED: u32 = 1;
/// Number of bytes of the recording: 281 chirps of 200 complex samples of 2 × 16 bits.
const BYTES: usize = 281 * 200 * 4;

// SAFETY: the section is the recording's alone, in flash behind the image's slot (`demo.x`).
#[unsafe(link_section = ".recording")]
static RECORDING: [u8; BYTES] = *include_bytes!("../../recordings/stair_a.sigmf-data");

/// Initial stack pointer and start of the program, which the processor reads after a reset.
#[repr(C)]
struct Start(*const u32, unsafe extern "C" fn());

// SAFETY: constants in flash.
unsafe impl Sync for Start {}

unsafe extern "C" {
    static _stack_start: u32;
    static __vector_table: u32;
    fn Reset() -> !;
}

// SAFETY: the section is this static's alone, at the beginning of the flash (`demo.x`).
#[used]
#[unsafe(link_section = ".alone")]
static START: Start = Start(&raw const _stack_start, start);

/// Does what the boot loader does before the image: points the processor to the image's vector table.
#[unsafe(naked)]
unsafe extern "C" fn start() {
    naked_asm!(
        // Register SCB_VTOR.
        "ldr r0, =0xe000ed08",
        "ldr r1, ={vectors}",
        "str r1, [r0]",
        "dsb",
        "b {reset}",
        ".ltorg",
        vectors = sym __vector_table,
        reset = sym Reset,
    )
}

/// Returns the settings with which `replay` scans the recording; the internal oscillator is allowed, since not every board has
/// a crystal of 8 MHz.
pub fn settings() -> Settings {
    let mut settings = Settings {
        sweep_mode: SweepMode::Stop,
        motion: Mode::Standing,
        ..Settings::default()
    };
    settings.config.seed = SEED;
    settings.timing.internal_clock = Switch::On;
    settings
}

/// The recording as a radar module that answers at once.
#[derive(Debug, Default)]
pub struct Recorded {
    /// Angle of the shaft at the last trigger, 0.001°.
    shaft_angle: i32,
}

impl Recorded {
    /// Returns the samples of the chirp nearest to the shaft's angle, as a frame of the link holds them; `None` if there
    /// is none.
    fn chirp(&self) -> Option<&'static [u8]> {
        let Config { sweep, radar, .. } = Config::default();
        let from_first = self.shaft_angle - sweep.first_angle + sweep.angle_step / 2;
        let row = from_first.checked_div_euclid(sweep.angle_step)?;
        let length = usize::from(radar.samples) * size_of::<Iq>();
        let from = usize::try_from(row).ok()? * length;
        RECORDING.get(from..from + length)
    }
}

impl RadarModule for Recorded {
    fn program(&mut self, _: Micros, _: &RequestedSettings, _: u32) {}

    fn settings(&mut self, _: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        Poll::Ready(Ok(Config::default().radar))
    }

    fn trigger(&mut self, _: Micros, shaft_angle: i32, _: u32) {
        self.shaft_angle = shaft_angle;
    }

    fn poll(&mut self, _: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        let chirp = self.chirp();
        let complete = chirp.is_some_and(|bytes| frame::parse_chirp(bytes, samples));
        Poll::Ready(complete.then_some(()).ok_or(LinkError::Timeout))
    }
}
