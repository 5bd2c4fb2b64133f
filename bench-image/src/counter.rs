//! Instruction counter by the emulator's SysTick: under `-icount shift=0` the time is proportional to the
//! number of instructions.

use core::hint::black_box;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// Maximum count of the 24-bit timer.
const RELOAD: u32 = 0x00ff_ffff;

/// A stopwatch in instructions, calibrated with a loop of known length.
pub struct Counter {
    _timer: SYST,
    instructions_per_tick: f32,
}

impl Counter {
    /// Starts the timer and measures the number of instructions of a tick.
    pub fn new(mut timer: SYST) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(RELOAD);
        timer.clear_current();
        timer.enable_counter();
        let mut counter = Self {
            _timer: timer,
            instructions_per_tick: 1.0,
        };
        const ROUNDS: u32 = 1_000_000;
        let ticks = counter.ticks(|| {
            // SAFETY: decrements a register of its own; two instructions a round.
            unsafe {
                core::arch::asm!(
                    "2: subs {n}, #1",
                    "bne 2b",
                    n = inout(reg) ROUNDS => _,
                    options(nomem, nostack)
                );
            }
        });
        counter.instructions_per_tick = 2.0 * ROUNDS as f32 / ticks as f32;
        counter
    }

    fn ticks(&mut self, work: impl FnOnce()) -> u32 {
        let from = SYST::get_current();
        work();
        // The timer counts down, and wraps at most once: 100 million instructions.
        from.wrapping_sub(SYST::get_current()) & RELOAD
    }

    /// Returns the current count, for [`Counter::lap`].
    pub fn now(&self) -> u32 {
        SYST::get_current()
    }

    /// Returns the number of instructions since `since`, and sets `since` to the current count.
    pub fn lap(&self, since: &mut u32) -> u32 {
        let now = self.now();
        let ticks = since.wrapping_sub(now) & RELOAD;
        *since = now;
        (ticks as f32 * self.instructions_per_tick) as u32
    }

    /// Returns the result of `work`, and its number of instructions to within a tick, which is 6.
    pub fn once<T>(&mut self, work: impl FnOnce() -> T) -> (T, u32) {
        let mut result = None;
        let ticks = self.ticks(|| result = Some(work()));
        let Some(result) = result else { unreachable!() };
        (result, (ticks as f32 * self.instructions_per_tick) as u32)
    }

    /// Returns the number of instructions of one `work`, averaged over `rounds` to reduce the tick's resolution
    /// error.
    pub fn count<T>(&mut self, rounds: u32, mut work: impl FnMut() -> T) -> u32 {
        let ticks = self.ticks(|| {
            for _ in 0..rounds {
                black_box(work());
            }
        });
        (ticks as f32 * self.instructions_per_tick / rounds as f32 + 0.5) as u32
    }
}
