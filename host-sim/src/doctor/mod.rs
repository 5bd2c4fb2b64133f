//! `doctor`: evaluates the replies of a scanner as a list of checks with remedies. Pure: the replies are an
//! argument.
//!
//! | module | what it is |
//! |---|---|
//! | [`check`] | the checks |
//! | [`evidence`] | the replies of the scanner |
//! | [`fixes`] | check and remedy of each reason |
//! | [`option_bytes`] | the chip's option bytes, and what to set in them |

pub mod check;
pub mod evidence;
pub mod fixes;
pub mod option_bytes;

#[cfg(test)]
mod tests;

use std::fmt::Write as _;

use stairscan::verdict::{Reason, ReasonEffect, Reasons, Status};

use crate::counted::counted;
use crate::live::talk::PortFault;
use crate::setting_file::table;
pub use check::Check;
use evidence::Evidence;

/// The result of a check, from good to bad; results compare in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// The check found no fault.
    Ok,
    /// The part is not fitted, according to the settings.
    Absent,
    /// Not checked, because there are no data.
    Unseen,
    /// The part works, but needs attention.
    Warning,
    /// The part does not work.
    Fault,
}

impl Level {
    /// Returns the result's text in the list.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Absent => "none fitted",
            Self::Unseen => "not seen",
            Self::Warning => "warning",
            Self::Fault => "FAULT",
        }
    }
}

/// Result of a check, with observation and remedies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The check that was made.
    pub check: Check,
    /// Result of the check.
    pub level: Level,
    /// Observation on which the result is based, as text.
    pub observed: String,
    /// Remedies, one line each; empty if none is needed.
    pub fixes: Vec<String>,
}

/// Stage of the start-up that the scanner has reached, by the checks that have passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Reached {
    /// The scanner replies, and nothing has passed.
    Nothing,
    /// Arithmetic and chip have passed; the motor is next.
    Motor,
    /// The shaft is at home, and the encoder agrees; the radar module is next.
    Module,
    /// The radar module answers; its chirps are next.
    Chirps,
    /// The samples of a scan are plausible; the mirror's echo is next.
    Samples,
    /// The mirror's own echo is there: everything has been checked.
    Mirror,
}

/// Returns the results of all checks for a port that cannot be used.
pub fn unusable(broken: &PortFault) -> Vec<Finding> {
    let finding = |&check: &Check| match check {
        Check::Port => Finding {
            check,
            level: Level::Fault,
            observed: broken.what.clone(),
            fixes: broken.help.clone(),
        },
        _ => unseen(check, "no sentences at the port"),
    };
    Check::ALL.iter().map(finding).collect()
}

fn unseen(check: Check, why: &str) -> Finding {
    Finding {
        check,
        level: Level::Unseen,
        observed: why.to_owned(),
        fixes: Vec::new(),
    }
}

/// Returns the results of all checks for the replies of a scanner, in the order of the list.
pub fn examine(evidence: &Evidence) -> Vec<Finding> {
    let findings = Check::ALL.iter().map(|&check| of(check, evidence));
    findings.collect()
}

/// Returns the worst of several results.
pub fn worst(findings: &[Finding]) -> Level {
    let levels = findings.iter().map(|finding| finding.level);
    levels.max().unwrap_or(Level::Ok)
}

/// Returns the list of results as text.
pub fn text(findings: &[Finding]) -> String {
    let mut text = String::new();
    for Finding {
        check,
        level,
        observed,
        fixes,
    } in findings
    {
        let _ = writeln!(
            text,
            "{:<13} {:<12} {observed}",
            check.as_str(),
            level.as_str()
        );
        for fix in fixes {
            let _ = writeln!(text, "{:<26} -> {fix}", "");
        }
    }
    let count = |level| {
        findings
            .iter()
            .filter(|finding| finding.level == level)
            .count()
    };
    let _ = writeln!(
        text,
        "{} ok, {}, {}, {} not seen",
        count(Level::Ok),
        counted(count(Level::Warning), "warning"),
        counted(count(Level::Fault), "fault"),
        count(Level::Unseen)
    );
    text
}

