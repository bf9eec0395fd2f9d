//! The channels of a scan in the order in which the chip visits them: ascending channel id.

use core::iter::FusedIterator;

use crate::Channel;

/// Iterator over the channels of one scan in ascending channel id; from [`Config::scan`](crate::Config::scan).
///
/// It is one word and can be copied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scan {
    /// One bit for each channel still to come; bit n is channel id n.
    mask: u32,
}

impl Scan {
    pub(crate) const fn new(mask: u32) -> Self {
        Self { mask }
    }
}

impl Iterator for Scan {
    type Item = Channel;

    fn next(&mut self) -> Option<Channel> {
        let channel = lowest(self.mask);
        // Clears the lowest bit that is set.
        self.mask &= self.mask.wrapping_sub(1);
        channel
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let count = self.mask.count_ones() as usize;
        (count, Some(count))
    }
}

impl ExactSizeIterator for Scan {}
impl FusedIterator for Scan {}

/// The channel after `channel` in the scan, wrapping at its end; `None` if the scan is empty.
///
/// `channel` itself need not be in the scan.
pub(crate) const fn after(mask: u32, channel: Channel) -> Option<Channel> {
    let first_above = (channel.id() as u32).wrapping_add(1);
    let above = mask & u32::MAX.unbounded_shl(first_above);
    lowest(if above == 0 { mask } else { above })
}

const fn lowest(mask: u32) -> Option<Channel> {
    // An empty mask has 32 trailing zeros, and no channel has that id.
    Channel::from_id(mask.trailing_zeros() as u8)
}
