//! Input of the report port of a scanner on the host.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use stairscan::scanner::command::framed;

use super::Timetable;

/// Typed lines and, with a timetable, the motion sentences between them.
#[derive(Default)]
pub struct Inlet {
    timetable: Option<Rc<RefCell<Timetable>>>,
    typed: VecDeque<u8>,
}

impl Inlet {
    /// Creates the input with the motion sentences of `timetable`.
    pub fn new(timetable: Option<Rc<RefCell<Timetable>>>) -> Self {
        Self {
            timetable,
            typed: VecDeque::new(),
        }
    }

    /// Adds whole lines, so that motion sentences come between them.
    pub fn type_in(&mut self, lines: &[u8]) {
        match &self.timetable {
            Some(table) => table.borrow_mut().type_in(lines),
            None => self.typed.extend(lines),
        }
    }

    /// Adds commands that set values.
    pub fn set(&mut self, settings: &[(&str, String)]) {
        for (key, value) in settings {
            self.type_in(framed(&["set", key, value]).as_bytes());
        }
    }

    /// Returns the next byte.
    pub fn read(&mut self) -> Option<u8> {
        match &self.timetable {
            Some(table) => table.borrow_mut().read(),
            None => self.typed.pop_front(),
        }
    }
}
