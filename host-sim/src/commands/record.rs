//! `record PORT…`: records the traffic of the radar link, together with the scanner's answers.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, bail, ensure};
use serialport::SerialPort;
use stairscan::config::{Config, Plane, SweepConfig, to_fixed};
use stairscan::scanner::{Micros, Schedule};
use stairscan::schedule::shaft_angle;
use stairscan::signal::radar::wire::LINK_BAUD;

use super::{Settings, emit};
use crate::counted::counted;
use crate::live::Ms;
use crate::live::arrived::Arrived;
use crate::live::lines::Splitter;
use crate::live::port::{self, passes};
use crate::live::ports;
use crate::live::trouble::REPORT_BAUD;
use crate::output::{Outputs, Overwrite};
use crate::recording::{self, Recording};
use crate::replay;
use crate::setup::{self, Kind};
use crate::tap::ask;
use crate::tap::beside::{self, Beside, MountingArgs};
use crate::tap::demo::Demo;
use crate::tap::gather::{Gather, Part};
use crate::tap::kinds;
use crate::tap::mounting::Mounting;
use crate::tap::nothing::{instead, nothing};
use crate::tap::pace::Pace;
use crate::tap::scans::{Scan, Tap, Wire};
use crate::tap::unfinished::Unfinished;

/// Time without a frame on the radar link after which a scan is complete, ms; a module may take 0.6 s of retries.
const QUIET: Ms = 3_000;
/// Time for which the scanner's last answer is awaited after the end of the recording. The longest answer takes 0.14 s
/// at 115,200 baud (23 sentences of 70 bytes); a busy host adds to it.
const LINGER: Duration = Duration::from_millis(1_000);

/// Arguments of `record`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Ctrl-C ends the recording; complete scans are written. Until then each complete scan is kept in
hall.unfinished, which remains if the program is killed. If it begins before the scanner's first scan (or a `reset`),
`replay hall --motion auto` gives the same sentences as the scanner. Wiring: docs/user/live.md."
)]
pub struct Args {
    /// Ports that receive the radar link: one for each direction, or one for both
    #[arg(required_unless_present = "demo", num_args = 1..=2, value_name = "PORT")]
    ports: Vec<String>,
    /// Record without hardware, from a radar module on this machine that plays this recording
    #[arg(long, value_name = "REC", conflicts_with_all = ["ports", "report", "module", "angles"])]
    demo: Option<PathBuf>,
    /// The recording to write, with or without suffix
    #[arg(short, long, value_name = "REC")]
    output: PathBuf,
    /// The scanner's report port; its sentences are written beside the recording
    #[arg(long, value_name = "PORT")]
    report: Option<String>,
    /// Read the scanner's settings (`get`) over the report port, which must be able to send
    #[arg(long, requires = "report")]
    ask: bool,
    /// The port is the radar module's own; request chirps in place of the scanner
    #[arg(long, conflicts_with = "report")]
    module: bool,
    /// With --module: angles of the beam, FIRST:LAST:STEP in degrees
    #[arg(long, requires = "module", default_value = "-20:50:0.25", value_parser = angles, allow_hyphen_values = true)]
    angles: SweepConfig,
    /// Angles of the scanner's guard sweeps, FIRST:LAST:STEP in degrees; without it those that the scanner reports
    /// (--ask), else the defaults
    #[arg(long, value_name = "ANGLES", value_parser = angles, allow_hyphen_values = true, conflicts_with_all = ["module", "demo"])]
    guard: Option<SweepConfig>,
    /// Number of scans, guard sweeps included, after which recording ends
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    scans: Option<u32>,
    /// Baud rate of the radar link at the beginning; the rate that scanner and module agree on is followed
    #[arg(long, default_value_t = LINK_BAUD)]
    baud: u32,
    #[command(flatten)]
    said: MountingArgs,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    overwrite: Overwrite,
}

fn angles(text: &str) -> Result<SweepConfig, String> {
    let expected = || "expected FIRST:LAST:STEP in degrees, such as -20:50:0.25".to_owned();
    let numbers: Option<Vec<i32>> = (text.split(':'))
        .map(|part| part.parse().ok().and_then(|v: f64| to_fixed(v, 1e-3)))
        .collect();
    let Some(&[first_angle, last, angle_step]) = numbers.as_deref() else {
        return Err(expected());
    };
    let steps = (angle_step > 0).then(|| (last - first_angle) / angle_step);
    let count = steps.and_then(|steps| u16::try_from(steps + 1).ok());
    let sweep = SweepConfig {
        first_angle,
        angle_step,
        angle_count: count.ok_or_else(expected)?,
    };
    sweep.validate().map_err(|error| error.to_string())?;
    Ok(sweep)
}

