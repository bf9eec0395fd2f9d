//! The slots of the scan: which channel the chip converts in each, how long that takes, and which comes next.

use ads1258::{Channel, Sysred};
use ridgetone_proto::scan::{INPUTS, SCAN, SCANNED};

/// Slots of one scan.
pub const SLOTS: u32 = SCAN.slots() as u32;

/// The chip's internal readings, in the slots behind the taxels'.
pub const OWN: usize = SLOTS as usize - INPUTS;

/// A conversion's period at the nominal clock, nanoseconds.
pub const CONVERSION_NS: u64 = SCAN.conversion_ticks() as u64 * 1_000_000_000 / SCAN.clock_hz as u64;

/// A scan's period at the nominal clock, nanoseconds.
pub const FRAME_NS: u64 = CONVERSION_NS * SLOTS as u64;

/// Channel ids that a status byte can name.
pub(crate) const IDS: usize = 32;

// Taxel k is slot k, and all five internal readings follow.
const _: () = assert!(SCAN.channel_mask() == (Sysred::ALL.to_bits() as u32) << 24 | (SCANNED as u32) << 8);

/// Slot of every channel id, in the order of the scan.
pub(crate) const SLOT_OF: [Option<u8>; IDS] = {
    let mut slots = [None; IDS];
    let (mut id, mut slot) = (0, 0);
    while id < IDS {
        if SCAN.channel_mask() & 1 << id != 0 {
            slots[id] = Some(slot);
            slot += 1;
        }
        id += 1;
    }
    slots
};

/// Channel id of every slot.
pub(crate) const ID_OF: [u8; SLOTS as usize] = {
    let mut ids = [0; SLOTS as usize];
    let mut id = 0;
    while id < IDS {
        if let Some(slot) = SLOT_OF[id] {
            ids[slot as usize] = id as u8;
        }
        id += 1;
    }
    ids
};

/// NEW in the status byte (SBAS297G).
pub(crate) const NEW: u8 = 0x80;
/// NEW and CHID.
pub(crate) const NEW_AND_ID: u8 = 0x9f;
/// NEW and CHID of the scan's first conversion.
pub(crate) const FIRST: u8 = NEW | ID_OF[0];

/// NEW and CHID of the conversion that follows one with this CHID; the first one where the chip has no such channel.
const NEXT: [u8; IDS] = {
    let mut next = [FIRST; IDS];
    let mut id = 0;
    while id < next.len() {
        if let Some(channel) = Channel::from_id(id as u8) {
            next[id] = NEW | SCAN.next_channel(channel).id();
        }
        id += 1;
    }
    next
};

/// NEW and CHID of the conversion that follows one of this status.
#[inline(always)]
pub(crate) fn next_status(status: u8) -> u8 {
    NEXT[status as usize % NEXT.len()]
}

/// Conversions of the scan between the expected one and this one, less whole scans. None for one that is not of the
/// scan.
pub(crate) fn skipped(expected: u8, status: u8) -> u32 {
    let (mut at, mut skipped) = (expected, 0);
    while at & NEW_AND_ID != status & NEW_AND_ID {
        (at, skipped) = (next_status(at), skipped + 1);
        if skipped >= SLOTS {
            return 0;
        }
    }
    skipped
}
