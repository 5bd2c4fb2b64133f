//! Motion sentences and the odometry behind them: what is read is written as it was read, and whatever came,
//! each row's place is a number.
//!
//! An operation is a byte, and what it needs after it:
//!
//! | byte | then | what |
//! |---|---|---|
//! | 0 | count, bytes | the text between `$PSTC,` and `*` of a sentence |
//! | 1 | u8, i16, i16 | a reading: sequence and travel (0.1 mm) so much more than the last one's, pitch in 0.01° |
//! | 2 | u16 | a scan of so many rows begins |
//! | 3 | | the next row |
//! | 4 | | the scan ends |
//! | 5 | u16 | so many 0.1 ms pass |
//! | 6 | u32 | so many µs pass |
//! | 7 | | a damaged sentence |

use stairscan::config::MAX_ROWS;
use stairscan::motion::{Mode, Odometry, Reading};
use stairscan::report::motion;
use stairscan::scanner::Micros;

use crate::input::Input;

/// Reads a sentence's text.
fn sentence(bytes: &[u8]) -> Option<Reading> {
    let reading = motion::parse(str::from_utf8(bytes).ok()?).ok()?;
    let line = motion::write(&reading);
    let body = line
        .strip_prefix("$PSTC,")
        .and_then(|l| l.split('*').next());
    assert_eq!(motion::parse(body.expect("a frame")), Ok(reading));
    Some(reading)
}

/// Whatever came before, what is known of the drive are numbers.
fn check(odometry: &Odometry, rows: u16) {
    for mode in [Mode::Auto, Mode::Required, Mode::Standing] {
        let drive = odometry.drive(mode, 1000);
        assert!(drive.moved_m.is_none_or(f32::is_finite));
        assert!(drive.since_s.is_none_or(f32::is_finite));
        let Some(track) = drive.known() else { continue };
        for row in [0, rows / 2, rows.saturating_sub(1), rows, u16::MAX] {
            let row = f32::from(row);
            let (place, slope) = (track.at(row), track.per_row(row));
            let values = [
                place.travel_m,
                place.pitch_rad,
                slope.travel_m,
                slope.pitch_rad,
            ];
            assert!(
                values.iter().all(|v| v.is_finite()),
                "row {row}: {values:?}"
            );
            assert!(track.speed(row).is_finite());
        }
    }
}

/// Runs the operations.
pub fn run(data: &[u8]) {
    let mut input = Input(data);
    let mut odometry = Odometry::new();
    let mut now = Micros(u32::MAX - 500_000);
    let mut last = Reading::default();
    let (mut rows, mut row) = (0, 0);
    while !input.is_empty() {
        match input.byte() % 8 {
            0 => {
                if let Some(reading) = sentence(input.counted()) {
                    odometry.take(now, reading);
                    last = reading;
                }
            }
            1 => {
                last.sequence = last.sequence.wrapping_add(input.byte().into());
                last.travel = last.travel.wrapping_add((input.short() as i16).into());
                last.pitch =
                    Some(i32::from(input.short() as i16) * 10).filter(|p| p.abs() <= 45_000);
                odometry.take(now, last);
            }
            2 => {
                rows = input.short() % (MAX_ROWS as u16 + 1);
                row = 0;
                odometry.begin(rows);
            }
            3 if row < rows => {
                odometry.row(row, now);
                row += 1;
            }
            4 => {
                odometry.finish(now);
                check(&odometry, rows);
                rows = 0;
            }
            5 => now = now.plus(100 * u32::from(input.short())),
            6 => now = now.plus(input.word()),
            7 => odometry.garbled(),
            _ => {}
        }
        let _ = odometry.state(now);
    }
}
