//! Reads the scanner's report from standard input, as a wheelchair's controller would from the UART.
//!
//! ```sh
//! cargo sim replay recordings/stair_a | grep -o '\$PSTR.*' | cargo run --example parse_report
//! ```
//!
//! Every line that is no intact sentence is named with its reason, and a scan of which a step or the drop is
//! missing is said to be incomplete: half a staircase is nothing to drive on. Exit status 1 if there
//! was either.

use std::io::{self, BufRead};
use std::process::ExitCode;

use stairscan::report::{ScanLine, Sentence, Tenths};

/// The scan whose steps are coming in.
#[derive(Default)]
struct Scan {
    head: Option<ScanLine>,
    steps: u8,
    drops: u8,
}

impl Scan {
    /// Begins another scan, or ends the report; whether the one before was complete.
    fn next(&mut self, head: Option<ScanLine>) -> bool {
        let begun = Self {
            head,
            ..Self::default()
        };
        let ended = std::mem::replace(self, begun);
        let short = |scan: &ScanLine| scan.steps != ended.steps || scan.drops != ended.drops;
        let Some(scan) = ended.head.filter(short) else {
            return true;
        };
        let drops = if scan.drops == ended.drops {
            String::new()
        } else {
            format!(" and {} of {} drops", ended.drops, scan.drops)
        };
        println!(
            "scan {}: incomplete, {} of {} steps{drops} came",
            scan.scan, ended.steps, scan.steps
        );
        false
    }
}

/// Sentences carry tenths of a millimetre.
fn millimetres(Tenths(tenths): Tenths) -> f64 {
    f64::from(tenths) / 10.0
}

fn main() -> io::Result<ExitCode> {
    let mut scan = Scan::default();
    let mut intact = true;
    for (number, line) in (1..).zip(io::stdin().lock().split(b'\n')) {
        let line = line?;
        let line = line.trim_ascii_end();
        if line.is_empty() {
            continue;
        }
        let Ok(text) = str::from_utf8(line) else {
            println!("line {number} is damaged: not ASCII");
            intact = false;
            continue;
        };
        match Sentence::parse(text) {
            Ok(Sentence::Scan(head)) => {
                intact &= scan.next(Some(head));
                print!("scan {}: {}", head.scan, head.status.as_str());
                print!(", {} steps {}", head.steps, head.direction.as_str());
                if head.reasons.is_empty() {
                    println!();
                } else {
                    println!(" ({})", head.reasons);
                }
            }
            Ok(Sentence::Step(step)) => {
                let belongs = scan.head.is_some_and(|head| head.scan == step.scan);
                scan.steps = scan.steps.saturating_add(u8::from(belongs));
                println!(
                    "scan {}, step {} of {}: distance {:.1} mm (σ {:.1}), height {:.1} mm (σ {:.1})",
                    step.scan,
                    step.index,
                    step.count,
                    millimetres(step.distance),
                    millimetres(step.distance_sigma),
                    millimetres(step.height),
                    millimetres(step.height_sigma)
                );
            }
            Ok(Sentence::Drop(drop)) => {
                let belongs = scan.head.is_some_and(|head| head.scan == drop.scan);
                scan.drops = scan.drops.saturating_add(u8::from(belongs));
                println!(
                    "scan {}: the ground ends at {:.1} mm (σ {:.1})",
                    drop.scan,
                    millimetres(drop.distance),
                    millimetres(drop.distance_sigma)
                );
            }
            Ok(other) => println!("{other:?}"),
            Err(error) => {
                println!("line {number} is damaged: {error}");
                intact = false;
            }
        }
    }
    intact &= scan.next(None);
    Ok(ExitCode::from(u8::from(!intact)))
}
