//! Today's intake behind the calls of `ridgetone::acquire`, until that is there.

use ads1258::Ads1258;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;
use heapless::spsc::Producer;
use ridgetone::frame::TimedConversion;
use ridgetone::settings::SCAN;
use ridgetone::tally::Tally;

#[allow(dead_code)]
#[derive(PartialEq)]
pub enum Drdy {
    Listen,
    Watch,
    Mute,
}

pub struct Acquisition<SPI, START, RESET> {
    adc: Ads1258<SPI>,
    start: START,
    reset: RESET,
}

impl<SPI: SpiDevice, START: OutputPin, RESET: OutputPin> Acquisition<SPI, START, RESET> {
    pub const fn new(adc: Ads1258<SPI>, start: START, reset: RESET) -> Self {
        Self { adc, start, reset }
    }

    pub fn set_up(&mut self, wait: &mut impl DelayNs) -> bool {
        self.adc.stop(&mut self.start).is_ok()
            && self.adc.reset_by_pin(&mut self.reset, wait).is_ok()
            && self.adc.configure(&SCAN).is_ok()
            && self.adc.start(&mut self.start).is_ok()
    }

    pub fn edge(
        &mut self,
        edge_us: impl FnOnce() -> u32,
        samples: &mut Producer<'_, TimedConversion>,
        tally: &Tally,
    ) -> Drdy {
        ridgetone::intake::take_in(&mut self.adc, edge_us, samples, tally);
        Drdy::Listen
    }

    pub fn nothing(&mut self, _edge_us: u32, _tally: &Tally) -> Drdy {
        Drdy::Listen
    }

    pub fn is_quiet(&self, _now_us: u32) -> bool {
        true
    }

    pub fn watch(&mut self, _now_us: u32, tally: &Tally, wait: &mut impl DelayNs) {
        if self.adc.verify(&SCAN).is_err() && self.adc.verify(&SCAN).is_err() {
            tally.chip_restarted();
            self.set_up(wait);
        }
    }
}
