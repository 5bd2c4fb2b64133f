//! The scanner under random events: lines, and faults of radar module, motor and report port. In every case each
//! output line is a complete sentence, a fault contains no steps, no chirp is triggered while the mirror turns, and a
//! fault leaves the driver off. After all faults are removed, `stop`, the default settings and `start` lead to a scan
//! that is `ok`.
//!
//! An operation is a byte with its arguments:
//!
//! | byte | arguments | operation |
//! |---|---|---|
//! | 0 | u8 | advances the time by this plus one ms, in steps of one ms |
//! | 1 | u16 | advances the time, ms, in one step |
//! | 2 | count, bytes | types these bytes |
//! | 3 | count, text | types this text within a frame with its CRC |
//! | 4 | u8 | sets the fault of the module's answers |
//! | 5 | u8 | bit 0: a stall; bits 1 and 2: the home switch works, is dead, or is stuck |
//! | 6 | u8 | bytes that the report port takes in each step |
//! | 7 | u8 | bit 0: the self-test fails; bits 1 and 2: scans end `ok`, as faults, or with steps |
//! | 8 | u8 | the encoder, if configured: 0 measures the shaft, 1 is silent, 2 finds no magnet; larger values are an error of the angle |

mod bench;
mod world;

use stairscan::motion::Odometry;
use stairscan::scanner::{LentParts, Reports};

use crate::input::Input;
use bench::Bench;

/// Runs the operations, then checks that a scan becomes `ok`.
pub fn run(data: &[u8]) {
    let (mut reports, mut odometry) = (Reports::new(), Odometry::new());
    let mut bench = Bench::new(LentParts {
        reports: &mut reports,
        odometry: &mut odometry,
    });
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
            4 => bench.link.get().device.framed.fault = world::fault(input.byte()),
            5 => {
                let what = input.byte();
                bench.world(|w| {
                    let mut motor = w.motor.get();
                    motor.stalled |= what & 1 != 0;
                    let switch = (what >> 1) % 3;
                    (motor.switch_works, motor.jammed) = (switch != 1, switch == 2);
                });
            }
            6 => bench.port.get().wires.room = input.byte().into(),
            8 => bench.world(|w| w.encoder = input.byte()),
            _ => {
                let what = input.byte();
                bench.world(|w| (w.broken, w.verdict) = (what & 1 != 0, what >> 1));
                bench.board.get().break_flash(what & 1 != 0);
            }
        }
        bench.steps(1);
    }
    bench.recovers();
}
