//! Formats the Rust parsers' result for a line, in the format of `controller/test/verdict.c`.

use stairscan::answer::Direction;
use stairscan::config::Plane;
use stairscan::motion::Reading;
use stairscan::report::{
    BootLine, CrashSite, DropLine, GuardLine, LiveLine, MaybeLine, ParseError, ScanLine, Sentence,
    StepLine, Tenths, motion,
};
use stairscan::scanner::command::{
    self, CalibrationRequest, Command, LineReader, ParserEvent, framed,
};
use stairscan::verdict::{HazardKind, Reasons, Status};

use super::Way;

/// Returns the verdict on a line and, if it is valid, the line written again.
pub fn verdict(way: Way, line: &[u8]) -> String {
    match way {
        Way::Report => report(line),
        Way::Command => command(line),
    }
}

fn report(line: &[u8]) -> String {
    // A sentence contains only text.
    let parsed = str::from_utf8(line).map_or(Err(ParseError::Frame), Sentence::parse);
    match parsed {
        Ok(sentence) => format!("{} => {}", fields(&sentence), sentence.write().trim_end()),
        Err(ParseError::Frame) => "bad frame".to_owned(),
        Err(ParseError::Crc) => "bad crc".to_owned(),
        Err(ParseError::Field(field)) => format!("bad field {field}"),
    }
}

fn fields(sentence: &Sentence<'_>) -> String {
    match *sentence {
        Sentence::Scan(scan) => of_scan(&scan),
        Sentence::Step(step) => of_step(&step),
        Sentence::Drop(drop) => of_drop(&drop),
        Sentence::Maybe(maybe) => of_maybe(&maybe),
        Sentence::Guard(guard) => of_guard(&guard),
        Sentence::Boot(boot) => of_boot(&boot),
        Sentence::Crash(crash) => format!(
            "CRASH cause=[{}] boot={}{}",
            crash.cause,
            crash.boot,
            of_crash(&crash.site)
        ),
        Sentence::State {
            state,
            clock,
            scans,
            estimator,
            reasons,
            motion,
            motion_faults,
            settings,
        } => format!(
            "STAT state=[{state}] clock=[{clock}] scans={scans} estimator=[{estimator}] reasons={} \
             motion=[{motion}] motion-faults={motion_faults} settings={settings}",
            words(reasons)
        ),
        Sentence::Live(live) => of_live(&live),
        Sentence::Config { key, value } => format!("CONF key=[{key}] value=[{value}]"),
        Sentence::Done { command } => format!("DONE command=[{command}]"),
        Sentence::Fail {
            command,
            field,
            expected,
        } => format!("FAIL command=[{command}] field=[{field}] expected=[{expected}]"),
        Sentence::Halt { reason } => format!("HALT reason=<{}>", reason.as_str()),
    }
}

/// Returns the index of a status in the C header's list.
fn place(status: Status) -> u8 {
    match status {
        Status::Ok => 0,
        Status::Degraded => 1,
        Status::Fault => 2,
    }
}

fn of_guard(guard: &GuardLine) -> String {
    let ending = HazardKind::ALL.iter().position(|&e| e == guard.hazard);
    format!(
        "GUARD sweep={} status={} free={} ending={} confidence={} reasons={}",
        guard.sweep,
        place(guard.status),
        tenths(guard.free),
        ending.unwrap_or(HazardKind::ALL.len()),
        guard.confidence,
        words(guard.reasons)
    )
}

fn of_boot(boot: &BootLine<'_>) -> String {
    let [first, second, third] = boot.serial;
    format!(
        "BOOT version=[{}] revision=[{}] reset=[{}] clock=[{}] boots={} settings={} \
         serial={first}/{second}/{third} second-memory=[{}] option-bytes={}{}",
        boot.version,
        boot.revision,
        boot.reset,
        boot.clock,
        boot.boots,
        boot.settings,
        boot.second_memory,
        optional(boot.option_bytes),
        of_crash(&boot.crash)
    )
}

fn of_crash(site: &CrashSite) -> String {
    format!(
        " pc={} lr={} cfsr={} address={} place={}",
        optional(site.pc),
        optional(site.lr),
        optional(site.cfsr),
        optional(site.address),
        optional(site.place)
    )
}

