//! The command line and its history.

use super::offer::{self, Checked};

/// Maximum number of typed lines in the history.
const MAX_HISTORY: usize = 500;

/// A key that edits the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// Inserts a character.
    Char(char),
    /// Deletes the character before the cursor.
    Backspace,
    /// Deletes the character at the cursor.
    Delete,
    /// Moves the cursor left.
    Left,
    /// Moves the cursor right.
    Right,
    /// Moves the cursor to the beginning of the line.
    Home,
    /// Moves the cursor to the end of the line.
    End,
    /// Shows the previous line of the history.
    Up,
    /// Shows the next line of the history.
    Down,
    /// Deletes the line.
    Clear,
}

/// A command to this program instead of the scanner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Own {
    /// Shows the help.
    Help,
    /// Ends the session.
    Quit,
}

/// Lines of the help, which stand in place of the last sentences until it is closed. All but the last are commands to the
/// scanner, up to a colon; a test compares them with the scanner's own list.
pub const HELP: [&str; 6] = [
    "scan | start | stop | reset: one scan, continuous, stop, clear history",
    "guard on|off | watch on|off: sweeps of the free distance, full scans",
    "status | version | selftest | crash? | crash-clear: state, last crash",
    "get [KEY] | set KEY VALUE | save: settings (docs/user/hardware.md)",
    "calibrate WALL_MM YYYYMMDD | update: mounting, to the boot loader",
    "PageUp, PageDown: older, newer; ?, Esc, q: this text, close it, end",
];

/// The command line with its history. Only ASCII can be typed: commands contain nothing else.
#[derive(Clone, Debug, Default)]
pub struct Prompt {
    /// Text of the line.
    pub text: String,
    /// Index of the character after the cursor; the text's length at its end.
    pub cursor: usize,
    /// Note below the line, such as the reason why it was not sent; empty without one.
    pub note: String,
    /// Whether the help is shown.
    pub helping: bool,
    /// Whether the next Enter sends the line unchanged, because the note below it has already explained why it was not
    /// sent at once.
    offered: bool,
    history: Vec<String>,
    /// Index of the history line shown; `None` while a new line is typed.
    place: Option<usize>,
    /// Text of the line that was typed before a line of the history was shown.
    draft: String,
}

impl Prompt {
    /// Applies an edit to the line.
    pub fn key(&mut self, key: Key) {
        match key {
            Key::Char(c @ ' '..='~') => {
                self.text.insert(self.cursor, c);
                self.cursor += 1;
                self.changed();
            }
            Key::Char(_) => self.note = "commands are plain ASCII".to_owned(),
            Key::Backspace if self.cursor > 0 => {
                self.cursor -= 1;
                self.text.remove(self.cursor);
                self.changed();
            }
            Key::Delete if self.cursor < self.text.len() => {
                self.text.remove(self.cursor);
                self.changed();
            }
            Key::Backspace | Key::Delete => {}
            Key::Left => self.cursor = self.cursor.saturating_sub(1),
            Key::Right => self.cursor = (self.cursor + 1).min(self.text.len()),
            Key::Home => self.cursor = 0,
            Key::End => self.cursor = self.text.len(),
            Key::Up => self.look_back(),
            Key::Down => self.look_forward(),
            Key::Clear => {
                self.helping = false;
                self.replace(String::new());
                self.place = None;
            }
        }
    }

    /// Returns the command to this program that a single key gives without Enter, on an empty line: no command to the
    /// scanner begins with it.
    pub fn at_once(&self, key: char) -> Option<Own> {
        match key {
            'q' if self.text.is_empty() => Some(Own::Quit),
            '?' if self.text.is_empty() => Some(Own::Help),
            _ => None,
        }
    }

    /// Returns the command to this program that was typed, and clears the line; `None` if the line is for the
    /// scanner.
    pub fn own(&mut self) -> Option<Own> {
        let typed = self.text.trim().to_owned();
        let own = match typed.as_str() {
            "help" | "?" => Own::Help,
            "q" | "quit" | "exit" => Own::Quit,
            _ => return None,
        };
        self.remember(&typed);
        self.replace(String::new());
        Some(own)
    }

    /// Handles Enter. Returns the line to send to the scanner. A line that is not sent at once stays as an offer,
    /// with a note of the reason.
    pub fn enter(&mut self) -> Option<String> {
        let typed = self.text.trim().to_owned();
        if typed.is_empty() {
            return None;
        }
        if self.offered {
            return Some(self.send(typed));
        }
        self.remember(&typed);
        match offer::check(&typed) {
            Checked::Send(line) => Some(self.send(line)),
            Checked::Offer { line, why } => {
                self.replace(line);
                self.note = why;
                self.offered = true;
                None
            }
        }
    }

    fn send(&mut self, line: String) -> String {
        // The reply comes where the help stands.
        self.helping = false;
        self.replace(String::new());
        self.place = None;
        line
    }

    fn changed(&mut self) {
        self.note.clear();
        self.offered = false;
    }

    fn replace(&mut self, text: String) {
        self.cursor = text.len();
        self.text = text;
        self.changed();
    }

    fn remember(&mut self, line: &str) {
        self.place = None;
        if self.history.last().is_none_or(|last| last != line) {
            self.history.push(line.to_owned());
        }
        let surplus = self.history.len().saturating_sub(MAX_HISTORY);
        self.history.drain(..surplus);
    }

