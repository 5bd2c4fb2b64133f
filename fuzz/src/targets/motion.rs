//! Motion sentences and odometry. A parsed sentence is written identically, and after any input each row's
//! position is finite.
//!
//! An operation is a byte with its arguments:
//!
//! | byte | arguments | operation |
//! |---|---|---|
//! | 0 | count, bytes | parses the text between `$PSTC,` and `*` of a sentence |
//! | 1 | u8, i16, i16 | gives a reading: increments of sequence and travel (0.1 mm), pitch in 0.01° |
//! | 2 | u16 | begins a scan with this number of rows |
//! | 3 | | gives the next row |
//! | 4 | | ends the scan |
//! | 5 | u16 | advances the time, 0.1 ms |
//! | 6 | u32 | advances the time, µs |
//! | 7 | | gives a damaged sentence |

use stairscan::config::MAX_ROWS;
use stairscan::motion::{Mode, Odometry, Reading};
use stairscan::report::motion;
use stairscan::scanner::Micros;

use crate::input::Input;

/// Parses a sentence's text.
fn sentence(bytes: &[u8]) -> Option<Reading> {
    let reading = motion::parse(str::from_utf8(bytes).ok()?).ok()?;
    let line = motion::write(&reading);
    let body = line
        .strip_prefix("$PSTC,")
        .and_then(|l| l.split('*').next());
    assert_eq!(motion::parse(body.expect("a frame")), Ok(reading));
    Some(reading)
}

/// Checks that the values of the drive are finite after any input.
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
