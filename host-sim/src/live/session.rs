//! An observed source, with or without a screen: its state, the file of its lines, and the receiver of its answers.

use super::Ms;
use super::keep::Keep;
use super::model::{Event, State};
use crate::answer::Answer;

/// An observed source of a scanner's sentences, such as a serial port.
pub struct Session<'a> {
    /// State of scanner and port, from the events so far.
    pub state: State,
    /// File that records all lines; `None` if none was requested, or after a failure.
    pub keep: Option<Keep>,
    /// Called with each complete answer.
    pub look: &'a mut dyn FnMut(&Answer),
}

impl Session<'_> {
    /// Processes an event of the port at time `at`: updates the state, passes on a new answer, records the line.
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
            Event::Pending(_) => {}
            // A further failed attempt is not reported.
            _ if self.state.link == link => {}
            Event::Opened => self.keep(at, '#', "the port is open"),
            Event::Failed(trouble) => {
                let (what, _) = trouble.explain(&self.state.port);
                self.keep(at, '#', &what);
            }
        }
    }

    /// Writes a line to the record, if there is one; `way` is its direction, `<`, `>` or `#`. The first failure ends
    /// the recording, with a remark.
    pub fn keep(&mut self, at: Ms, way: char, text: &str) {
        if let Some(keep) = &mut self.keep
            && let Err(error) = keep.line(at, way, text)
        {
            let remark = format!("recording has ended: {error:#}");
            self.state.note(at, &remark);
            self.keep = None;
        }
    }
}
