//! Handle of a simulated part that the scanner and the test share.

use std::cell::{RefCell, RefMut};
use std::rc::Rc;

use stairscan::port::BytePort;

/// A part that the scanner and the test share; the copies are handles of the same part.
#[derive(Debug, Default)]
pub struct Shared<T>(Rc<RefCell<T>>);

impl<T> Shared<T> {
    /// Takes `part` into shared ownership.
    pub fn new(part: T) -> Self {
        Self(Rc::new(RefCell::new(part)))
    }

    /// Returns the part; panics while another handle uses it.
    pub fn get(&self) -> RefMut<'_, T> {
        self.0.borrow_mut()
    }
}

impl<T> Clone for Shared<T> {
    fn clone(&self) -> Self {
        Self(Rc::clone(&self.0))
    }
}

impl<P: BytePort> BytePort for Shared<P> {
    fn read(&mut self) -> Option<u8> {
        self.get().read()
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        self.get().write(bytes)
    }

    fn errors(&self) -> u16 {
        self.get().errors()
    }

    fn has_rate(&self, baud: u32) -> bool {
        self.get().has_rate(baud)
    }

    fn set_rate(&mut self, baud: u32) {
        self.get().set_rate(baud);
    }

    fn pulse(&mut self) {
        self.get().pulse();
    }
}
