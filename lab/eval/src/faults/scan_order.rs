//! Detects complete scans.

use ads1258::{Config, Conversion};

/// Counts correct conversions in scan order since the first slot.
#[derive(Clone, Copy, Debug)]
pub struct ScanOrder {
    /// Bit n: the scan includes the channel with id n.
    channels: u32,
    taken: usize,
}

impl ScanOrder {
    pub fn new(scan: &Config) -> Self {
        Self {
            channels: scan.channel_mask(),
            taken: 0,
        }
    }

    fn slot_of(&self, id: u8) -> Option<usize> {
        (self.channels >> id & 1 != 0)
            .then(|| (self.channels & ((1 << id) - 1)).count_ones() as usize)
    }

    /// Takes a new conversion. Returns true if it completes a scan.
    pub fn take(&mut self, conversion: &Conversion) -> bool {
        let status = conversion.status;
        let clean = !status.is_overflow() && !status.is_supply_low();
        self.taken = match self.slot_of(status.chid()) {
            Some(slot) if clean && slot == self.taken => slot + 1,
            Some(0) if clean => 1,
            _ => 0,
        };
        if self.taken == self.channels.count_ones() as usize {
            self.taken = 0;
            return true;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ads1258::Status;
    use ridgetone_finger::converter::SCAN;

    #[test]
    fn a_scan_is_whole_once_all_slots_came_in_order() {
        // Ids of AIN0 to AIN15, OFFSET, VCC, TEMP, GAIN, REF in the datasheet.
        let ids: Vec<u8> = (0x08..=0x18).chain(0x1A..=0x1D).collect();
        let scan = |order: &mut ScanOrder, ids: &[u8]| {
            let ends = ids.iter().map(|id| {
                order.take(&Conversion {
                    status: Status(0x80 | id),
                    code: 1,
                })
            });
            ends.filter(|end| *end).count()
        };
        let mut order = ScanOrder::new(&SCAN);
        assert_eq!(scan(&mut order, &ids), 1);
        assert_eq!(scan(&mut order, &[&ids[..7], &ids[8..]].concat()), 0);
        assert_eq!(scan(&mut order, &ids), 1);
        assert_eq!(scan(&mut order, &[&[0x48], &ids[1..]].concat()), 0);
    }
}
