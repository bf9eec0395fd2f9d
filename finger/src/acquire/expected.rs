//! Which conversion comes next.

use crate::scan::{ID_OF, IDS, SLOTS};
use ads1258::Channel;
use ridgetone_proto::scan::SCAN;

/// NEW in the status byte (SBAS297G).
pub const NEW: u8 = 0x80;
/// NEW and CHID.
pub const NEW_AND_ID: u8 = 0x9f;
/// NEW and CHID of the scan's first conversion.
pub const FIRST: u8 = NEW | ID_OF[0];

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
pub fn next(status: u8) -> u8 {
    NEXT[status as usize % NEXT.len()]
}

/// Conversions of the scan between the expected one and this one, less whole scans. None for one that is not of the
/// scan.
pub fn skipped(expected: u8, status: u8) -> u32 {
    let (mut at, mut skipped) = (expected, 0);
    while at & NEW_AND_ID != status & NEW_AND_ID {
        (at, skipped) = (next(at), skipped + 1);
        if skipped >= SLOTS {
            return 0;
        }
    }
    skipped
}
