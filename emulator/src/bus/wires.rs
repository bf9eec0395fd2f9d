//! Models the wiring of the pins, and the clocks, and checks the rules for both.

use super::events::IRQ_OTG_FS;
use super::state::Bus;
use crate::board::{AdcPins, Pin};
use crate::findings::Rule;
use crate::peripherals::gpio::Gpio;
use crate::peripherals::pwm::Wave;
use crate::peripherals::rcc::HSI_HZ;

/// Alternate functions (DS8626, table 9): TIM3, TIM10, SPI1 and the USARTs 1 to 3.
const AF_TIM3: u32 = 2;
const AF_TIM10: u32 = 3;
const AF_SPI1: u32 = 5;
const AF_USART: u32 = 7;

/// Cycles after the ROM's loader until USB requests its interrupt: the image has set its own
/// vectors by then.
const USB_CYCLES: u64 = 100;

/// Highest APB clock at which SCK's pad may have medium speed, hertz (from memory: the errata
/// sheets have a table for 30 pF and 2.7 V; medium is enough at 42 MHz and not at 84 MHz).
const MEDIUM_PAD_HZ: u64 = 42_000_000;
/// Lowest pad speed for 84 MHz: fast.
const FAST: u32 = 2;
/// Lowest pad speed for 25 MHz at 50 pF: medium (DS8626, I/O AC characteristics).
const MEDIUM: u32 = 1;
/// Highest clock of the ADC, hertz (SBAS297G).
const ADC_CLOCK_HZ: u32 = 16_000_000;

impl Bus {
    pub fn port(&self, pin: Pin) -> &Gpio {
        &self.gpio[usize::from(pin.0)]
    }

    /// Level of a wire to the ADC: driven by an output, or else set by the wiring page's pull
    /// resistors.
    fn level(&self, pin: Pin, pulled: bool) -> bool {
        self.port(pin).driven(pin.1).unwrap_or(pulled)
    }

    /// Sets a level from outside. A falling edge reaches EXTI if SYSCFG selects the port.
    pub fn set_outside(&mut self, Pin(port, pin): Pin, high: bool) {
        let outside = &mut self.gpio[usize::from(port)].outside;
        let was_high = *outside >> pin & 1 != 0;
        *outside = *outside & !(1 << pin) | u16::from(high) << pin;
        if was_high && !high && self.syscfg.port(pin) == port {
            self.exti.fall(pin);
        }
    }

    pub fn pins_changed(&mut self) {
        self.clock_adc();
        let Some(adc) = self.wiring.adc else { return };
        let now_ns = self.time.ns();
        let start = self.level(adc.start, false);
        let reset = self.level(adc.reset, true);
        let cs_low = !self.level(adc.cs, true);
        let broken = self.adc.set_cs(cs_low, now_ns, self.spi.is_busy());
        self.note(broken);
        self.adc.set_start(start, now_ns);
        self.adc.set_reset(reset, now_ns);
        self.expect_drdy();
    }

    /// Copies DRDY's level to the pin that reads it.
    pub fn show_drdy(&mut self) {
        let Some(AdcPins {
            drdy: Pin(port, pin),
            ..
        }) = self.wiring.adc
        else {
            return;
        };
        let high = self.adc.chip.drdy_high(self.time.ns());
        let outside = &mut self.gpio[usize::from(port)].outside;
        *outside = *outside & !(1 << pin) | u16::from(high) << pin;
    }

