//! What a conversion measures, and the order of the scan.

use super::options::ChopInternal;
use super::registers::{MUXDIF, MUXSCH, MUXSG0, MUXSG1, Registers, SYSRED};

/// One measurement of the multiplexer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    /// Pair `n`: AIN(2n) against AIN(2n + 1).
    Differential(u8),
    /// AINn against AINCOM.
    Single(u8),
    /// The two inputs of MUXSCH.
    Fixed {
        ainp: u8,
        ainn: u8,
    },
    Offset,
    Vcc,
    Temp,
    Gain,
    Ref,
}

impl Slot {
    /// The CHID of a scanned slot; a fixed channel has none of its own.
    pub(crate) fn chid(self) -> Option<u8> {
        Some(match self {
            Slot::Differential(n) => n,
            Slot::Single(n) => 0x08 + n,
            Slot::Fixed { .. } => return None,
            Slot::Offset => 0x18,
            Slot::Vcc => 0x1A,
            Slot::Temp => 0x1B,
            Slot::Gain => 0x1C,
            Slot::Ref => 0x1D,
        })
    }

    fn of_chid(chid: u8) -> Option<Self> {
        Some(match chid {
            0x00..=0x07 => Slot::Differential(chid),
            0x08..=0x17 => Slot::Single(chid - 0x08),
            0x18 => Slot::Offset,
            0x1A => Slot::Vcc,
            0x1B => Slot::Temp,
            0x1C => Slot::Gain,
            0x1D => Slot::Ref,
            _ => return None,
        })
    }

    /// The readings that chopping excludes.
    pub(crate) fn excluded_by_chop(self) -> bool {
        matches!(self, Slot::Vcc | Slot::Temp | Slot::Gain | Slot::Ref)
    }

    fn selected(self, registers: &Registers) -> bool {
        let (register, bit) = match self {
            Slot::Differential(n) => (MUXDIF, n),
            Slot::Single(n @ 0..=7) => (MUXSG0, n),
            Slot::Single(n) => (MUXSG1, n - 8),
            Slot::Fixed { .. } => return false,
            Slot::Offset => (SYSRED, 0),
            Slot::Vcc => (SYSRED, 2),
            Slot::Temp => (SYSRED, 3),
            Slot::Gain => (SYSRED, 4),
            Slot::Ref => (SYSRED, 5),
        };
        registers.byte(register) & (1 << bit) != 0
    }
}

/// What comes after CHID `last` (`None`: at the top): ascending, wrapping, skipping what is not selected. `None` when
/// nothing is.
pub(crate) fn next_slot(registers: &Registers, last: Option<u8>, chop_internal: ChopInternal) -> Option<Slot> {
    if registers.muxmod() {
        let muxsch = registers.byte(MUXSCH);
        return Some(Slot::Fixed { ainp: muxsch >> 4, ainn: muxsch & 0x0F });
    }
    let skip_internal = registers.chop() && chop_internal == ChopInternal::Skipped;
    let first = last.map_or(0, |chid| (chid + 1) & 0x1F);
    (0..0x20)
        .filter_map(|step| Slot::of_chid((first + step) & 0x1F))
        .find(|slot| slot.selected(registers) && !(skip_internal && slot.excluded_by_chop()))
}
