//! Quantities that a conversion measures, and the order of the scan.

use super::registers::{CHOP, MUXDIF, MUXMOD, MUXSCH, MUXSG0, MUXSG1, Registers, SYSRED};

/// One setting of the multiplexer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    /// A channel of the scan, by its CHID.
    Scanned(u8),
    /// A fixed channel: the two inputs selected by MUXSCH.
    Fixed { ainp: u8, ainn: u8 },
}

/// CHID of AIN0 against AINCOM; the pairs DIFF0 to DIFF7 are below it.
pub(crate) const SINGLE: u8 = 0x08;
/// CHIDs of the internal readings.
pub(crate) const OFFSET: u8 = 0x18;
pub(crate) const VCC: u8 = 0x1A;
pub(crate) const TEMP: u8 = 0x1B;
pub(crate) const GAIN: u8 = 0x1C;
pub(crate) const REF: u8 = 0x1D;

/// Readings that chopping excludes, one bit per CHID.
const EXCLUDED_BY_CHOP: u32 = 1 << VCC | 1 << TEMP | 1 << GAIN | 1 << REF;

impl Slot {
    /// CHID of a scanned slot; `None` for a fixed channel.
    pub(crate) fn chid(self) -> Option<u8> {
        match self {
            Slot::Scanned(chid) => Some(chid),
            Slot::Fixed { .. } => None,
        }
    }

    pub(crate) fn excluded_by_chop(self) -> bool {
        self.chid()
            .is_some_and(|chid| EXCLUDED_BY_CHOP >> chid & 1 == 1)
    }
}

/// Returns the next selected slot after CHID `last` in ascending order, wrapping around; from the
/// top if `last` is `None`. `None` if nothing is selected.
pub(crate) fn next_slot(
    registers: &Registers,
    last: Option<u8>,
    chop_skips_internal: bool,
) -> Option<Slot> {
    if registers.bit(MUXMOD) {
        let muxsch = registers.byte(MUXSCH);
        return Some(Slot::Fixed {
            ainp: muxsch >> 4,
            ainn: muxsch & 0x0F,
        });
    }
    // Bit n of the four registers together selects CHID n.
    let mut selected =
        u32::from_le_bytes([MUXDIF, MUXSG0, MUXSG1, SYSRED].map(|address| registers.byte(address)));
    // Reserved bits of SYSRED select nothing, even if a fault has set them.
    selected &= 0x3DFF_FFFF;
    if registers.bit(CHOP) && chop_skips_internal {
        selected &= !EXCLUDED_BY_CHOP;
    }
    let first = last.map_or(0, |chid| (chid + 1) & 0x1F);
    (0..0x20)
        .map(|step| (first + step) & 0x1F)
        .find(|chid| selected >> chid & 1 == 1)
        .map(Slot::Scanned)
}