    pub fn change_clocks(&mut self) {
        // Check nominal clocks: firmware cannot avoid an oscillator's error.
        let (clocks, pll) = self.rcc.clocks(&self.wiring, HSI_HZ);
        let limits = self.wiring.limits_hz;
        if self
            .rcc
            .hse()
            .is_some_and(|is_bypassed| is_bypassed != self.wiring.is_bypassed)
        {
            self.broke(
                Rule::ClockLimit,
                "HSEBYP does not fit the board's oscillator",
            );
        }
        let is_above = [clocks.hclk, clocks.pclk[0], clocks.pclk[1]]
            .iter()
            .zip(limits)
            .any(|(hz, limit)| *hz > limit)
            || clocks.hclk > self.pwr.limit_hz();
        if is_above {
            self.broke(Rule::ClockLimit, format!("{clocks:?}"));
        }
        if let Some([input, vco]) = pll
            && !((1_000_000..=2_000_000).contains(&input)
                && (100_000_000..=432_000_000).contains(&vco))
        {
            self.broke(
                Rule::ClockLimit,
                format!("the PLL's input {input} Hz, its VCO {vco} Hz"),
            );
        }
        // Each 30 MHz need one more wait state at 2.7 to 3.6 V (RM0090, table 10).
        let needed = clocks.hclk.saturating_sub(1) / 30_000_000;
        if self.flash.latency() < needed {
            let detail = format!("{} wait states at {} Hz", self.flash.latency(), clocks.hclk);
            self.broke(Rule::WaitStates, detail);
        }
        (self.clocks, _) = self.rcc.clocks(&self.wiring, self.rcc.hsi_hz);
        let clocks = self.clocks;
        self.time.change(clocks.hclk.max(1));
        self.clock_adc();
        self.expect_drdy();
    }

    /// Stops the external oscillator. With the clock security system the processor continues with
    /// HSI and takes an NMI; without it, a processor that runs from HSE stops.
    pub fn stop_oscillator(&mut self) {
        let is_source = self.rcc.hse().is_some();
        self.rcc.hse_is_dead = true;
        if self.rcc.secure() {
            self.change_clocks();
        } else if is_source {
            self.has_stopped = true;
            self.usart.lose_arriving();
        }
        self.attend();
    }

    /// Sets the state that the ROM bootloader leaves behind: running from the PLL with matching
    /// flash wait states, HSE on, ROM mapped at 0, USB interrupt enabled and about to fire.
    pub fn leave_as_rom_loader(&mut self) {
        // Three wait states, for 96 MHz.
        let _ = self.flash.write(0, 3);
        self.rcc.leave_pll_on();
        self.syscfg.memrmp = 1;
        self.scs.unmask(IRQ_OTG_FS);
        self.usb_rises = Some(USB_CYCLES);
        self.change_clocks();
    }

    /// Processor cycles per timer clock on APB1. If the APB clock is divided, the timer clock is
    /// twice the APB clock (RM0090, 7.2).
    pub fn timer_ratio(&self) -> u64 {
        let divider = self.apb_ratio(0);
        if divider == 1 { 1 } else { divider / 2 }
    }

    pub fn apb_ratio(&self, apb: usize) -> u64 {
        self.clocks.hclk / self.clocks.pclk[apb].max(1)
    }

    /// Checks the rules for SPI when it is switched on.
    pub fn check_spi(&mut self) {
        let Some(adc) = self.wiring.adc else {
            return self.broke(Rule::PinFunction, "SPI1 is on, and nothing is wired to it");
        };
        let Pin(port, sck) = adc.sck;
        self.check_functions(&[adc.sck, adc.miso, adc.mosi], AF_SPI1);
        if self.port(adc.cs).driven(adc.cs.1).is_none() {
            self.broke(Rule::PinFunction, "CS is no output");
        }
        let apb_hz = self.clocks.pclk[1];
        let speed = self.gpio[usize::from(port)].speed(sck);
        if apb_hz > MEDIUM_PAD_HZ && speed < FAST {
            self.broke(
                Rule::PadSpeed,
                format!("SCK's OSPEEDR is {speed} at APB2 {apb_hz} Hz"),
            );
        }
        if !self.spi.fits_adc() {
            self.broke(Rule::SpiMode, "not mode 0, 8 bits, most significant first");
        }
        self.check_sclk();
    }