/// Returns the result of a check in which `reason` is reported, by an answer with the status `status`.
fn level(reason: Reason, status: Status) -> Level {
    let has = |effect| reason.effects().contains(&effect);
    if has(ReasonEffect::Fault) && (status == Status::Fault || !has(ReasonEffect::InstrumentFault))
    {
        Level::Fault
    } else if has(ReasonEffect::InstrumentFault) || has(ReasonEffect::Degraded) {
        Level::Warning
    } else {
        Level::Ok
    }
}

fn of(check: Check, evidence: &Evidence) -> Finding {
    if check == Check::Port {
        return port(evidence);
    }
    let status = evidence.scan.map_or(Status::Fault, |scan| scan.status);
    let mine: Vec<Reason> = evidence
        .reasons()
        .iter()
        .filter(|&r| fixes::check(r) == check)
        .collect();
    let reasons: Vec<String> = mine
        .iter()
        .map(|r| format!("{}: {}", r.as_str(), r.meaning()))
        .collect();
    let worst = mine.iter().map(|&reason| level(reason, status)).max();
    if let Some(level) = worst.filter(|_| check != Check::Answer) {
        return Finding {
            check,
            level,
            observed: reasons.join(" "),
            fixes: mine
                .iter()
                .map(|&reason| fixes::fix(reason).to_owned())
                .collect(),
        };
    }
    let needed = match check {
        Check::Port | Check::Firmware | Check::OptionBytes | Check::Answer => Reached::Nothing,
        Check::Seal | Check::Chip => Reached::Motor,
        Check::Motor | Check::Home | Check::Encoder => Reached::Module,
        Check::Module => Reached::Chirps,
        Check::Signal => Reached::Samples,
        Check::MirrorEcho | Check::Mount => Reached::Mirror,
    };
    let reached = reached(evidence);
    if check == Check::Encoder && evidence.setting("encoder") == Some("none") {
        return Finding {
            level: Level::Absent,
            ..unseen(
                check,
                "encoder is none: lost steps show at the home switch (home-check) or in the echoes only",
            )
        };
    }
    if reached < needed {
        return unseen(check, &missing_evidence(evidence));
    }
    match check {
        Check::Firmware => firmware(evidence),
        Check::Seal => seal(evidence),
        Check::Chip => chip(evidence),
        Check::OptionBytes => option_bytes(evidence),
        Check::Motor => motor(evidence),
        Check::Home => home(evidence),
        Check::Encoder => encoder(evidence),
        Check::Module => module(evidence),
        Check::MirrorEcho => mirror_echo(evidence),
        Check::Mount => mount(evidence),
        Check::Answer => answer(evidence, &mine, &reasons),
        Check::Signal => good(
            check,
            "the samples of a whole scan are plausible".to_owned(),
        ),
        Check::Port => port(evidence),
    }
}

fn good(check: Check, observed: String) -> Finding {
    Finding {
        check,
        level: Level::Ok,
        observed,
        fixes: Vec::new(),
    }
}

fn warning(check: Check, observed: String, fix: &str) -> Finding {
    Finding {
        check,
        level: Level::Warning,
        observed,
        fixes: vec![fix.to_owned()],
    }
}

/// Returns the stage of the start-up that the scanner has reached: a reason shows where it stopped.
fn reached(evidence: &Evidence) -> Reached {
    let reasons = evidence.reasons();
    let stopped = |checks: &[Check]| {
        let faults = reasons
            .iter()
            .filter(|&r| r.effects().contains(&ReasonEffect::Fault));
        let status = evidence.scan.map_or(Status::Fault, |scan| scan.status);
        status == Status::Fault
            && faults
                .into_iter()
                .any(|r| checks.contains(&fixes::check(r)))
    };
    let scanned = evidence.scan.is_some_and(|scan| scan.scan > 0);
    if evidence.scan.is_none() && !evidence.passed && reasons.is_empty() {
        return Reached::Nothing;
    }
    if stopped(&[Check::Firmware, Check::Seal, Check::Chip]) && !scanned {
        return Reached::Nothing;
    }
    if stopped(&[Check::Motor, Check::Home, Check::Encoder]) {
        return Reached::Motor;
    }
    if stopped(&[Check::Module]) {
        return Reached::Module;
    }
    if stopped(&[Check::Signal]) || !scanned {
        return Reached::Chirps;
    }
    match stopped(&[Check::MirrorEcho]) {
        true => Reached::Samples,
        false => Reached::Mirror,
    }
}