/// Bytes received from a port, of the radar link or of the scanner's reports, or the cause of a port's end.
enum PortEvent {
    Link(Wire, Vec<u8>),
    Report(Vec<u8>),
    Gone(String),
}

/// Path of a port of the radar link, and a handle that sets its baud rate.
type LinkPort = (String, Box<dyn SerialPort>);

/// Traffic of the radar link and sentences of the scanner received so far.
struct Received {
    pace: Pace,
    tap: Tap,
    beside: Beside,
    splitter: Splitter,
    /// Lines of the report port, by kind.
    arrived: Arrived,
    /// The last agreed bit rate that was reported on stderr.
    told: Option<u32>,
    /// Cause for which a port has ended, if it is to be reported.
    gone: Option<String>,
}

impl Received {
    fn new(baud: u32) -> Self {
        Self {
            pace: Pace::new(baud),
            tap: Tap::default(),
            beside: Beside::default(),
            splitter: Splitter::default(),
            arrived: Arrived::default(),
            told: None,
            gone: None,
        }
    }

    /// Sets the ports of the link to the rate that its traffic shows at `now`, after `count` more bytes.
    fn follow(&mut self, at: Ms, count: usize, ports: &mut [LinkPort]) {
        let Some(baud) = self.pace.take(at, count, &mut self.tap) else {
            return;
        };
        if self.pace.agreed == Some(baud) && self.told != Some(baud) {
            self.told = Some(baud);
            crate::note!("note: scanner and module go to {baud} baud, and the ports with them");
        }
        for (path, port) in ports {
            if let Err(error) = port.set_baud_rate(baud) {
                crate::note!(
                    "note: {path}: not at {baud} baud ({error}); `set link-rate {LINK_BAUD}` keeps the link at {LINK_BAUD}"
                );
            }
        }
    }

    /// Processes the bytes that a port received at the time `at`, or the port's end; returns `false` at the end.
    fn take(&mut self, at: Ms, event: PortEvent) -> bool {
        match event {
            PortEvent::Link(wire, bytes) => self.tap.push(at, wire, &bytes),
            PortEvent::Report(bytes) => {
                for line in self.splitter.push(&bytes) {
                    self.arrived.line(&line);
                    self.beside.line(at, &line);
                }
            }
            PortEvent::Gone(why) => {
                self.gone = Some(why);
                return false;
            }
        }
        true
    }

    /// Moves the complete scans from the received traffic to `scans`, stores each in case the session is interrupted,
    /// and prints its number of rows.
    fn scans_into(&mut self, session: &mut Session<'_>, scans: &mut Vec<Scan>) {
        while let Some(scan) = self.tap.scan() {
            let (mounting, _) = session.mounting(&self.beside);
            let kept = session.unfinished.keep(&scan, &mounting, &self.beside);
            if let Err(error) = kept {
                crate::note!("note: {error:#}: this scan is lost if the session is interrupted");
            }
            let (rows, lost) = (scan.rows.len(), scan.lost());
            let (kind, _) = kinds::by_angles(&scan, &mounting);
            let what = kinds::name(kind.unwrap_or(Kind::Scans));
            crate::note!("{what}: {}, {lost} of them lost", counted(rows, "row"));
            scans.push(scan);
        }
    }
}

/// A running session of `record`.
struct Session<'a> {
    args: &'a Args,
    /// Angles at which this program itself requests chirps; `None` if it only listens.
    sweep: Option<SweepConfig>,
    /// Angles of guard sweeps, if the user has given them or a recording of them is played.
    guard: Option<SweepConfig>,
    unfinished: Unfinished,
}

impl Session<'_> {
    /// Returns what the radar link does not transmit, and a remark on its source.
    fn mounting(&self, beside: &Beside) -> (Mounting, Option<String>) {
        let (reported, doubt) = beside::mounting(&self.args.said, beside);
        let mounting = Mounting {
            sweep: self.sweep.or(reported.sweep),
            guard: self.guard.or(reported.guard),
            ..reported
        };
        (mounting, doubt)
    }
}

