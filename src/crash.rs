//! What a dying run leaves for the next one: a [`Record`], in RAM that start-up does not clear.
//!
//! After power-up that RAM holds anything, so a record counts only with its checksum, and only once.

use crate::boot::{Death, FILE_BYTES, Record};
use crate::telemetry::CHECKSUM;

/// Bytes of the checksum, which comes first.
const CHECKSUM_BYTES: usize = 4;

/// Bytes that a record takes at most: in postcard a number of 32 bits takes up to five, a text its length and itself.
const CONTENT_BYTES: usize = 1 + 3 * 5 + 1 + FILE_BYTES + 5;

/// Bytes of RAM for one record.
pub const STORED_BYTES: usize = (CHECKSUM_BYTES + CONTENT_BYTES).next_multiple_of(4);

impl Record {
    /// A panic at `t_us` on the board's counter, in a line of a source file.
    pub fn of_panic(t_us: u32, file: &str, line: u32) -> Self {
        let from = file.len().saturating_sub(FILE_BYTES);
        // A character takes at most four bytes, so one of these is where one begins.
        let end = (from..from + 4).find_map(|from| file.get(from..)).unwrap_or_default();
        let file = heapless::String::try_from(end).unwrap_or_default();
        Self { death: Death::Panic, t_us, pc: 0, lr: 0, file, line }
    }

    /// A HardFault at `t_us` on the board's counter, by an instruction at `pc`, in what was called from `lr`.
    pub const fn of_hard_fault(t_us: u32, pc: u32, lr: u32) -> Self {
        Self { death: Death::HardFault, t_us, pc, lr, file: heapless::String::new(), line: 0 }
    }

    /// Puts it into RAM that outlives a reset.
    pub fn store(&self, ram: &mut [u8; STORED_BYTES]) {
        *ram = [0; STORED_BYTES];
        let (checksum, content) = ram.split_at_mut(CHECKSUM_BYTES);
        // It fits, see above; if it did not, the checksum of what is there would not be stored.
        if postcard::to_slice(self, content).is_ok() {
            checksum.copy_from_slice(&CHECKSUM.checksum(content).to_le_bytes());
        }
    }

    /// Takes it out of there; none if there is none. The next time there is none.
    pub fn take(ram: &mut [u8; STORED_BYTES]) -> Option<Self> {
        let (checksum, content) = ram.split_at(CHECKSUM_BYTES);
        let whole = checksum == CHECKSUM.checksum(content).to_le_bytes();
        let record = if whole { postcard::from_bytes(content).ok() } else { None };
        *ram = [0; STORED_BYTES];
        record
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn longest() -> Record {
        let mut record = Record::of_panic(u32::MAX, "/somewhere/ridgetone/hot/src/moments.rs", u32::MAX);
        (record.pc, record.lr) = (u32::MAX, u32::MAX);
        record
    }

    #[test]
    fn the_longest_record_comes_back_once() {
        let mut ram = [0xa5; STORED_BYTES];
        longest().store(&mut ram);
        assert_eq!(longest().file, "etone/hot/src/moments.rs");
        assert_eq!(Record::take(&mut ram), Some(longest()));
        assert_eq!(Record::take(&mut ram), None);
        let fault = Record::of_hard_fault(5, 0x0800_1234, 0x0800_4321);
        fault.store(&mut ram);
        assert_eq!(Record::take(&mut ram), Some(fault));
    }

    #[test]
    fn whatever_lies_in_the_ram_after_power_up_is_no_record() {
        for byte in 0..=u8::MAX {
            assert_eq!(Record::take(&mut [byte; STORED_BYTES]), None, "{byte:#04x} everywhere");
        }
        for place in 0..STORED_BYTES {
            for bit in 0..8 {
                let mut ram = [0; STORED_BYTES];
                longest().store(&mut ram);
                ram[place] ^= 1 << bit;
                assert_eq!(Record::take(&mut ram), None, "bit {bit} of byte {place} fell over");
            }
        }
    }

    #[test]
    fn a_files_end_begins_with_a_whole_character() {
        let record = Record::of_panic(0, "ordner/straßenäääääääääääää.rs", 1);
        assert!(record.file.len() <= FILE_BYTES && record.file.ends_with("äää.rs"), "{}", record.file);
        assert_eq!(Record::of_panic(0, "", 1).file, "");
    }
}