fn missing_evidence(evidence: &Evidence) -> String {
    let faults = evidence
        .reasons()
        .iter()
        .filter(|&r| r.effects().contains(&ReasonEffect::Fault));
    let words: Vec<&str> = faults.map(Reason::as_str).collect();
    match (words.is_empty(), evidence.scan) {
        (false, _) => format!(
            "the scanner does not reach this check: {}",
            words.join(", ")
        ),
        (true, None) => "no scan came".to_owned(),
        (true, Some(_)) => "not reported".to_owned(),
    }
}

fn port(evidence: &Evidence) -> Finding {
    let Evidence { port, baud, .. } = evidence;
    if let Some(broken) = &evidence.broken {
        return Finding {
            check: Check::Port,
            level: Level::Fault,
            observed: broken.what.clone(),
            fixes: broken.help.clone(),
        };
    }
    let [_, refused, damaged, _] = evidence.counters;
    let here = format!("{port}, {baud} baud: sentences come and commands are answered");
    if evidence.damaged + u64::from(damaged) + u64::from(refused) == 0 {
        return good(Check::Port, here);
    }
    let counts = format!(
        "{here}; damaged: {} here, {} and {} at the scanner since it booted",
        counted(evidence.damaged, "line"),
        counted(damaged, "byte"),
        counted(refused, "line")
    );
    warning(
        Check::Port,
        counts,
        "Ground wire, cable length, level shifter; a refused line may also have been a mistyped command.",
    )
}

fn firmware(evidence: &Evidence) -> Finding {
    let Some(version) = &evidence.version else {
        return unseen(Check::Firmware, "the scanner did not report its version");
    };
    let (number, revision) = version.split_once(' ').unwrap_or((version, "unknown"));
    let own = env!("CARGO_PKG_VERSION");
    if number != own {
        let text = format!("version {number}, revision {revision}; this program is {own}");
        return warning(
            Check::Firmware,
            text,
            "`cargo board` writes the image that belongs to this program.",
        );
    }
    let other = match revision == stairscan::REVISION {
        true => "",
        false => " (not the revision of this program)",
    };
    good(
        Check::Firmware,
        format!("version {number}, revision {revision}{other}"),
    )
}

fn seal(evidence: &Evidence) -> Finding {
    // A scan reports an unsealed image, a failed self-test a damaged one.
    match evidence.scan {
        Some(scan) if scan.scan > 0 => good(Check::Seal, "the image is what was built".to_owned()),
        _ => unseen(Check::Seal, "the seal is reported with a scan"),
    }
}

fn chip(evidence: &Evidence) -> Finding {
    let clock = evidence.clock.as_deref().unwrap_or("not reported");
    let text = format!("clock {clock}; supply and memory passed at boot");
    if clock == "hsi-16" {
        let why = format!("{text}; internal-clock is on");
        return warning(
            Check::Chip,
            why,
            "The oscillator is off by up to 8 %: fit the crystal, or keep the scanner warm.",
        );
    }
    good(Check::Chip, text)
}

fn option_bytes(evidence: &Evidence) -> Finding {
    let check = Check::OptionBytes;
    let Some(bytes) = evidence.option_bytes else {
        return unseen(check, "unknown: an older firmware, or the emulator");
    };
    Finding {
        check,
        level: match option_bytes::is_safe(bytes) {
            true => Level::Ok,
            false => Level::Warning,
        },
        observed: option_bytes::text(Some(bytes)),
        fixes: option_bytes::fixes(bytes),
    }
}

fn motor(evidence: &Evidence) -> Finding {
    let seen = match evidence.scan {
        Some(scan) if scan.scan > 0 => "homed; echoes change from row to row as the beam turns",
        _ => "homed; whether it turns evenly shows in a scan",
    };
    let driver = match evidence.setting("driver") {
        Some("tmc2209") => "tmc2209 answers on its wire",
        _ => "step-dir: the driver itself is not queried",
    };
    good(Check::Motor, format!("{seen}; {driver}"))
}

fn home(evidence: &Evidence) -> Finding {
    let (angle, check) = (
        evidence.with_unit("home-angle"),
        evidence.with_unit("home-check"),
    );
    good(
        Check::Home,
        format!("found; home-angle {angle}, home-check {check}"),
    )
}