/// Listens to the radar link, or acquires scans from the module itself, and writes the recordings.
pub fn run(args: &Args) -> Result<ExitCode> {
    let outputs = args.overwrite.reading(&args.demo);
    outputs.ready_recording(&args.output)?;
    outputs.ready(&sentences(&args.output))?;
    ensure!(
        !args.module || args.ports.len() == 1,
        "--module: expected one port"
    );
    let stop = Arc::new(AtomicBool::new(false));
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        signal_hook::flag::register(signal, stop.clone())?;
    }
    let mut session = Session {
        args,
        sweep: args.module.then_some(args.angles),
        guard: args.guard,
        unfinished: Unfinished::begin(&args.output)?,
    };
    let (received, scans) = match (&args.demo, args.module) {
        (Some(path), _) => {
            let demo = Demo::start(path, &args.settings.config()?)?;
            match demo.kind {
                Kind::Scans => session.sweep = Some(demo.sweep),
                Kind::Guard => session.guard = Some(demo.sweep),
            }
            ask_module(&mut session, &demo.port, demo.sweep, &stop)?
        }
        (None, true) => ask_module(&mut session, &args.ports[0], args.angles, &stop)?,
        (None, false) => listen(&mut session, &stop)?,
    };
    if let Some(why) = &received.gone {
        crate::note!("{why}: complete scans are written");
    }
    write(session, &outputs, received, scans)
}

/// Listens to all ports until the end. Returns the received traffic and the scans.
fn listen(session: &mut Session<'_>, stop: &Arc<AtomicBool>) -> Result<(Received, Vec<Scan>)> {
    let (started, args) = (Instant::now(), session.args);
    let (sender, events) = mpsc::channel();
    let wires: &[Wire] = match args.ports.len() {
        1 => &[Wire::Both],
        _ => &[Wire::ToModule, Wire::FromModule],
    };
    let (mut threads, mut link) = (Vec::new(), Vec::new());
    for (path, wire) in args.ports.iter().zip(wires) {
        let (port, wire) = (open(path, args.baud)?, *wire);
        link.push((
            path.clone(),
            port.try_clone().with_context(|| path.clone())?,
        ));
        let bytes = move |bytes| PortEvent::Link(wire, bytes);
        threads.push(follow(path, port, started, &sender, stop, bytes));
    }
    if let Some(path) = &args.report {
        let mut port = open(path, REPORT_BAUD)?;
        if args.ask {
            port.write_all(b"get\r\n").with_context(|| path.clone())?;
        }
        threads.push(follow(
            path,
            port,
            started,
            &sender,
            stop,
            PortEvent::Report,
        ));
    }
    drop(sender);
    crate::note!("receiving; Ctrl-C ends");
    let found = collect(session, (&events, &mut link), started, stop);
    stop.store(true, Ordering::Relaxed);
    for thread in threads {
        let _ = thread.join();
    }
    Ok(found)
}

fn open(path: &str, baud: u32) -> Result<Box<dyn SerialPort>> {
    port::open(path, baud).map_err(|error| {
        let (what, helps) = ports::trouble(path, &error).explain(path);
        let helps: String = helps.iter().map(|help| format!("\n  {help}")).collect();
        anyhow!("{what}{helps}")
    })
}

/// Starts a thread that reads a port and sends what `event` makes of the bytes, each with its time since `started`, ms.
fn follow(
    path: &str,
    mut port: Box<dyn SerialPort>,
    started: Instant,
    sender: &Sender<(Ms, PortEvent)>,
    stop: &Arc<AtomicBool>,
    event: impl Fn(Vec<u8>) -> PortEvent + Send + 'static,
) -> std::thread::JoinHandle<()> {
    let (path, sender, stop) = (path.to_owned(), sender.clone(), stop.clone());
    std::thread::spawn(move || {
        let mut buffer = [0; 4096];
        while !stop.load(Ordering::Relaxed) {
            let what = match port.read(&mut buffer) {
                Ok(count @ 1..) => event(buffer[..count].to_vec()),
                Err(error) if passes(error.kind()) && Path::new(&path).exists() => continue,
                Ok(_) => PortEvent::Gone(format!("{path} has gone")),
                Err(error) => PortEvent::Gone(format!("{path} has gone ({error})")),
            };
            let last = matches!(what, PortEvent::Gone(_));
            let at = started.elapsed().as_millis() as Ms;
            if sender.send((at, what)).is_err() || last {
                return;
            }
        }
    })
}

