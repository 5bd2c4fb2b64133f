//! Access to a file of the host, through semihosting.

use core::ffi::CStr;
use cortex_m_semihosting::syscall;

/// A file of the host, open for reading.
#[derive(Debug)]
pub struct HostFile(usize);

impl HostFile {
    /// Opens the file of this name in the emulator's working directory.
    pub fn open(name: &CStr) -> Option<Self> {
        /// Mode `rb`.
        const READ_BINARY: usize = 1;
        // SAFETY: the name has the length given and ends with a zero byte.
        let handle = unsafe { syscall!(OPEN, name.as_ptr(), READ_BINARY, name.count_bytes()) };
        (handle != usize::MAX).then_some(Self(handle))
    }

    /// Fills the whole buffer; returns `false` if the file ends before.
    pub fn read(&mut self, buffer: &mut [u8]) -> bool {
        // SAFETY: the host writes no more than the buffer's size into it.
        let missing = unsafe { syscall!(READ, self.0, buffer.as_mut_ptr(), buffer.len()) };
        missing == 0
    }
}
