//! Lines of the scanner's report port during a tap: its settings, and its answers for comparison with replay.

use std::collections::BTreeMap;

use stairscan::config::{Config, Plane, SweepConfig};
use stairscan::motion::Mode;
use stairscan::report::Sentence;
use stairscan::scanner::Settings;

use super::mounting::Mounting;
use crate::live::Ms;
use crate::recording::{KeyLimits, MirrorSetup};

/// Maximum difference between the read times of two ports, ms, by which an answer may seem to
/// precede its scan's end; scans take longer.
const APART: Ms = 100;

/// The lines of the scanner's report port during a tap, and the settings and answers that they contain.
#[derive(Clone, Debug, Default)]
pub struct Beside {
    /// Each line with its time of arrival, ms since the session began, oldest first.
    pub lines: Vec<(Ms, String)>,
    settings: BTreeMap<String, String>,
    /// Answers: time of arrival of the head, and the answer's lines. Oldest first.
    answers: Vec<(Ms, Vec<String>)>,
    to_come: u8,
}

impl Beside {
    /// Stores a line that arrived at `at`; takes a setting, or a part of an answer, from it.
    pub fn line(&mut self, at: Ms, line: &str) {
        self.lines.push((at, line.to_owned()));
        match Sentence::parse(line) {
            Ok(Sentence::Scan(head)) if head.scan > 0 => {
                self.to_come = head.following();
                self.answers.push((at, vec![line.to_owned()]));
            }
            Ok(Sentence::Step(_) | Sentence::Drop(_) | Sentence::Maybe(_)) if self.to_come > 0 => {
                self.to_come -= 1;
                if let Some((_, answer)) = self.answers.last_mut() {
                    answer.push(line.to_owned());
                }
            }
            Ok(Sentence::Config { key, value }) => {
                self.settings.insert(key.to_owned(), value.to_owned());
            }
            _ => {}
        }
    }

    /// Returns the lines of the scanner's answer to the scan that ended at `end`, if it arrived before the next scan
    /// ended at `next` (both ms since the session began); `None` without such an answer.
    pub fn answer(&self, end: Ms, next: Option<Ms>) -> Option<&[String]> {
        let due = |at: Ms| at + APART >= end && next.is_none_or(|next| at + APART < next);
        let found = self.answers.iter().find(|(at, _)| due(*at));
        found.map(|(_, answer)| &answer[..])
    }

    /// Applies the settings that the scanner has reported to `settings`; those that are unknown or
    /// refused are left out.
    fn apply_reported(&self, settings: &mut Settings) {
        // The angles are valid only in some orders: three passes cover them.
        for _ in 0..3 {
            for (key, value) in &self.settings {
                let known = Settings::key(key);
                let _ = known.map(|key| settings.set(key, value));
            }
        }
    }

    /// Returns the scanner's settings as far as reported (`get`), else the defaults, and whether
    /// all of the mounting's are reported.
    pub fn settings(&self) -> (Settings, bool) {
        let mut settings = Settings::default();
        self.apply_reported(&mut settings);
        let mounting = ["plane", "mirror-offset", "mount-height", "beamwidth"];
        (
            settings,
            mounting.iter().all(|key| self.settings.contains_key(*key)),
        )
    }

    /// Returns the schedules of the angles of full scans and of guard sweeps, and the chirp's duration (µs); `None` for
    /// each that has not been reported.
    fn reported(&self) -> ([Option<SweepConfig>; 2], Option<u32>) {
        let (settings, _) = self.settings();
        let all = |keys: [&str; 3]| keys.iter().all(|key| self.settings.contains_key(*key));
        let full = all(["first-angle", "angle-step", "angle-count"]);
        let guard = all(["guard-first", "guard-last", "guard-step"]);
        let chirp = settings.timing.chirp_duration;
        let us = (self.settings.contains_key("chirp-duration") && chirp > 0).then_some(chirp);
        let sweeps = [
            full.then_some(settings.config.sweep),
            guard.then(|| settings.guard.sweep()),
        ];
        (sweeps, us)
    }
}

/// Mounting values given on the command line.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct MountingArgs {
    /// Mirror centre above the ground, m
    #[arg(long, value_name = "M", value_parser = mount_height)]
    pub mount_height: Option<f64>,
    /// Radar lens to mirror centre, m
    #[arg(long, value_name = "M", value_parser = mirror_offset)]
    pub mirror_offset: Option<f64>,
    /// Full two-sided 3 dB width of the beam, degrees
    #[arg(long, value_name = "DEG", value_parser = beamwidth)]
    pub beamwidth: Option<f64>,
    /// Plane that the mirror sweeps: depth or height
    #[arg(long, value_parser = plane)]
    pub plane: Option<Plane>,
}

