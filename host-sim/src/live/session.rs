//! A source while it is watched, on a screen or without: its state, the file of its lines, and who gets its answers.

use super::Ms;
use super::keep::Keep;
use super::model::{Event, State};
use crate::answer::Answer;

/// A source under observation.
pub struct Session<'a> {
    /// State of scanner and port.
    pub state: State,
    /// The file that keeps every line, if one is wanted.
    pub keep: Option<Keep>,
    /// Gets each answer once it is whole.
    pub look: &'a mut dyn FnMut(&Answer),
}

impl Session<'_> {
    /// Takes what happened at `at`.
    pub fn take(&mut self, at: Ms, event: &Event) {
        let (link, answers) = (self.state.link.clone(), self.state.answers);
        self.state.take(at, event);
        if let Some((_, answer)) = &self.state.answer
            && self.state.answers > answers
        {
            (self.look)(answer);
        }
        match event {
            Event::Line(line) => self.keep(at, '<', line),
            // An attempt more is no news.
            _ if self.state.link == link => {}
            Event::Opened => self.keep(at, '#', "the port is open"),
            Event::Failed(trouble) => {
                let (what, _) = trouble.explain(&self.state.port);
                self.keep(at, '#', &what);
            }
        }
    }

    /// Keeps a line if a file is wanted; one that cannot be written ends that, with a remark.
    pub fn keep(&mut self, at: Ms, way: char, text: &str) {
        if let Some(keep) = &mut self.keep
            && let Err(error) = keep.line(at, way, text)
        {
            let remark = format!("nothing is recorded any more: {error:#}");
            self.state.note(at, &remark);
            self.keep = None;
        }
    }
}
