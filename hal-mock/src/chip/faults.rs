//! Faults to put into the chip, for tests of what notices them.

use super::Ads1258;

/// Faults in force.
#[derive(Clone, Debug, Default)]
pub(crate) struct Faults {
    pub(crate) stalled: bool,
    /// Masks for DOUT bytes still to come, by the count of bytes exchanged since construction.
    flips: Vec<(u64, u8)>,
    exchanged: u64,
}

impl Faults {
    /// What of the next DOUT byte to flip.
    pub(crate) fn next_mask(&mut self) -> u8 {
        let at = self.exchanged;
        self.exchanged += 1;
        let mask = self.flips.iter().filter(|(byte, _)| *byte == at).fold(0, |all, (_, mask)| all ^ mask);
        self.flips.retain(|(byte, _)| *byte > at);
        mask
    }
}

impl Ads1258 {
    /// Flips the bits of `mask` in a register, as the field reports of registers that "changed by themselves" have it.
    /// Read-only bits flip too; addresses above 09h do nothing.
    pub fn corrupt_register(&mut self, address: u8, mask: u8) {
        self.registers.flip(address, mask);
    }

    /// Stops the converter: the running conversion never ends and none begins. Letting it go is a new start condition
    /// if START is high.
    pub fn set_stalled(&mut self, now_ns: u64, stalled: bool) {
        self.advance_to(now_ns);
        let was = std::mem::replace(&mut self.faults.stalled, stalled);
        if stalled {
            self.conversion = None;
        } else if was && self.start {
            self.start_condition();
        }
    }

    /// Flips the bits of `mask` in one DOUT byte, `bytes_ahead` of the next one exchanged (0: the next).
    pub fn flip_dout(&mut self, bytes_ahead: u64, mask: u8) {
        self.faults.flips.push((self.faults.exchanged + bytes_ahead, mask));
    }
}
