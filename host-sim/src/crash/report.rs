//! The last crash in a scanner's sentences.

use crate::counted::counted;
use anyhow::{Result, bail};
use stairscan::report::{CrashSite, Sentence};

use crate::live::arrived::Arrived;
use crate::live::lines::Splitter;

/// A crash, as `BOOT` or `CRASH` reports it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// Cause of the reset, such as `panic`.
    pub cause: String,
    /// Number of the boot since power-on that crashed.
    pub boot: u32,
    /// Git revision of the image; `None` if no sentence tells it.
    pub revision: Option<String>,
    /// Place of the crash.
    pub site: CrashSite,
}

/// Returns the last crash in the bytes of a log: sentences, with or without a time before each.
///
/// # Errors
/// The log contains no crash; the message says what was found instead.
pub fn last(log: &[u8]) -> Result<Report> {
    let mut revision: Option<String> = None;
    let (mut found, mut sentences, mut none) = (None, 0, false);
    let mut arrived = Arrived::default();
    for line in Splitter::default().push(&[log, b"\n"].concat()) {
        arrived.line(&line);
        let Ok(sentence) = Sentence::parse(&line) else {
            continue;
        };
        sentences += 1;
        match sentence {
            Sentence::Boot(boot) => {
                revision = Some(boot.revision.to_owned());
                if boot.crash.cfsr.is_some() {
                    found = Some(Report {
                        cause: boot.reset.to_owned(),
                        boot: boot.boots.saturating_sub(1),
                        revision: revision.clone(),
                        site: boot.crash,
                    });
                }
            }
            Sentence::Config {
                key: "version",
                value,
            } => revision = value.rsplit_once(' ').map(|(_, last)| last.to_owned()),
            Sentence::Crash(crash) if crash.boot == 0 => none = true,
            Sentence::Crash(crash) => {
                found = Some(Report {
                    cause: crash.cause.to_owned(),
                    boot: crash.boot,
                    revision: revision.clone(),
                    site: crash.site,
                });
            }
            _ => {}
        }
    }
    match found {
        Some(report) => Ok(report),
        None if none => bail!("no crash since power-on: the scanner answers `crash?` with none"),
        None if sentences == 0 => bail!("{}", arrived.instead_of_sentences()),
        None => bail!(
            "no crash in {}: expected BOOT after a crash, or CRASH, the answer to `crash?`",
            counted(sentences, "sentence")
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stairscan::report::{BootLine, CrashLine};

    const SITE: CrashSite = CrashSite {
        pc: Some(0x0802_1234),
        cfsr: Some(0),
        ..CrashSite::NONE
    };

    fn boot(crash: CrashSite) -> String {
        let line = Sentence::Boot(BootLine {
            revision: "abc",
            reset: "panic",
            boots: 4,
            crash,
            ..BootLine::default()
        });
        format!("12:00:01.5 {}", line.write().trim_end())
    }

    #[test]
    fn the_last_crash_counts_with_the_revision_before_it() {
        let crash = Sentence::Crash(CrashLine {
            cause: "memory-fault",
            boot: 7,
            site: SITE,
        });
        let crash = crash.write();
        let lines = ["noise", &boot(SITE), &boot(CrashSite::NONE)].join("\n");
        let report = last(lines.as_bytes()).unwrap();
        assert_eq!((report.cause.as_str(), report.boot), ("panic", 3));
        assert_eq!(report.revision.as_deref(), Some("abc"));
        let report = last(format!("{}\r{crash}", boot(CrashSite::NONE)).as_bytes()).unwrap();
        assert_eq!((report.cause.as_str(), report.boot), ("memory-fault", 7));
        assert_eq!(report.revision.as_deref(), Some("abc"));
        assert_eq!(last(crash.as_bytes()).unwrap().revision, None);
    }

    #[test]
    fn what_is_missing_is_named() {
        let none = Sentence::Crash(CrashLine::NONE).write();
        for (lines, part) in [
            (
                String::new(),
                "no sentence of a scanner with a right CRC-32: it is empty",
            ),
            (
                "$PSTR,BOOT,1*00000000".to_owned(),
                "its sentences are damaged",
            ),
            (boot(CrashSite::NONE), "no crash in 1 sentence:"),
            (none.to_string(), "with none"),
        ] {
            let error = last(lines.as_bytes()).unwrap_err();
            assert!(error.to_string().contains(part), "{error}");
        }
    }
}
