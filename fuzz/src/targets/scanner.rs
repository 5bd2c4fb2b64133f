//! The scanner under random events: lines, a radar module, a motor and a report port that misbehave. Whatever
//! they do, every line that comes out is a whole sentence, a fault carries no steps, no chirp is fired while
//! the mirror turns, a fault leaves the driver off; and once all is well again, `stop`, the default settings
//! and `start` bring a scan that is `ok`.
//!
//! An operation is a byte, and what it needs after it:
//!
//! | byte | then | what |
//! |---|---|---|
//! | 0 | u8 | one more than so many ms pass, one step each |
//! | 1 | u16 | so many ms pass at once |
//! | 2 | count, bytes | these are typed |
//! | 3 | count, text | this is typed within a frame with its CRC |
//! | 4 | u8 | the module's [`Mood`] |
//! | 5 | u8 | bit 0: a stall; bits 1 and 2: the home switch works, is dead, or is stuck |
//! | 6 | u8 | the report port takes so many bytes a step |
//! | 7 | u8 | bit 0: the self-test fails; bits 1 and 2: scans end `ok`, as faults, or with steps |
//! | 8 | u8 | the encoder, where it is set: 0 sees the shaft, 1 is silent, 2 finds no magnet; it is off by as much as it is more |

mod bench;
mod world;

use stairscan::motion::Odometry;
use stairscan::scanner::Reports;

use crate::input::Input;
use bench::Bench;
pub use world::Mood;

/// Runs the operations, then asks for a scan that is `ok`.
pub fn run(data: &[u8]) {
    let (mut reports, mut odometry) = (Reports::new(), Odometry::new());
    let mut bench = Bench::new((&mut reports, &mut odometry));
    let mut input = Input(data);
    while !input.is_empty() {
        match input.byte() % 9 {
            0 => bench.steps(u32::from(input.byte()) + 1),
            1 => bench.jump(input.short()),
            2 => bench.type_in(input.counted()),
            3 => {
                let framed = [b"!", input.counted()].concat();
                if let Some(line) = super::commands::framed(&framed) {
                    bench.type_in(&line);
                }
            }
            4 => bench.world(|w| w.mood = Mood::of(input.byte())),
            5 => {
                let what = input.byte();
                bench.world(|w| {
                    w.stalled |= what & 1 != 0;
                    w.switch = what >> 1;
                });
            }
            6 => bench.world(|w| w.room = input.byte().into()),
            8 => bench.world(|w| w.encoder = input.byte()),
            _ => {
                let what = input.byte();
                bench.world(|w| (w.broken, w.verdict) = (what & 1 != 0, what >> 1));
            }
        }
        bench.steps(1);
    }
    bench.recovers();
}