    fn check_sclk(&mut self) {
        let sclk_hz = self.clocks.pclk[1] / self.spi.divider();
        let clock_hz = u64::from(self.adc.clock_hz());
        if self.spi.is_on() && clock_hz > 0 && sclk_hz * 2 > clock_hz {
            self.broke(Rule::SpiClock, format!("SCLK {sclk_hz} Hz"));
        }
    }

    /// Output of TIM10 on its pin, in timer clocks; `None` if there is no output.
    fn clock_output(&self) -> Option<Wave> {
        let Pin(_, pin) = self.wiring.clock;
        let has_function = self.port(self.wiring.clock).function(pin) == Some(AF_TIM10);
        self.tim10.wave().filter(|_| has_function)
    }

    /// Frequency of the clock that the board outputs for the ADC, hertz, rounded; 0 without a
    /// clock.
    pub fn timed_clock_hz(&self) -> u32 {
        // The clock of the timers on APB2 follows the same rule as on APB1.
        let [apb_hz, hclk_hz] = [self.clocks.pclk[1], self.clocks.hclk];
        let timer_hz = if apb_hz == hclk_hz {
            apb_hz
        } else {
            2 * apb_hz
        };
        self.clock_output().map_or(0, |wave| {
            let period = u64::from(wave.period);
            ((timer_hz + period / 2) / period) as u32
        })
    }

    /// Passes the board's clock output to the ADC, if it is wired there, and checks the rules if
    /// the clock has changed.
    pub fn clock_adc(&mut self) {
        let clock_hz = self.timed_clock_hz();
        if std::mem::replace(&mut self.clock_output_hz, clock_hz) != clock_hz {
            self.check_clock_output();
        }
        if self.clkio_is_wired && self.adc.clock_hz() != clock_hz {
            self.adc.chip.set_clock(self.time.ns(), clock_hz);
            self.expect_drdy();
            self.check_sclk();
        }
    }

    fn check_clock_output(&mut self) {
        let Some(Wave { period, high }) = self.clock_output() else {
            return;
        };
        let clock_hz = self.clock_output_hz;
        if clock_hz > ADC_CLOCK_HZ || !(2 * period..=3 * period).contains(&(5 * high)) {
            let detail = format!("{clock_hz} Hz, high for {high} of {period}");
            self.broke(Rule::AdcClock, detail);
        }
        let Pin(_, pin) = self.wiring.clock;
        let speed = self.port(self.wiring.clock).speed(pin);
        if speed < MEDIUM {
            let detail = format!("the clock's OSPEEDR is {speed} at {clock_hz} Hz");
            self.broke(Rule::PadSpeed, detail);
        }
    }

    /// Checks the rules for the serial line when its first byte leaves.
    pub fn check_line(&mut self) {
        self.check_functions(&[self.wiring.tx, self.wiring.rx], AF_USART);
    }

    /// Checks the rules for the encoder when its counter is switched on.
    pub fn check_encoder(&mut self) {
        match self.wiring.stylus {
            Some(stylus) => self.check_functions(&stylus.channels, AF_TIM3),
            None => self.broke(Rule::PinFunction, "TIM3 counts, and nothing is wired to it"),
        }
    }

    /// Checks the rules for the DAC when it is switched on: its pin must already be analogue
    /// (RM0090, 14.3.1).
    pub fn check_dac(&mut self) {
        let is_analogue = |pin: Pin| self.port(pin).mode(pin.1) == 3;
        if !self
            .wiring
            .stylus
            .is_some_and(|stylus| is_analogue(stylus.output))
        {
            self.broke(
                Rule::PinFunction,
                "the converter is on, and its pin is not analogue",
            );
        }
    }

    fn check_functions(&mut self, pins: &[Pin], expected: u32) {
        for pin in pins {
            let has = self.port(*pin).function(pin.1);
            if has != Some(expected) {
                let detail = format!("{pin:?} has {has:?} in place of function {expected}");
                self.broke(Rule::PinFunction, detail);
            }
        }
    }
}
