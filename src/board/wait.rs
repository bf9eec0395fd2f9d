//! Delays before interrupts are on.

use super::clock::now_us;
use embedded_hal::delay::DelayNs;

pub struct Wait;

impl DelayNs for Wait {
    fn delay_ns(&mut self, duration_ns: u32) {
        // Add a microsecond, because the counter may be about to step.
        let duration_us = duration_ns.div_ceil(1000).saturating_add(1);
        let from_us = now_us();
        while now_us().wrapping_sub(from_us) < duration_us {}
    }
}
