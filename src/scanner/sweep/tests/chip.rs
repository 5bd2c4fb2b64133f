//! Simulated chip that wakes up for a millisecond before it sweeps, like the BGT60TR13C, and is read after
//! sampling.

use core::task::Poll;

use super::bench::{MHZ, Shared};
use crate::Iq;
use crate::config::RadarConfig;
use crate::signal::radar::any::row_times;
use crate::signal::radar::module::{LinkError, ModuleKind, RadarModule, RequestedSettings};
use crate::signal::radar::wire::RowTimes;
use crate::testing::framed::Captured;
use crate::time::Micros;

/// Returns the times of a row by the driver of the BGT60TR13C.
fn times() -> RowTimes {
    let requested = RequestedSettings {
        kind: ModuleKind::Bgt60,
        ..RequestedSettings::DEFAULT
    };
    row_times(&requested, 0).unwrap()
}

/// The simulated chip on its SPI bus.
pub struct SpiChip {
    world: Shared,
    /// Shaft angle of the chirp under way, 0.001°, and the time at which its last word has been read, core
    /// clocks.
    chirp: Option<(i32, u64)>,
}

impl SpiChip {
    pub fn new(world: &Shared) -> Self {
        Self {
            world: world.clone(),
            chirp: None,
        }
    }
}

impl RadarModule for SpiChip {
    fn program(&mut self, _: Micros, _: &RequestedSettings, _: u32) {}

    fn settings(&mut self, _: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        Poll::Ready(Ok(RadarConfig::default()))
    }

    fn trigger(&mut self, _: Micros, angle: i32, _: u32) {
        assert!(self.chirp.is_none(), "triggered before it was read");
        let times = times();
        let world = self.world.0.borrow();
        let begin = world.now + u64::from(times.trigger_us) * MHZ;
        let end = begin + u64::from(times.chirp_us.unwrap()) * MHZ;
        let mut port = world.port.get();
        port.device.captures.push(Captured { angle, begin, end });
        self.chirp = Some((angle, end + u64::from(times.answer_us) * MHZ));
    }

    fn poll(&mut self, _: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        let now = self.world.0.borrow().now;
        let Some((angle, _)) = self.chirp.take_if(|(_, read)| *read <= now) else {
            return Poll::Pending;
        };
        samples.fill(Iq::new(angle as u16 as i16, (angle >> 16) as i16));
        Poll::Ready(Ok(()))
    }

    fn row_times(&self, _: u16) -> Option<RowTimes> {
        Some(times())
    }
}
