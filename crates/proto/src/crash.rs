//! The crash record: a [`Record`] in RAM that start-up does not clear.
//!
//! After power-up this RAM holds random values, so a record is only accepted with its checksum, and
//! only once.

use crate::boot::{Death, FILE_BYTES, Record};
use crate::framing::CHECKSUM;

/// Words of RAM for one record: checksum, [`Death`], time, two addresses, line, and the file's name
/// padded with zeros. Stored as words, because decoding postcard would need another kilobyte of
/// flash.
pub const STORED_WORDS: usize = 6 + FILE_BYTES / 4;

/// Causes, indexed by their number in the record.
const DEATHS: [Death; 3] = [Death::Panic, Death::HardFault, Death::Oscillator];

/// RAM of a record.
pub type Stored = [u32; STORED_WORDS];

impl Record {
    /// Creates the record of a panic at `t_us` on the board's counter, in a line of a source file;
    /// in its name non-ASCII bytes become `?`.
    pub fn of_panic(t_us: u32, file: &str, line: u32) -> Self {
        let mut end = heapless::String::new();
        let skipped = file.len().saturating_sub(FILE_BYTES);
        for byte in file.bytes().skip(skipped) {
            // The capacity is `FILE_BYTES`.
            let _ = end.push(if byte.is_ascii() {
                char::from(byte)
            } else {
                '?'
            });
        }
        Self {
            death: Death::Panic,
            t_us,
            pc: 0,
            lr: 0,
            file: end,
            line,
        }
    }

    /// Creates the record of a HardFault at `t_us` on the board's counter, by an instruction at
    /// `pc`; `lr` is the return address.
    pub const fn of_hard_fault(t_us: u32, pc: u32, lr: u32) -> Self {
        Self {
            death: Death::HardFault,
            t_us,
            pc,
            lr,
            file: heapless::String::new(),
            line: 0,
        }
    }

    /// Creates the record of a stopped external oscillator, at `t_us` on the board's counter.
    pub fn of_oscillator(t_us: u32) -> Self {
        Self {
            death: Death::Oscillator,
            ..Self::of_hard_fault(t_us, 0, 0)
        }
    }

    /// Writes the record into RAM that a reset does not clear.
    pub fn store(&self, ram: &mut Stored) {
        let [_, death, t_us, pc, lr, line, file @ ..] = ram;
        (*death, *t_us, *pc, *lr, *line) =
            (self.death as u32, self.t_us, self.pc, self.lr, self.line);
        let mut bytes = self.file.bytes();
        for word in file {
            *word = u32::from_le_bytes(core::array::from_fn(|_| bytes.next().unwrap_or(0)));
        }
        ram[0] = checksum_of(ram);
    }

    /// Reads the record, if there is one, and clears it.
    pub fn take(ram: &mut Stored) -> Option<Self> {
        let found = *ram;
        *ram = [0; STORED_WORDS];
        let [checksum, death, t_us, pc, lr, line, words @ ..] = found;
        let death = *DEATHS
            .get(death as usize)
            .filter(|_| checksum == checksum_of(&found))?;
        let mut file = heapless::String::new();
        for byte in words
            .iter()
            .flat_map(|word| word.to_le_bytes())
            .take_while(|byte| *byte != 0)
        {
            // The capacity is `FILE_BYTES`.
            let _ = file.push(char::from(byte));
        }
        Some(Self {
            death,
            t_us,
            pc,
            lr,
            file,
            line,
        })
    }
}

/// Checksum of all words except the first, which stores it.
fn checksum_of(ram: &Stored) -> u32 {
    let mut digest = CHECKSUM.digest();
    for word in ram.iter().skip(1) {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn longest() -> Record {
        let mut record = Record::of_panic(
            u32::MAX,
            "/somewhere/ridgetone/tone/src/moments.rs",
            u32::MAX,
        );
        (record.pc, record.lr) = (u32::MAX, u32::MAX);
        record
    }

    #[test]
    fn the_longest_record_is_read_once() {
        let mut ram = [0xa5a5_a5a5; STORED_WORDS];
        longest().store(&mut ram);
        assert_eq!(longest().file, "tone/tone/src/moments.rs");
        assert_eq!(Record::take(&mut ram), Some(longest()));
        assert_eq!(Record::take(&mut ram), None);
        let fault = Record::of_hard_fault(5, 0x0800_1234, 0x0800_4321);
        for record in [fault, Record::of_oscillator(7)] {
            record.store(&mut ram);
            assert_eq!(Record::take(&mut ram), Some(record));
        }
    }

    #[test]
    fn random_ram_after_power_up_is_no_record() {
        for byte in 0..=u8::MAX {
            let mut ram = [u32::from_le_bytes([byte; 4]); STORED_WORDS];
            assert_eq!(Record::take(&mut ram), None, "{byte:#04x} everywhere");
        }
        for place in 0..STORED_WORDS {
            for bit in 0..32 {
                let mut ram = [0; STORED_WORDS];
                longest().store(&mut ram);
                ram[place] ^= 1 << bit;
                assert_eq!(
                    Record::take(&mut ram),
                    None,
                    "bit {bit} of word {place} flipped"
                );
            }
        }
    }

    #[test]
    fn a_files_name_keeps_its_end_and_is_ascii() {
        let record = Record::of_panic(0, "ordner/straße.rs", 1);
        assert_eq!(record.file, "ordner/stra??e.rs");
        let mut ram = [0; STORED_WORDS];
        record.store(&mut ram);
        assert_eq!(Record::take(&mut ram), Some(record));
        assert_eq!(Record::of_panic(0, "", 1).file, "");
    }
}
