//! Endurance test of one scanner over days of simulated time: the loop of the image with its watchdog, the log of
//! settings over NOR flash, a shaft and a radar module that take their time, motion sentences and commands.
//!
//! In: days, seed, and for tests a defect. Out: failed checks, and a summary with the largest gaps, over all and
//! within a minute of a wrap of the clock. Answers come from a data path without signal processing: those of real
//! scans are checked by [`super::soak`].

mod controller;
mod data;
mod gaps;
mod life;
mod plan;
mod shaft;
mod summary;
mod watch;
mod world;

#[cfg(test)]
mod tests;

pub use life::Defect;
pub use summary::Summary;

use gaps::DAY_US;
use life::{Life, LifeMemory, Run};
use plan::Ending;

/// Runs `days` days of simulated time. `look` is called with the number of whole days from time to time.
pub fn days(days: f64, seed: u64, look: impl FnMut(u64)) -> Summary {
    run(days, seed, None, look)
}

/// [`days`] with a defect.
fn run(days: f64, seed: u64, defect: Option<Defect>, mut look: impl FnMut(u64)) -> Summary {
    let end = (days * DAY_US as f64) as u64;
    let mut run = Run::new(seed);
    run.defect = defect;
    let mut reset = "power-on";
    loop {
        let mut memory = LifeMemory::new();
        let mut life = Life::new(&mut memory, &mut run, reset);
        let ending = life.live_until(end, &mut look);
        match ending {
            Ok(Ending::Reset(cause)) => reset = cause,
            Ok(Ending::Over) => break,
            Err(error) => {
                let instant = run.instant();
                run.watch.fail(instant, &format!("{error:#}"), "none");
                break;
            }
        }
    }
    Summary::of(run)
}
