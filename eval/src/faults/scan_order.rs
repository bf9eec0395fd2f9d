//! Whole scans without a flaw.

use ads1258::Conversion;
use ridgetone_proto::settings::SCAN;

/// Conversions without a flaw in the order of the scan, since its first slot.
#[derive(Clone, Copy, Debug, Default)]
pub struct ScanOrder(usize);

impl ScanOrder {
    /// Takes a new conversion; true if it ends a scan without a flaw.
    pub fn take(&mut self, conversion: &Conversion) -> bool {
        let status = conversion.status;
        let clean = !status.is_overflow() && !status.is_supply_low();
        self.0 = match slot_of(status.chid()) {
            Some(slot) if clean && slot == self.0 => slot + 1,
            Some(0) if clean => 1,
            _ => 0,
        };
        if self.0 == SCAN.slots() {
            self.0 = 0;
            return true;
        }
        false
    }
}

fn slot_of(id: u8) -> Option<usize> {
    let mask = SCAN.channel_mask();
    (mask >> id & 1 != 0).then(|| (mask & ((1 << id) - 1)).count_ones() as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ads1258::Status;

    #[test]
    fn a_scan_is_whole_once_all_slots_came_in_order() {
        // The datasheet's ids of AIN0 to AIN15, OFFSET, VCC, TEMP, GAIN, REF.
        let ids: Vec<u8> = (0x08..=0x18).chain(0x1A..=0x1D).collect();
        let scan = |order: &mut ScanOrder, ids: &[u8]| {
            let ends = ids.iter().map(|id| order.take(&Conversion { status: Status(0x80 | id), code: 1 }));
            ends.filter(|end| *end).count()
        };
        let mut order = ScanOrder::default();
        assert_eq!(scan(&mut order, &ids), 1);
        assert_eq!(scan(&mut order, &[&ids[..7], &ids[8..]].concat()), 0);
        assert_eq!(scan(&mut order, &ids), 1);
        assert_eq!(scan(&mut order, &[&[0x48], &ids[1..]].concat()), 0);
    }
}
