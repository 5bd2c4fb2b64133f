//! Input of the report port of a scanner on the host: commands, and motion sentences between them.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use stairscan::scanner::command::framed;

use super::Timetable;

/// Bytes for the scanner's report port: typed commands and, with a timetable, motion sentences
/// between them.
#[derive(Default)]
pub struct Inlet {
    timetable: Option<Rc<RefCell<Timetable>>>,
    typed: VecDeque<u8>,
}

impl Inlet {
    /// Creates the input with the motion sentences of `timetable`; `None` for commands only.
    pub fn new(timetable: Option<Rc<RefCell<Timetable>>>) -> Self {
        Self {
            timetable,
            typed: VecDeque::new(),
        }
    }

    /// Adds the bytes of whole command lines, so that motion sentences come between the lines.
    pub fn type_in(&mut self, lines: &[u8]) {
        match &self.timetable {
            Some(table) => table.borrow_mut().type_in(lines),
            None => self.typed.extend(lines),
        }
    }

    /// Adds a `set` command for each pair of setting and value.
    pub fn set(&mut self, settings: &[(&str, String)]) {
        for (key, value) in settings {
            self.type_in(framed(&["set", key, value]).as_bytes());
        }
    }

    /// Returns the next byte for the scanner; `None` if there is none yet.
    pub fn read(&mut self) -> Option<u8> {
        match &self.timetable {
            Some(table) => table.borrow_mut().read(),
            None => self.typed.pop_front(),
        }
    }
}
