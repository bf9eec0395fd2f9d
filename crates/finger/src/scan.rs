//! Slots of a scan: their channels, durations and order.

use crate::converter::{Scanned, Tag};
use ridgetone_proto::plan::{HealthReadings, Plan, READINGS, Sampling};
use ridgetone_proto::scan::TAXELS;

/// Slots of one default scan.
pub const SLOTS: u32 = Plan::PAPER.slots();

/// Number of the chip's internal readings.
pub const OWN: usize = READINGS as usize;

/// Maximum number of slots of a scan.
pub const SLOTS_MAX: usize = TAXELS + OWN;

/// A conversion's period in the default scan at the nominal clock, nanoseconds.
pub const CONVERSION_NS: u64 = Plan::PAPER.conversion_ns() as u64;

/// A default scan's period at the nominal clock, nanoseconds.
pub const FRAME_NS: u64 = CONVERSION_NS * SLOTS as u64;

/// Channel ids that a status byte can name.
pub(crate) const IDS: usize = 32;

/// Channel ids of the internal readings: offset, supply, temperature, gain, reference; see [`Tag`].
const OWN_IDS: [u8; OWN] = [0x18, 0x1a, 0x1b, 0x1c, 0x1d];

/// Index of the internal reading that a channel id names.
pub(crate) fn own_of(id: u8) -> Option<usize> {
    OWN_IDS.iter().position(|own| *own == id)
}

/// The taxels of a mask.
#[inline(always)]
pub(crate) fn taxels(mut inputs: u16) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let taxel = inputs.trailing_zeros() as usize % TAXELS;
        let is_one = inputs != 0;
        inputs &= inputs.wrapping_sub(1);
        is_one.then_some(taxel)
    })
}

/// The order of a scan's conversions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Order {
    /// Bit n: channel id n is converted.
    mask: u32,
}

impl Order {
    pub const fn new(plan: &Plan, scanned: Scanned) -> Self {
        let mut own = 0;
        let mut at = 0;
        while at < OWN {
            own |= 1 << OWN_IDS[at];
            at += 1;
        }
        let inputs = (plan.inputs as u32) << Tag::FIRST_INPUT;
        Self {
            mask: match (scanned, plan.health) {
                (Scanned::Health, _) => own,
                (Scanned::Inputs, HealthReadings::EveryScan) => inputs | own,
                (Scanned::Inputs, HealthReadings::BetweenTouches | HealthReadings::Never) => inputs,
            },
        }
    }

    /// NEW and the id of the scan's first conversion.
    pub const fn first(self) -> u8 {
        Tag::NEW | self.mask.trailing_zeros() as u8
    }

    /// Id of the scan's last conversion.
    pub const fn last_id(self) -> u8 {
        31 - self.mask.leading_zeros() as u8 % 32
    }

    /// NEW and the id of the conversion that follows one with this tag.
    #[inline(always)]
    pub const fn next_status(self, status: u8) -> u8 {
        let above = self.mask & !1u32.wrapping_shl(1 + status as u32 % 32).wrapping_sub(1);
        let is_last = status as usize % IDS == IDS - 1 || above == 0;
        Tag::NEW | (if is_last { self.mask } else { above }).trailing_zeros() as u8
    }

    /// Number of conversions skipped from the `expected` status to `status`, without whole scans;
    /// zero if `status` is not in the scan.
    pub fn skipped(self, expected: u8, status: u8) -> u32 {
        let (mut at, mut skipped) = (expected, 0);
        while at & Tag::NEW_AND_ID != status & Tag::NEW_AND_ID {
            (at, skipped) = (self.next_status(at), skipped + 1);
            if skipped >= self.mask.count_ones() {
                return 0;
            }
        }
        skipped
    }

    /// Slot of a channel id.
    pub const fn slot_of(self, id: u8) -> Option<u32> {
        let bit = 1u32 << (id as u32 % 32);
        if self.mask & bit == 0 {
            None
        } else {
            Some((self.mask & (bit - 1)).count_ones())
        }
    }
}

/// Scan of a plan, with derived quantities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scan {
    /// Bit k: taxel k is converted.
    pub(crate) inputs: u16,
    /// Number of taxels that are converted.
    pub(crate) channels: u32,
    /// Conversions per scan.
    pub(crate) slots: u32,
    /// Period of a conversion at the nominal clock, nanoseconds; if all inputs are sampled at once,
    /// a scan's period divided by its slots.
    pub(crate) conversion_ns: u32,
    pub(crate) sampling: Sampling,
}

impl Scan {
    /// Creates the scan of a plan.
    pub const fn new(plan: &Plan) -> Self {
        Self {
            inputs: plan.inputs,
            channels: plan.channels() as u32,
            slots: plan.slots(),
            conversion_ns: plan.conversion_ns(),
            sampling: plan.sampling,
        }
    }

    /// A scan's period at the nominal clock, nanoseconds.
    pub(crate) const fn frame_ns(&self) -> u32 {
        self.conversion_ns * self.slots
    }

    /// Time from one slot to the next, nanoseconds.
    pub(crate) const fn slot_ns(&self) -> u32 {
        match self.sampling {
            Sampling::InTurn => self.conversion_ns,
            Sampling::AtOnce => 0,
        }
    }

    /// Time from a scan's first slot to its last, nanoseconds.
    pub(crate) const fn span_ns(&self) -> u32 {
        self.slot_ns() * (self.slots - 1)
    }

    /// [`Self::span_ns`] in microseconds.
    pub(crate) const fn span_us(&self) -> u32 {
        self.span_ns() / 1000
    }

    /// Time from one data-ready edge to the next, nanoseconds.
    pub(crate) const fn edge_ns(&self) -> u32 {
        match self.sampling {
            Sampling::InTurn => self.conversion_ns,
            Sampling::AtOnce => self.frame_ns(),
        }
    }

    /// Number of slots from the first taxel to this one.
    pub(crate) const fn slots_after_first(&self, taxel: usize) -> u32 {
        match self.sampling {
            Sampling::InTurn => {
                (self.inputs & ((1u32 << (taxel as u32 % 16)) - 1) as u16).count_ones()
            }
            Sampling::AtOnce => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::converter::Ads1258Plan;
    use ads1258::Channel;
    use ridgetone_proto::plan::Converters;

    /// Compares with the driver's own implementation of the order.
    #[test]
    fn the_next_channel_is_the_driver_s() {
        for (name, plan) in Plan::usual(Converters::ADS1258) {
            let own = Ads1258Plan::of(&plan);
            let scans = [
                (Scanned::Inputs, own.config()),
                (Scanned::Health, own.health_config()),
            ];
            for (scanned, config) in scans {
                let order = Order::new(&plan, scanned);
                assert_eq!(
                    Some(order.first() & 0x1f),
                    config.scan().next().map(Channel::id),
                    "{name}"
                );
                assert_eq!(
                    Some(order.last_id()),
                    config.scan().last().map(Channel::id),
                    "{name}"
                );
                for (slot, channel) in (0..).zip(config.scan()) {
                    assert_eq!(
                        order.next_status(Tag::NEW | channel.id()),
                        Tag::NEW | config.next_channel(channel).id()
                    );
                    assert_eq!(order.slot_of(channel.id()), Some(slot));
                }
                assert_eq!(order.next_status(0xff), order.first());
            }
        }
        let own: heapless::Vec<u8, OWN> = Ads1258Plan::PAPER
            .health_config()
            .scan()
            .map(Channel::id)
            .collect();
        assert_eq!(own, OWN_IDS);
    }
}
