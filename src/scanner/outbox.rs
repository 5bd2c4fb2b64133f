//! Queue of outgoing sentences.

use crate::port::BytePort;
use crate::report::sentence::MAX_SENTENCE;
use crate::report::{Line, Sentence};

/// Capacity of the queue, bytes: four of the longest sentences, 90 ms at 115,200 baud. A scan has more sentences,
/// which are queued as the port takes them.
const CAPACITY: usize = 1024;

/// A queue of whole sentences for a port that never blocks.
#[derive(Debug, Default)]
pub struct Outbox {
    bytes: heapless::Deque<u8, CAPACITY>,
}

impl Outbox {
    /// Creates an empty queue.
    pub const fn new() -> Self {
        Self {
            bytes: heapless::Deque::new(),
        }
    }

    /// Whether the queue is empty.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Whether another sentence of the maximum length fits.
    pub fn has_room(&self) -> bool {
        CAPACITY - self.bytes.len() >= MAX_SENTENCE
    }

    /// Queues one sentence; returns `false`, and queues nothing, if there is no room.
    pub fn push(&mut self, sentence: &Sentence<'_>) -> bool {
        if !self.has_room() {
            return false;
        }
        let line: Line = sentence.write();
        for &byte in line.as_bytes() {
            let _ = self.bytes.push_back(byte);
        }
        true
    }

    /// Hands over as many queued bytes as the port takes, without waiting.
    pub fn pump(&mut self, port: &mut impl BytePort) {
        loop {
            let (front, _) = self.bytes.as_slices();
            if front.is_empty() {
                return;
            }
            let taken = port.write(front);
            for _ in 0..taken {
                let _ = self.bytes.pop_front();
            }
            if taken == 0 {
                return;
            }
        }
    }
}