    fn look_back(&mut self) {
        let place = self.place.unwrap_or(self.history.len());
        let Some(before) = place.checked_sub(1) else {
            return;
        };
        if self.place.is_none() {
            self.draft = std::mem::take(&mut self.text);
        }
        self.replace(self.history[before].clone());
        self.place = Some(before);
    }

    fn look_forward(&mut self) {
        let Some(place) = self.place else { return };
        let next = place + 1;
        match self.history.get(next) {
            Some(line) => {
                self.replace(line.clone());
                self.place = Some(next);
            }
            None => {
                let draft = std::mem::take(&mut self.draft);
                self.replace(draft);
                self.place = None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use stairscan::scanner::command;

    use super::*;

    fn typed(prompt: &mut Prompt, text: &str) -> Option<String> {
        text.chars().for_each(|c| prompt.key(Key::Char(c)));
        prompt.enter()
    }

    #[test]
    fn the_line_can_be_edited() {
        let mut prompt = Prompt::default();
        "sctusx".chars().for_each(|c| prompt.key(Key::Char(c)));
        prompt.key(Key::Backspace);
        prompt.key(Key::Home);
        prompt.key(Key::Right);
        prompt.key(Key::Delete);
        "ta".chars().for_each(|c| prompt.key(Key::Char(c)));
        assert_eq!((prompt.text.as_str(), prompt.cursor), ("status", 3));
        prompt.key(Key::Char('é'));
        assert_eq!(prompt.text, "status");
        assert_eq!(prompt.enter().as_deref(), Some("status"));
        assert_eq!(prompt.enter(), None);
    }

    #[test]
    fn an_offer_is_sent_by_the_next_enter_and_only_as_it_stands() {
        let mut prompt = Prompt::default();
        assert_eq!(typed(&mut prompt, "set seed 7"), None);
        assert_eq!(prompt.text, "$PSTC,set,seed,7*352B37A8");
        assert_eq!(prompt.enter().as_deref(), Some("$PSTC,set,seed,7*352B37A8"));
        // Editing an offer makes a new line, which is checked again.
        assert_eq!(typed(&mut prompt, "save"), None);
        assert_eq!(typed(&mut prompt, "x"), None);
        assert!(prompt.note.contains("crc"), "{}", prompt.note);
        prompt.key(Key::Clear);
        assert_eq!((prompt.text.as_str(), prompt.note.as_str()), ("", ""));
        // The second Enter sends the line nevertheless.
        assert_eq!(typed(&mut prompt, "scna"), None);
        assert_eq!(prompt.enter().as_deref(), Some("scna"));
    }

    #[test]
    fn the_help_has_every_command_of_the_scanner_and_no_other() {
        let known = command::parse("?").unwrap_err().error.expected;
        let known: BTreeSet<&str> = known.split(' ').filter(|word| *word != "or").collect();
        assert!(known.contains("guard") && known.len() > 10, "{known:?}");
        let (_, lines) = HELP.split_last().unwrap();
        let commands = lines.iter().flat_map(|line| {
            let (commands, _) = line.split_once(": ").unwrap();
            commands
                .split(" | ")
                .map(|one| one.split(' ').next().unwrap())
        });
        assert_eq!(commands.collect::<BTreeSet<_>>(), known);
        for word in known {
            // The word itself is known, whatever arguments it lacks.
            let parsed = command::parse(word);
            let named = parsed.map_or_else(|bad| bad.command, |command| command.word());
            assert_eq!(named, word);
        }
    }

    #[test]
    fn help_and_quit_are_not_for_the_scanner() {
        let mut prompt = Prompt::default();
        for (typed, own) in [
            ("help", Some(Own::Help)),
            (" ? ", Some(Own::Help)),
            ("q", Some(Own::Quit)),
            ("quit", Some(Own::Quit)),
            ("status", None),
        ] {
            prompt.key(Key::Clear);
            typed.chars().for_each(|c| prompt.key(Key::Char(c)));
            assert_eq!(prompt.own(), own, "{typed}");
            assert_eq!(prompt.text.is_empty(), own.is_some(), "{typed}");
        }
    }

    #[test]
    fn q_and_question_mark_need_no_enter_on_an_empty_line() {
        let mut prompt = Prompt::default();
        assert_eq!(prompt.at_once('q'), Some(Own::Quit));
        assert_eq!(prompt.at_once('?'), Some(Own::Help));
        assert_eq!(prompt.at_once('s'), None);
        // Within a line they are its text.
        prompt.key(Key::Char('s'));
        assert_eq!((prompt.at_once('q'), prompt.at_once('?')), (None, None));
    }

    #[test]
    fn the_history_keeps_what_was_typed() {
        let mut prompt = Prompt::default();
        typed(&mut prompt, "stop");
        typed(&mut prompt, "stop");
        typed(&mut prompt, "scan");
        "get".chars().for_each(|c| prompt.key(Key::Char(c)));
        let mut seen = Vec::new();
        for key in [Key::Up, Key::Up, Key::Up, Key::Down, Key::Down, Key::Down] {
            prompt.key(key);
            seen.push(prompt.text.clone());
        }
        assert_eq!(seen, ["scan", "stop", "stop", "scan", "get", "get"]);
    }
}
