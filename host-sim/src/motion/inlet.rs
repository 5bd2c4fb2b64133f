//! What a scanner on the host reads at its report port.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use stairscan::scanner::command::framed;

use super::Timetable;

/// Lines that are typed, and where a timetable brings motion sentences, those between them.
#[derive(Default)]
pub struct Inlet {
    timetable: Option<Rc<RefCell<Timetable>>>,
    typed: VecDeque<u8>,
}

impl Inlet {
    /// With the motion sentences of `timetable`.
    pub fn new(timetable: Option<Rc<RefCell<Timetable>>>) -> Self {
        Self {
            timetable,
            typed: VecDeque::new(),
        }
    }

    /// Takes whole lines, so that motion sentences come between them.
    pub fn type_in(&mut self, lines: &[u8]) {
        match &self.timetable {
            Some(table) => table.borrow_mut().type_in(lines),
            None => self.typed.extend(lines),
        }
    }

    /// Takes commands that set values.
    pub fn set(&mut self, settings: &[(&str, String)]) {
        for (key, value) in settings {
            self.type_in(framed(&["set", key, value]).as_bytes());
        }
    }

    /// The next byte.
    pub fn read(&mut self) -> Option<u8> {
        match &self.timetable {
            Some(table) => table.borrow_mut().read(),
            None => self.typed.pop_front(),
        }
    }
}
