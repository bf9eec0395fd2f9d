//! The sensors at the on-chip ADC, and the DMA transfer of their samples to memory.

use super::state::Bus;
use crate::board::Pin;
use crate::findings::Rule;
use crate::peripherals::own_adc::{Converted, Now};

/// Lowest ADC clock with ADCxDC2, hertz (RM0390, SYSCFG_PMC).
const OPTION_2_MIN_HZ: u64 = 30_000_000;

/// Pins by channel: PA0 to PA7, PB0 and PB1, PC0 to PC5 (DS8626, table 7; DS10693, table 10).
const fn pin_of(channel: u8) -> Pin {
    match channel {
        0..=7 => Pin(0, channel),
        8 | 9 => Pin(1, channel - 8),
        _ => Pin(2, channel - 10),
    }
}

impl Bus {
    /// Period of the ADC's clock, processor cycles.
    fn adc_tick(&self) -> u64 {
        self.own_adc.divider() * self.apb_ratio(1)
    }

    pub fn adc_now(&self) -> Now {
        Now {
            cycles: self.time.cycles,
            ns: self.time.ns(),
            apb_hz: self.clocks.pclk[1],
        }
    }

    /// Cycle at which the DMA's next interrupt is due.
    pub fn next_transfer(&self) -> Option<u64> {
        let transfers = self.dma.transfers_to_event()?;
        self.own_adc.ready_after(transfers, self.adc_tick())
    }

    /// Ends all conversions that are due. The DMA fetches each of them.
    pub fn convert(&mut self) {
        let tick = self.adc_tick();
        while let Some(converted) = self.own_adc.advance(self.time.cycles, tick) {
            let data = self.sample(&converted);
            let had_overrun = self.own_adc.has_overrun();
            if self.own_adc.finish(data)
                && let Some((address, is_last)) = self.dma.transfer()
            {
                let value = self.own_adc.transfer(is_last);
                self.put_by_dma(address, &value.to_le_bytes());
            }
            if self.own_adc.has_overrun() && !had_overrun {
                self.broke(
                    Rule::AdcOverrun,
                    "a conversion ends before the one before is fetched",
                );
            }
        }
    }

    fn sample(&mut self, converted: &Converted) -> u16 {
        let pin = pin_of(converted.channel);
        let Some(input) = self.wiring.inputs.iter().position(|wired| *wired == pin) else {
            return 0;
        };
        let at_ns = self.time.ns_at(converted.sampled);
        let zero_ns = *self.scene_zero_ns.get_or_insert(at_ns);
        let t_s = at_ns.saturating_sub(zero_ns) as f64 * 1e-9;
        self.sensors.sample(input as u8, t_s)
    }

    /// Checks the rules for the bits that lower the ADC's noise; returns `None` if the chip does
    /// not have a bit that is set.
    pub fn check_accuracy(&mut self) -> Option<()> {
        let (option_1, option_2) = (self.pwr.has_adcdc1(), self.syscfg.has_adc_dc2());
        if (option_1 || option_2) && !self.wiring.has_adc_accuracy {
            return None;
        }
        let adc_hz = self.clocks.pclk[1] / self.own_adc.divider();
        if option_1 && option_2 {
            self.broke(Rule::AdcAccuracy, "ADCDC1 and ADCxDC2 are both set");
        } else if option_1 && self.flash.prefetches() {
            self.broke(Rule::AdcAccuracy, "ADCDC1 with the prefetch on");
        } else if option_2 && self.own_adc.is_converting() && adc_hz < OPTION_2_MIN_HZ {
            let detail = format!("ADCxDC2 with the converter at {adc_hz} Hz");
            self.broke(Rule::AdcAccuracy, detail);
        }
        Some(())
    }

    /// Checks, when conversions start, that each pin is analogue and belongs to a sensor (RM0090,
    /// 8.3.12).
    pub fn check_inputs(&mut self) {
        for place in 0..self.own_adc.sequence_length() {
            let channel = self.own_adc.channel(place);
            let pin = pin_of(channel);
            let is_analogue = self.gpio[usize::from(pin.0)].mode(pin.1) == 3;
            if !is_analogue || !self.wiring.inputs.contains(&pin) {
                let detail = format!("channel {channel}: {pin:?} is no analogue input");
                self.broke(Rule::PinFunction, detail);
            }
        }
    }
}