/// Returns the number in `text` if a recording can have it.
fn within(text: &str, limits: &KeyLimits) -> Result<f64, String> {
    let value = text.parse().ok();
    value
        .filter(|value| limits.hold(*value))
        .ok_or_else(|| format!("expected {}", limits.expected))
}

fn mount_height(text: &str) -> Result<f64, String> {
    within(text, &MirrorSetup::MOUNT_HEIGHT)
}

fn mirror_offset(text: &str) -> Result<f64, String> {
    within(text, &MirrorSetup::OFFSET)
}

fn beamwidth(text: &str) -> Result<f64, String> {
    within(text, &MirrorSetup::BEAMWIDTH)
}

fn plane(text: &str) -> Result<Plane, String> {
    match text {
        "depth" => Ok(Plane::Depth),
        "height" => Ok(Plane::Height),
        _ => Err("expected depth or height".to_owned()),
    }
}

/// Returns the mounting and a remark on its source: the user's values, else those reported by the scanner, else the
/// defaults.
pub fn mounting(args: &MountingArgs, beside: &Beside) -> (Mounting, Option<String>) {
    let (settings, has_mounting) = beside.settings();
    let mount = &settings.config.mount;
    let metres = |hundredths: i32| f64::from(hundredths) / 1e5;
    let MountingArgs {
        mount_height,
        mirror_offset,
        beamwidth,
        plane,
    } = *args;
    let setup = MirrorSetup {
        offset_m: mirror_offset.unwrap_or(metres(mount.mirror_offset)),
        beamwidth_deg: beamwidth.unwrap_or(f64::from(mount.beamwidth) / 1000.0),
        mount_height_m: mount_height.unwrap_or(metres(mount.mount_height)),
        plane: plane.unwrap_or(mount.plane.first()),
    };
    let all = mount_height.and(mirror_offset).and(beamwidth).is_some() && plane.is_some();
    let note = (!has_mounting && !all).then(|| {
        format!(
            "the link does not transmit the mounting: assumed are plane {}, mirror offset {} m, \
             mount height {} m, beam {}°; give other values with --plane, --mirror-offset, \
             --mount-height, --beamwidth, or read them from the scanner with --report PORT --ask",
            if setup.plane == Plane::Depth {
                "depth"
            } else {
                "height"
            },
            setup.offset_m,
            setup.mount_height_m,
            setup.beamwidth_deg
        )
    });
    let ([sweep, guard], chirp_us) = beside.reported();
    let mounting = Mounting {
        setup,
        sweep,
        guard,
        chirp_us,
    };
    (mounting, note)
}

/// Returns the configuration and motion mode with which replay reproduces the tapped scanner, as far as it has
/// reported them. The mode is also returned as the value of `--motion`.
pub fn as_scanner(base: &Config, beside: &Beside) -> (Config, Mode, String) {
    let mut settings = Settings {
        config: *base,
        ..Settings::default()
    };
    beside.apply_reported(&mut settings);
    let word = settings.get("motion").map(|word| word.as_str().to_owned());
    (settings.config, settings.motion, word.unwrap_or_default())
}

/// Returns the difference between a replayed answer and the scanner's own; `None` if there is none.
pub fn difference(args: &[String], replayed: &[String]) -> Option<&'static str> {
    if args == replayed {
        return None;
    }
    // `SCAN` without number and hash, the other sentences without their scan's number.
    let bare = |lines: &[String]| -> Vec<String> {
        let body = |line: &String| {
            let body = line
                .rsplit_once('*')
                .map_or(line.as_str(), |(body, _)| body);
            let mut fields: Vec<&str> = body.split(',').collect();
            if fields.first() == Some(&"$PSTR") && fields.len() > 3 {
                if fields[1] == "SCAN" {
                    fields.pop();
                }
                fields.remove(2);
            }
            fields.join(",")
        };
        lines.iter().map(body).collect()
    };
    Some(match bare(args) == bare(replayed) {
        true => {
            "the same steps, status and horizon; only the scan's number or the hash of the settings differs"
        }
        false => {
            "another answer: does the scanner have other settings, or did it use earlier scans?"
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mounting_that_no_recording_can_have_is_refused_before_it_is_recorded() {
        assert_eq!(mount_height("0.43"), Ok(0.43));
        assert_eq!(mirror_offset("0"), Ok(0.0));
        let refused = |value: Result<f64, String>| value.unwrap_err();
        assert_eq!(refused(mount_height("43")), "expected 0.01 to 5 metres");
        assert_eq!(refused(mirror_offset("-1")), "expected 0 to 2 metres");
        for text in ["500", "NaN", "wide", ""] {
            assert_eq!(refused(beamwidth(text)), "expected 0.5 to 30 degrees");
        }
    }
}
