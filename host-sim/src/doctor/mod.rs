//! `doctor`: evaluates the replies of a scanner as a list of checks with remedies. Pure: the replies are an
//! argument.
//!
//! | module | what it is |
//! |---|---|
//! | [`check`] | the checks |
//! | [`evidence`] | the replies of the scanner |
//! | [`fixes`] | check and remedy of each reason |

pub mod check;
pub mod evidence;
pub mod fixes;

#[cfg(test)]
mod tests;

use std::fmt::Write as _;

use stairscan::verdict::{Reason, ReasonEffect, Reasons, Status};

use crate::live::talk::Broken;
use crate::setting_file::table;
pub use check::Check;
use evidence::Evidence;

/// The result of a check, from good to bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Nothing is wrong.
    Ok,
    /// Not fitted, according to the settings.
    Absent,
    /// Not checked: no data.
    Unseen,
    /// It works, but needs attention.
    Warning,
    /// It does not work.
    Fault,
}

impl Level {
    /// Returns the text of the list.
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

/// Result of a check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The check.
    pub check: Check,
    /// The result.
    pub level: Level,
    /// The observation.
    pub observed: String,
    /// Remedies, one line each.
    pub fixes: Vec<String>,
}

/// Stage of the start-up that the scanner has reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Reached {
    /// It replies.
    Nothing,
    /// Arithmetic and chip have passed.
    Motor,
    /// The shaft is at home, and the encoder agrees.
    Module,
    /// The module answers.
    Chirps,
    /// The samples of a scan are plausible.
    Samples,
    /// The mirror's own echo is there.
    Mirror,
}

/// Returns the list for a port that cannot be used.
pub fn unusable(broken: &Broken) -> Vec<Finding> {
    let finding = |&check: &Check| match check {
        Check::Port => Finding {
            check,
            level: Level::Fault,
            observed: broken.what.clone(),
            fixes: broken.help.clone(),
        },
        _ => unseen(check, "the port does not speak"),
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

/// Returns the list for the replies of a scanner.
pub fn examine(evidence: &Evidence) -> Vec<Finding> {
    let findings = Check::ALL.iter().map(|&check| of(check, evidence));
    findings.collect()
}

/// Returns the worst result.
pub fn worst(findings: &[Finding]) -> Level {
    let levels = findings.iter().map(|finding| finding.level);
    levels.max().unwrap_or(Level::Ok)
}

/// Returns the list as text.
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
        "{} ok, {} warnings, {} faults, {} could not be seen",
        count(Level::Ok),
        count(Level::Warning),
        count(Level::Fault),
        count(Level::Unseen)
    );
    text
}

