//! Checks a command before it is sent.

use stairscan::scanner::Settings;
use stairscan::scanner::command::{self, Command, MAX_COMMAND, framed};

/// Begins the note on a command that is probably wrong; a second Enter sends it nevertheless.
const CONFIRM: &str = "Press Enter again to send it, although";

/// Result of checking a typed command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Checked {
    /// The line is sent unchanged.
    Send(String),
    /// The next Enter sends this line, which replaces the typed one.
    Offer {
        /// Line that the next Enter sends.
        line: String,
        /// Reason why the typed line was not sent at once.
        why: String,
    },
}

/// Checks the typed command as the scanner's own parser does.
pub fn check(typed: &str) -> Checked {
    let typed = typed.trim();
    let offer = |line: &str, why: String| Checked::Offer {
        line: line.to_owned(),
        why,
    };
    if typed.len() > MAX_COMMAND {
        let why =
            format!("{CONFIRM} the line is too long: expected at most {MAX_COMMAND} characters");
        return offer(typed, why);
    }
    let parsed = match command::parse(typed) {
        Ok(parsed) => parsed,
        Err(bad) => {
            let whose = if bad.command == "-" { "" } else { bad.command };
            let (field, expected) = (bad.error.field, bad.error.expected);
            let why = format!(
                "{CONFIRM} it is wrong: {}: expected {expected}",
                format!("{whose} {field}").trim_start()
            );
            return offer(typed, why);
        }
    };
    let refusal = refusal(&parsed);
    let line = match parsed {
        _ if command::is_framed(typed) => typed.to_owned(),
        Command::Set(key, value) => sentence(&["set", key, value]),
        Command::Save => sentence(&["save"]),
        Command::Update => sentence(&["update"]),
        Command::Calibrate(task) => {
            let (wall, date) = (task.wall_mm.to_string(), task.date.to_string());
            sentence(&["calibrate", &wall, &date])
        }
        _ => typed.to_owned(),
    };
    match refusal {
        Some(refusal) => offer(&line, format!("{CONFIRM} {refusal}")),
        None if line != typed => {
            let word = parsed.word();
            offer(
                &line,
                format!("{word} is accepted only as a sentence with its CRC: Enter sends this one"),
            )
        }
        None => Checked::Send(line),
    }
}

/// Returns the sentence of a command with its CRC, without its line end.
fn sentence(words: &[&str]) -> String {
    framed(words).trim_end().to_owned()
}

/// Returns why a scanner with default settings would refuse a value. A scanner with other settings may
/// accept it.
fn refusal(command: &Command<'_>) -> Option<String> {
    let Command::Set(key, value) = command else {
        return None;
    };
    let error = Settings::default().set(key, value).err()?;
    let (field, expected) = (error.field, error.expected);
    Some(format!(
        "default settings would refuse it: {field}: expected {expected}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offered(typed: &str) -> (String, String) {
        match check(typed) {
            Checked::Offer { line, why } => (line, why),
            Checked::Send(line) => panic!("{line} is sent at once"),
        }
    }

    #[test]
    fn plain_commands_go_out_as_typed() {
        for line in [
            "scan", "start", "stop", "status", "version", "get", "get seed", "reset",
        ] {
            assert_eq!(check(line), Checked::Send(line.to_owned()));
        }
        assert_eq!(check("  scan "), Checked::Send("scan".to_owned()));
    }

    #[test]
    fn what_changes_something_is_offered_with_its_crc() {
        let (line, why) = offered("set seed 7");
        assert_eq!(line, "$PSTC,set,seed,7*352B37A8");
        assert!(why.contains("Enter sends this one"), "{why}");
        // The proposed line itself is sent.
        assert_eq!(check(&line), Checked::Send(line));
        for typed in [
            "save",
            "update",
            "calibrate 1500 20261122",
            "set,mount-height,41000",
        ] {
            let (line, _) = offered(typed);
            assert!(
                command::is_framed(&line) && command::parse(&line).is_ok(),
                "{line}"
            );
        }
    }

    #[test]
    fn bad_lines_are_explained_by_field() {
        for (typed, words) in [
            ("scna", "command: expected start stop"),
            ("get sead", "get key: expected a key listed by get"),
            ("set seed", "set seed: expected a value"),
            ("scan now", "scan arguments: expected no further arguments"),
            ("$PSTC,set,seed,7*00000000", "crc: expected"),
            ("calibrate 1500", "calibrate date: expected"),
            ("set seed x", "refuse it: seed"),
            ("set plane sideways", "refuse it: plane: expected"),
            (&"x".repeat(97), "the line is too long: expected at most 96"),
        ] {
            let (_, why) = offered(typed);
            assert!(why.contains(words), "{typed}: {why}");
        }
    }
}
