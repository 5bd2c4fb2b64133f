//! A bounded queue of bytes between an interrupt and the main loop.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

/// One writer, one reader; `N` must be a power of two.
#[derive(Debug)]
pub struct Ring<const N: usize> {
    bytes: [AtomicU8; N],
    written: AtomicU32,
    read: AtomicU32,
}

impl<const N: usize> Ring<N> {
    /// An empty queue.
    pub const fn new() -> Self {
        const { assert!(N.is_power_of_two()) };
        Self {
            bytes: [const { AtomicU8::new(0) }; N],
            written: AtomicU32::new(0),
            read: AtomicU32::new(0),
        }
    }

    fn slot(&self, index: u32) -> Option<&AtomicU8> {
        self.bytes.get(index as usize & (N - 1))
    }

    /// Appends a byte; a full queue drops it, and whatever it belonged to fails its own check.
    pub fn push(&self, byte: u8) {
        let written = self.written.load(Ordering::Relaxed);
        let used = written.wrapping_sub(self.read.load(Ordering::Acquire));
        if let Some(slot) = self.slot(written)
            && (used as usize) < N
        {
            slot.store(byte, Ordering::Relaxed);
            self.written
                .store(written.wrapping_add(1), Ordering::Release);
        }
    }

    /// The oldest byte.
    pub fn pop(&self) -> Option<u8> {
        let read = self.read.load(Ordering::Relaxed);
        if read == self.written.load(Ordering::Acquire) {
            return None;
        }
        let byte = self.slot(read)?.load(Ordering::Relaxed);
        self.read.store(read.wrapping_add(1), Ordering::Release);
        Some(byte)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_order_and_bound() {
        let ring = Ring::<8>::new();
        for round in 0..100_u8 {
            for k in 0..11 {
                ring.push(round.wrapping_add(k));
            }
            let read: Vec<u8> = std::iter::from_fn(|| ring.pop()).collect();
            let expected: Vec<u8> = (0..8).map(|k| round.wrapping_add(k)).collect();
            assert_eq!(read, expected);
        }
    }
}