/// Collects the events of all ports until there are enough scans, a port disappears, or the user ends the session.
fn collect(
    session: &mut Session<'_>,
    (events, link): (&Receiver<(Ms, PortEvent)>, &mut [LinkPort]),
    started: Instant,
    stop: &AtomicBool,
) -> (Received, Vec<Scan>) {
    let (mut received, mut scans) = (Received::new(session.args.baud), Vec::new());
    let wanted = session
        .args
        .scans
        .map_or(usize::MAX, |scans| scans as usize);
    let whole = |scans: &[Scan]| scans.iter().filter(|scan| scan.begun).count();
    while !stop.load(Ordering::Relaxed) && whole(&scans) < wanted {
        match events.recv_timeout(Duration::from_millis(100)) {
            Ok((at, what)) => {
                let count = match &what {
                    PortEvent::Link(_, bytes) => bytes.len(),
                    _ => 0,
                };
                if !received.take(at, what) {
                    break;
                }
                received.follow(at, count, link);
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        let now = started.elapsed().as_millis() as Ms;
        let quiet = |last: Ms| now.saturating_sub(last) > QUIET;
        if received.tap.received().is_some_and(quiet) {
            received.tap.end();
        }
        received.scans_into(session, &mut scans);
    }
    // The last answer may be late: the report port is slower than the link.
    let until = Instant::now() + LINGER;
    while let Ok((at, what)) = events.recv_timeout(until.saturating_duration_since(Instant::now()))
    {
        if matches!(what, PortEvent::Report(_)) {
            received.take(at, what);
        }
    }
    received.tap.end();
    received.scans_into(session, &mut scans);
    (received, scans)
}

/// Acquires scans from the module itself, alternately forward and backward.
fn ask_module(
    session: &mut Session<'_>,
    port: &str,
    sweep: SweepConfig,
    stop: &AtomicBool,
) -> Result<(Received, Vec<Scan>)> {
    let (started, args) = (Instant::now(), session.args);
    let tapped = Rc::new(RefCell::new(Vec::new()));
    let mut serial = open(port, args.baud)?;
    serial.set_timeout(Duration::from_millis(1))?;
    let mut link = ask::link(ask::Serial::new(serial), &tapped);
    let mut config = Config {
        sweep,
        ..Config::default()
    };
    config.mount.plane = args.said.plane.unwrap_or(Plane::Depth).into();
    let schedule = Schedule::new(&config).map_err(|error| anyhow!("--angles: {error}"))?;
    let mut angles: Vec<i32> = (0..schedule.rows())
        .map(|row| shaft_angle(schedule.position(row)))
        .collect();
    let (mut received, mut scans) = (Received::new(args.baud), Vec::new());
    for _ in 0..args.scans.unwrap_or(1) {
        let mut now = || {
            let at = started.elapsed();
            for (wire, byte) in tapped.borrow_mut().drain(..) {
                received.tap.push(at.as_millis() as Ms, wire, &[byte]);
            }
            Micros(at.as_micros() as u32)
        };
        let asked = ask::scan(&mut link, &angles, stop, &mut now);
        now();
        received.tap.end();
        received.scans_into(session, &mut scans);
        match asked {
            Err(error) if scans.is_empty() => {
                let instead = instead(&received.tap, &received.pace);
                let error = instead
                    .into_iter()
                    .fold(error, |error, text| anyhow!("{error}\n  {text}"));
                return Err(error.context(port.to_owned()));
            }
            Err(error) => received.gone = Some(format!("{port}: {error}")),
            Ok(()) => {}
        }
        angles.reverse();
        if received.gone.is_some() || stop.load(Ordering::Relaxed) {
            break;
        }
    }
    Ok((received, scans))
}

/// Writes the recordings, and the sentences beside them, and prints their contents.
fn write(
    session: Session<'_>,
    outputs: &Outputs,
    received: Received,
    scans: Vec<Scan>,
) -> Result<ExitCode> {
    let args = session.args;
    let Received {
        tap,
        beside,
        pace,
        arrived,
        ..
    } = received;
    if args.report.is_some() && arrived.sentences == 0 {
        let (what, help) = arrived.kind().explain(REPORT_BAUD);
        crate::note!(
            "note: --report: {}",
            [vec![what], help].concat().join("\n  ")
        );
    }
    let (mounting, doubt) = session.mounting(&beside);
    let meta_file = recording::meta_path(&args.output);
    let mut gather = Gather::new(&recording::name_of(&meta_file), mounting.clone());
    scans.iter().for_each(|scan| gather.take(scan));
    let notes = doubt.iter().chain(&gather.notes);
    notes.for_each(|note| crate::note!("note: {note}"));
    if tap.damaged() > 0 || tap.unmatched_count() > 0 {
        crate::note!(
            "note: {}, {} to requests that were not received",
            counted(tap.damaged(), "damaged frame"),
            counted(tap.unmatched_count(), "answer")
        );
    }
    if gather.recorded() == 0 {
        bail!("{}", nothing(&tap, scans.len(), &pace));
    }
    let mut parts = gather.parts();
    let mut unknown = Vec::new();
    for part in &mut parts {
        match part.scans_kind(&mounting, &beside) {
            Some(Kind::Guard) => setup::mark_guard(&mut part.recording),
            Some(Kind::Scans) => {}
            None => unknown.push(&*part.recording.name),
        }
    }
    let doubt = kinds::doubt(&unknown);
    doubt.iter().for_each(|note| crate::note!("note: {note}"));
    for part in &parts {
        let path = args.output.with_file_name(&part.recording.name);
        outputs.write_recording(&path, &part.recording)?;
        write_answers(args, outputs, &path, part, &beside)?;
    }
    session.unfinished.done()?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the path of the file of sentences beside a recording.
fn sentences(path: &Path) -> PathBuf {
    let name = recording::name_of(&recording::meta_path(path));
    path.with_file_name(format!("{name}.sentences"))
}

/// Writes the scanner's sentences and those of replay beside a recording, and prints whether they are equal.
fn write_answers(
    args: &Args,
    outputs: &Outputs,
    path: &Path,
    part: &Part,
    beside: &Beside,
) -> Result<()> {
    let (config, mode, word) = beside::as_scanner(&args.settings.config()?, beside);
    let options = replay::Options {
        motion: Some(mode),
        ..args.settings.options(config)
    };
    let Recording { name, meta, .. } = &part.recording;
    let rows = part.recording.chirps_per_scan();
    let kind = setup::kind(&part.recording)?;
    let mut text = format!(
        "{name}: {} of {}",
        counted(part.times.len(), kinds::name(kind)),
        counted(rows, "row")
    );
    if let (Some(first), Some(last)) = (
        meta.angles_deg.first(),
        meta.angles_deg.get(rows.wrapping_sub(1)),
    ) {
        text += &format!(", {first:.2}° to {last:.2}°");
    }
    let mut kept = String::new();
    if kind == Kind::Guard {
        let sweeps = replay::guarded(&part.recording, &options)?;
        for (sweep, times) in sweeps.iter().zip(&part.times) {
            kept += &format!("{} r {}\n", times.1, sweep.sentence);
        }
        return written(outputs, path, &text, (beside, &word, &kept));
    }
    let answers = replay::answers(&part.recording, &options, |_| ())?;
    let (mut same, mut compared) = (0, 0);
    for (k, answer) in answers.iter().enumerate() {
        let next = part.times.get(k + 1).map(|times| times.1);
        if let Some(said) = beside.answer(part.times[k].1, next) {
            compared += 1;
            match beside::difference(said, &answer.sentences) {
                None => same += 1,
                Some(how) => text += &format!("\n  scan {}: replay gives {how}", k + 1),
            }
        }
        for line in &answer.sentences {
            kept += &format!("{} r {line}\n", part.times[k].1);
        }
    }
    if compared > 0 {
        text += &format!(
            "\n  replay gives the scanner's own sentences for {same} of {}",
            counted(compared, "scan")
        );
    }
    written(outputs, path, &text, (beside, &word, &kept))
}

/// Writes the sentences of the report port and of replay, `kept`, to the file beside a recording, and prints the
/// summary `text`.
fn written(
    outputs: &Outputs,
    path: &Path,
    text: &str,
    (beside, word, kept): (&Beside, &str, &str),
) -> Result<()> {
    let received = beside
        .lines
        .iter()
        .map(|(at, line)| format!("{at} < {line}\n"));
    let lines = format!(
        "0 # ms since the tap began; < at the report port, r by replay --motion {}\n{}{kept}",
        word,
        received.collect::<String>()
    );
    outputs.write(&sentences(path), lines.as_bytes())?;
    emit(&format!(
        "{text}\nnext: cargo sim replay {} --motion {}\n",
        path.display(),
        word
    ));
    Ok(())
}
