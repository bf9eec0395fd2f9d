//! The chip with its pins: set up anew as often as it takes.

use super::{Reset, Spi, Start, Wait};
use ads1258::Ads1258;
use ridgetone::settings::SCAN;

/// The ADS1258 and what it is driven by.
pub struct Chip {
    /// Its registers and conversions.
    pub adc: Ads1258<Spi>,
    /// START.
    pub start: Start,
    /// RESET.
    pub reset: Reset,
}

impl Chip {
    /// Resets the chip, writes its registers, reads them back and starts the scan.
    pub fn set_up(&mut self) -> bool {
        self.adc.stop(&mut self.start).is_ok()
            && self.adc.reset_by_pin(&mut self.reset, &mut Wait).is_ok()
            && self.adc.configure(&SCAN).is_ok()
            && self.adc.start(&mut self.start).is_ok()
    }

    /// Whether the registers still hold what was written.
    pub fn is_set_up(&mut self) -> bool {
        self.adc.verify(&SCAN).is_ok()
    }
}