fn encoder(evidence: &Evidence) -> Finding {
    let (kind, home) = (
        evidence.with_unit("encoder"),
        evidence.with_unit("encoder-home"),
    );
    let text = format!("{kind} answers and agrees with the steps; encoder-home {home}");
    if evidence.setting("encoder-home") == Some("-1") {
        return warning(
            Check::Encoder,
            text,
            "`calibrate` sets encoder-home: a home that moved is then found at once.",
        );
    }
    good(Check::Encoder, text)
}

fn module(evidence: &Evidence) -> Finding {
    let [_, _, _, errors] = evidence.counters;
    let with_unit = |key| evidence.with_unit(key);
    let text = format!(
        "{}: carrier {}, bandwidth {}, {} samples; {errors} requests failed since boot",
        with_unit("module"),
        with_unit("radar-carrier"),
        with_unit("radar-bandwidth"),
        with_unit("radar-samples")
    );
    if errors > 0 {
        return warning(
            Check::Module,
            text,
            "A few at boot are the module still starting. Where they grow: cable, ground and termination of the link.",
        );
    }
    good(Check::Module, text)
}

fn mirror_echo(evidence: &Evidence) -> Finding {
    let with_unit = |key| evidence.with_unit(key);
    let text = format!(
        "at mirror-offset {}; calibrated range {}, level {}",
        with_unit("mirror-offset"),
        with_unit("mirror-echo"),
        with_unit("mirror-level")
    );
    if evidence.setting("mirror-echo") == Some("0") || evidence.setting("mirror-level") == Some("0")
    {
        return warning(
            Check::MirrorEcho,
            text,
            "Calibrate (docs/user/hardware.md): until then only an error above some 4 cm, and no change of level, is found.",
        );
    }
    good(Check::MirrorEcho, text)
}

fn mount(evidence: &Evidence) -> Finding {
    let with_unit = |key| evidence.with_unit(key);
    let text = format!(
        "the ground is at mount-height {}; calibrated {}",
        with_unit("mount-height"),
        with_unit("calibrated")
    );
    if evidence.setting("calibrated") == Some("0") {
        return warning(
            Check::Mount,
            text,
            "Calibrate on the chair, before a wall at a measured distance (docs/user/hardware.md).",
        );
    }
    good(Check::Mount, text)
}

/// Returns the result of [`Check::Answer`], the status of the last scan's answer. `mine` are the reported reasons that
/// belong to this check, `reasons` their texts.
fn answer(evidence: &Evidence, mine: &[Reason], reasons: &[String]) -> Finding {
    let check = Check::Answer;
    let Some(scan) = evidence.scan else {
        return unseen(check, "no scan came");
    };
    let head = format!("scan {}: {}", scan.scan, scan.status.as_str());
    let observed = match reasons.is_empty() {
        true => head,
        false => format!("{head}; {}", reasons.join(" ")),
    };
    let level = match scan.status {
        Status::Ok => Level::Ok,
        Status::Degraded => Level::Warning,
        Status::Fault => Level::Fault,
    };
    let fixes = mine
        .iter()
        .filter(|&&reason| self::level(reason, scan.status) > Level::Ok);
    Finding {
        check,
        level,
        observed,
        fixes: fixes.map(|&reason| fixes::fix(reason).to_owned()).collect(),
    }
}

impl Evidence {
    /// Returns all reported reasons: those of the last scan, and before any scan those in the reply
    /// to `status`.
    fn reasons(&self) -> Reasons {
        let scan = self.scan.map_or(Reasons::NONE, |scan| scan.reasons);
        // After a scan the earlier reply to `status` is outdated.
        let before = match self.scan {
            Some(scan) if scan.scan > 0 => Reasons::NONE,
            _ => self.status_reasons,
        };
        scan.and(before)
    }

    /// Returns a setting with its unit, as text.
    fn with_unit(&self, key: &str) -> String {
        let with_unit = self.setting(key).map(|value| match table::row(key) {
            Some(row) => row.with_unit(value),
            None => value.to_owned(),
        });
        with_unit.unwrap_or_else(|| "not reported".to_owned())
    }
}