/// Returns the level of a reason with this status.
fn level(reason: Reason, status: Status) -> Level {
    let has = |effect| reason.effects().contains(&effect);
    if has(ReasonEffect::Fault) && (status == Status::Fault || !has(ReasonEffect::Doubt)) {
        Level::Fault
    } else if has(ReasonEffect::Doubt) || has(ReasonEffect::Degraded) {
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
    let told: Vec<String> = mine
        .iter()
        .map(|r| format!("{}: {}", r.as_str(), r.meaning()))
        .collect();
    let worst = mine.iter().map(|&reason| level(reason, status)).max();
    if let Some(level) = worst.filter(|_| check != Check::Answer) {
        return Finding {
            check,
            level,
            observed: told.join(" "),
            fixes: mine
                .iter()
                .map(|&reason| fixes::fix(reason).to_owned())
                .collect(),
        };
    }
    let needed = match check {
        Check::Port | Check::Firmware | Check::Answer => Reached::Nothing,
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
        return unseen(check, &why_unseen(evidence));
    }
    match check {
        Check::Firmware => firmware(evidence),
        Check::Seal => seal(evidence),
        Check::Chip => chip(evidence),
        Check::Motor => motor(evidence),
        Check::Home => home(evidence),
        Check::Encoder => encoder(evidence),
        Check::Module => module(evidence),
        Check::MirrorEcho => mirror_echo(evidence),
        Check::Mount => mount(evidence),
        Check::Answer => answer(evidence, &mine, &told),
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

/// Returns the stage reached: a reason shows where the start-up stopped.
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

fn why_unseen(evidence: &Evidence) -> String {
    let faults = evidence
        .reasons()
        .iter()
        .filter(|&r| r.effects().contains(&ReasonEffect::Fault));
    let words: Vec<&str> = faults.map(Reason::as_str).collect();
    match (words.is_empty(), evidence.scan) {
        (false, _) => format!("the scanner does not get so far: {}", words.join(", ")),
        (true, None) => "no scan came".to_owned(),
        (true, Some(_)) => "nothing was said of it".to_owned(),
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
        "{here}; damaged: {} lines here, {damaged} bytes and {refused} lines at the scanner since it booted",
        evidence.damaged
    );
    warning(
        Check::Port,
        counts,
        "Ground wire, cable length, level shifter; a refused line may also have been a mistyped command.",
    )
}

fn firmware(evidence: &Evidence) -> Finding {
    let Some(version) = &evidence.version else {
        return unseen(Check::Firmware, "the scanner did not tell its version");
    };
    let (number, revision) = version.split_once(' ').unwrap_or((version, "unknown"));
    let own = env!("CARGO_PKG_VERSION");
    if number != own {
        let told = format!("version {number}, revision {revision}; this program is {own}");
        return warning(
            Check::Firmware,
            told,
            "`cargo flash` writes the image that belongs to this program.",
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
        _ => unseen(
            Check::Seal,
            "whether the image is sealed is told with a scan",
        ),
    }
}

fn chip(evidence: &Evidence) -> Finding {
    let clock = evidence.clock.as_deref().unwrap_or("not told");
    let told = format!("clock {clock}; supply and memory passed at boot");
    if clock == "hsi-16" {
        let why = format!("{told}; internal-clock is on");
        return warning(
            Check::Chip,
            why,
            "The oscillator is off by up to 8 %: fit the crystal, or keep the scanner warm.",
        );
    }
    good(Check::Chip, told)
}

fn motor(evidence: &Evidence) -> Finding {
    let seen = match evidence.scan {
        Some(scan) if scan.scan > 0 => "homed; echoes change from row to row as the beam turns",
        _ => "homed; whether it turns evenly shows in a scan",
    };
    let driver = match evidence.setting("driver") {
        Some("tmc2209") => "tmc2209 answers on its wire",
        _ => "step-dir: the driver itself is not asked",
    };
    good(Check::Motor, format!("{seen}; {driver}"))
}

fn home(evidence: &Evidence) -> Finding {
    let (angle, check) = (evidence.spoken("home-angle"), evidence.spoken("home-check"));
    good(
        Check::Home,
        format!("found; home-angle {angle}, home-check {check}"),
    )
}

fn encoder(evidence: &Evidence) -> Finding {
    let (kind, home) = (evidence.spoken("encoder"), evidence.spoken("encoder-home"));
    let told = format!("{kind} answers and agrees with the steps; encoder-home {home}");
    if evidence.setting("encoder-home") == Some("-1") {
        return warning(
            Check::Encoder,
            told,
            "`calibrate` sets encoder-home: a home that moved is then found at once.",
        );
    }
    good(Check::Encoder, told)
}

fn module(evidence: &Evidence) -> Finding {
    let [_, _, _, errors] = evidence.counters;
    let spoken = |key| evidence.spoken(key);
    let told = format!(
        "{}: carrier {}, bandwidth {}, {} samples; {errors} requests failed since boot",
        spoken("module"),
        spoken("radar-carrier"),
        spoken("radar-bandwidth"),
        spoken("radar-samples")
    );
    if errors > 0 {
        return warning(
            Check::Module,
            told,
            "A few at boot are the module still starting. Where they grow: cable, ground and termination of the link.",
        );
    }
    good(Check::Module, told)
}

fn mirror_echo(evidence: &Evidence) -> Finding {
    let spoken = |key| evidence.spoken(key);
    let told = format!(
        "where mirror-offset {} puts it; calibrated range {}, level {}",
        spoken("mirror-offset"),
        spoken("mirror-echo"),
        spoken("mirror-level")
    );
    if evidence.setting("mirror-echo") == Some("0") || evidence.setting("mirror-level") == Some("0")
    {
        return warning(
            Check::MirrorEcho,
            told,
            "Calibrate (docs/hardware.md): until then only an error above some 4 cm, and no change of level, is found.",
        );
    }
    good(Check::MirrorEcho, told)
}

fn mount(evidence: &Evidence) -> Finding {
    let spoken = |key| evidence.spoken(key);
    let told = format!(
        "the floor is where mount-height {} says; calibrated {}",
        spoken("mount-height"),
        spoken("calibrated")
    );
    if evidence.setting("calibrated") == Some("0") {
        return warning(
            Check::Mount,
            told,
            "Calibrate on the chair, before a wall at a measured distance (docs/hardware.md).",
        );
    }
    good(Check::Mount, told)
}

/// Checks the whole answer. `mine` are the reasons that concern the scene.
fn answer(evidence: &Evidence, mine: &[Reason], told: &[String]) -> Finding {
    let check = Check::Answer;
    let Some(scan) = evidence.scan else {
        return unseen(check, "no scan came");
    };
    let head = format!("scan {}: {}", scan.scan, scan.status.as_str());
    let observed = match told.is_empty() {
        true => head,
        false => format!("{head}; {}", told.join(" ")),
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
    /// Returns all reported reasons.
    fn reasons(&self) -> Reasons {
        let scan = self.scan.map_or(Reasons::NONE, |scan| scan.reasons);
        // After a scan the earlier reply to `status` is outdated.
        let before = match self.scan {
            Some(scan) if scan.scan > 0 => Reasons::NONE,
            _ => self.status_reasons,
        };
        scan.and(before)
    }

    /// Returns a setting with its unit.
    fn spoken(&self, key: &str) -> String {
        let spoken = self.setting(key).map(|value| match table::row(key) {
            Some(row) => row.spoken(value),
            None => value.to_owned(),
        });
        spoken.unwrap_or_else(|| "not told".to_owned())
    }
}
