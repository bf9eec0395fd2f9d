//! Messages passed to the connection but not confirmed.

use super::super::queue::Queued;
use std::collections::{HashMap, VecDeque};

#[derive(Default)]
pub struct Flight {
    /// `None` for messages that each session publishes again, such as a schema.
    pub entries: VecDeque<Option<Queued>>,
    /// Number of the first entry.
    first: u64,
    /// Number of the entry that is written next.
    written: u64,
    /// Entries by their packet identifiers.
    numbers: HashMap<u16, u64>,
}

impl Flight {
    pub fn write(&mut self, packet: u16) {
        if packet != 0 {
            self.numbers.insert(packet, self.written);
        }
        self.written += 1;
    }

    pub fn acknowledge(&mut self, packet: u16) {
        let Some(number) = self.numbers.remove(&packet) else {
            return;
        };
        let confirmed = (number + 1).saturating_sub(self.first);
        self.entries.drain(..confirmed as usize);
        self.first += confirmed;
    }
}
