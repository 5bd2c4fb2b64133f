//! `update PORT FILE`: a signed image over the report port.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use stairscan_boot::receive::FIRST_BAUD;
use stairscan_boot::slot::Slot;

use super::{emit, progress};
use crate::doctor::option_bytes;
use crate::live::{port, ports};
use crate::update::client::{Client, Outcome, slot_line, version};
use crate::update::keys::hex;
use crate::update::package::Package;

/// Arguments of `update`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "The scanner stops, its boot loader takes the image into the slot that does not run, checks it and starts it on \
trial. Once the self-test has passed, with mirror and radar module, the image is confirmed; three starts without that, and the \
one before runs again. Whatever breaks off, a cable or the supply: the same command goes on. docs/user/update.md tells it all."
)]
pub struct Args {
    /// The report port, such as /dev/ttyUSB0
    port: String,
    /// What `keys sign` wrote
    #[arg(required_unless_present_any = ["back", "show"])]
    file: Option<PathBuf>,
    /// Go back to the image before, where it has the same number
    #[arg(long, conflicts_with = "file")]
    back: bool,
    /// Only print what is in both slots
    #[arg(long, conflicts_with_all = ["file", "back"])]
    show: bool,
    /// Fastest rate to agree on, baud: 1, 2 or 3 Mbaud, or 115200 for none
    #[arg(long, default_value_t = 3_000_000, value_parser = clap::value_parser!(u32).range(115_200..=3_000_000))]
    fastest: u32,
    /// Seconds to wait for the boot loader where no image sends the scanner there
    #[arg(long, default_value_t = 60)]
    catch: u64,
    /// Seconds to wait for the confirmation: the self-test homes the mirror and asks the radar module
    #[arg(long, default_value_t = 60)]
    wait: u64,
}

/// Sends the image and waits for its confirmation; exit status 1 where that does not come.
pub fn run(args: &Args) -> Result<ExitCode> {
    let package = args.file.as_deref().map(Package::read).transpose()?;
    let opened = port::open(&args.port, FIRST_BAUD);
    let opened = opened.map_err(|error| {
        let (what, help) = ports::trouble(&args.port, &error).explain(&args.port);
        anyhow::anyhow!("{}", [&[what][..], &help].concat().join("\n  "))
    })?;
    let mut client = Client::enter_within(opened, Duration::from_secs(args.catch), |remedy| {
        crate::note!("no answer yet; for {} s more: {remedy}", args.catch);
    })?;
    for slot in Slot::BOTH {
        emit(&format!("{}\n", slot_line(&client.info, slot)));
    }
    emit(&format!(
        "key {}, anti-rollback counter {}\n",
        hex(&client.info.key_id),
        client.info.floor
    ));
    let option_bytes = option_bytes::text(client.info.option_bytes);
    emit(&format!("option bytes {option_bytes}\n"));
    if client.info.development {
        crate::note!(
            "warning: this scanner trusts the development key, which everybody has: anybody's image would be taken"
        );
    }
    let Some(package) = package else {
        return finish(args, client);
    };
    let spare = client.spare().as_str();
    emit(&format!("{} goes to slot {spare}\n", version(&package)));
    let bar = progress(1).with_prefix("sending");
    let sent = client.send(&package, args.fastest, |next, total| {
        bar.set_length(total.into());
        bar.set_position(next.into());
    });
    bar.finish_and_clear();
    let sent = sent.with_context(|| args.port.clone())?;
    let resumed = match sent.resumed {
        0 => String::new(),
        offset => format!(", from byte {offset} on"),
    };
    emit(&format!(
        "{} bytes in {:.1} s at {} baud{resumed}; signature and hash are right\n",
        sent.sent,
        sent.time.as_secs_f64(),
        sent.baud
    ));
    let outcome = client.follow(&version(&package), Duration::from_secs(args.wait))?;
    Ok(tell(&outcome))
}

/// Ends a session with the boot loader in which no image is sent: goes back to the previous image, or leaves the boot
/// loader.
fn finish<W: crate::update::wire::Wire>(args: &Args, mut client: Client<W>) -> Result<ExitCode> {
    if args.back {
        client.back()?;
        emit("the image before runs again\n");
    } else {
        ensure!(args.show, "expected a file, --back or --show");
        client.boot()?;
    }
    Ok(ExitCode::SUCCESS)
}

fn tell(outcome: &Outcome) -> ExitCode {
    match outcome {
        Outcome::Confirmed => {
            emit("confirmed: the self-test has passed\n");
            return ExitCode::SUCCESS;
        }
        Outcome::OnTrial(why) => crate::note!(
            "error: not confirmed: {why}\n  it stays on trial: `selftest` or `start` confirm it, the third start without that \
             brings the image before back"
        ),
        Outcome::RolledBack(states) => {
            crate::note!(
                "error: rolled back: the loader runs another image; slots a and b: {states}"
            )
        }
        Outcome::NotHeard(instead) => crate::note!(
            "error: {} of the new image: the watchdog resets it within half a minute, and the third time the image before \
             runs again",
            match instead {
                None => "nothing is heard".to_owned(),
                Some(instead) => format!("no sentence is heard ({instead})"),
            }
        ),
    }
    ExitCode::FAILURE
}