fn of_scan(scan: &ScanLine) -> String {
    let status = place(scan.status);
    let direction = match scan.direction {
        Direction::None => 0,
        Direction::Up => 1,
        Direction::Down => 2,
    };
    let plane = match scan.plane {
        None => 0,
        Some(Plane::Depth) => 1,
        Some(Plane::Height) => 2,
    };
    format!(
        "SCAN scan={} status={status} direction={direction} steps={} lost={} reasons={} horizon={} \
         confidence={} maybes={} settings={} drops={} plane={plane} from={} slope={}",
        scan.scan,
        scan.steps,
        scan.lost_rows,
        words(scan.reasons),
        tenths(scan.horizon),
        optional(scan.confidence),
        scan.possible_steps,
        scan.settings,
        scan.drops,
        tenths(scan.ground.map(|ground| ground.from)),
        tenths(scan.ground.map(|ground| ground.rise)),
    )
}

fn of_step(step: &StepLine) -> String {
    format!(
        "STEP scan={} index={} count={} distance={} height={} tread={} riser={} distance-sigma={} \
         height-sigma={} quality={}",
        step.scan,
        step.index,
        step.count,
        step.distance.0,
        step.height.0,
        tenths(step.tread),
        tenths(step.riser),
        step.distance_sigma.0,
        step.height_sigma.0,
        step.quality
    )
}

fn of_drop(drop: &DropLine) -> String {
    format!(
        "DROP scan={} distance={} distance-sigma={} depth={} probability={}",
        drop.scan,
        drop.distance.0,
        drop.distance_sigma.0,
        tenths(drop.depth),
        drop.probability
    )
}

fn of_maybe(maybe: &MaybeLine) -> String {
    format!(
        "MAYBE scan={} index={} count={} distance={} height={} probability={}",
        maybe.scan, maybe.index, maybe.count, maybe.distance.0, maybe.height.0, maybe.probability
    )
}

fn of_live(live: &LiveLine<'_>) -> String {
    format!(
        "LIVE state=[{}] scan={} uptime={} age={} motion=[{}] motion-faults={} refused={} port-errors={} \
         link-errors={}",
        live.state,
        live.scan,
        live.uptime_ms,
        optional(live.age_ms),
        live.motion,
        live.motion_faults,
        live.refused,
        live.port_errors,
        live.link_errors
    )
}

fn words(reasons: Reasons) -> String {
    let word = |reason: stairscan::verdict::Reason| format!("<{}>", reason.as_str());
    reasons.iter().map(word).collect()
}

fn optional(value: Option<impl ToString>) -> String {
    value.map_or("-".to_owned(), |value| value.to_string())
}

fn tenths(value: Option<Tenths>) -> String {
    optional(value.map(|Tenths(tenths)| tenths))
}

/// Returns the line as the scanner's own reader delivers it; `None` if it delivers nothing or an
/// error.
fn read(line: &[u8]) -> Option<String> {
    let mut reader = LineReader::default();
    let bad = |input| matches!(input, ParserEvent::Bad(_));
    // A line end within the line would end it and begin another one: here it counts as damage.
    let ends = line.iter().any(|byte| matches!(byte, b'\r' | b'\n'));
    if ends || line.iter().any(|&byte| bad(reader.push(byte))) {
        return None;
    }
    let _ = reader.push(b'\n');
    Some(reader.line().to_owned())
}

fn command(line: &[u8]) -> String {
    let Some(line) = read(line) else {
        return "bad - line".to_owned();
    };
    let command = match command::parse(&line) {
        Ok(command) => command,
        Err(bad) => return format!("bad {} {}", bad.command, bad.error.field),
    };
    let word = command.word();
    let (fields, again) = match command {
        Command::GetAll => (" key=[] value=[]".to_owned(), framed(&[word])),
        Command::Get(key) => of_get(key),
        Command::Measure(measure) => of_get(measure.key()),
        Command::Set(key, value) => (
            format!(" key=[{key}] value=[{value}]"),
            framed(&[word, key, value]),
        ),
        Command::Guard(on) | Command::Watch(on) => {
            let switch = if on { "on" } else { "off" };
            (format!(" value=[{switch}]"), framed(&[word, switch]))
        }
        Command::Calibrate(CalibrationRequest { wall_mm, date }) => (
            format!(" wall={wall_mm} date={date}"),
            framed(&[word, &wall_mm.to_string(), &date.to_string()]),
        ),
        Command::Motion(reading) => (of_motion(&reading), motion::write(&reading)),
        _ => (String::new(), framed(&[word])),
    };
    format!("{word}{fields} => {}", again.trim_end())
}

fn of_get(key: &str) -> (String, stairscan::report::Line) {
    (format!(" key=[{key}] value=[]"), framed(&["get", key]))
}

fn of_motion(reading: &Reading) -> String {
    format!(
        " sequence={} travel={} pitch={}",
        reading.sequence,
        reading.travel,
        optional(reading.pitch)
    )
}
