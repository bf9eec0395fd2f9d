//! Events that no instruction causes: a byte ends, a timer wraps, DRDY falls, a buffer fills, the
//! watchdog expires.

use super::state::Bus;
use crate::board::{AdcPins, Pin};
use crate::findings::Rule;

/// Interrupt numbers (RM0090, table 61).
const IRQ_EXTI4: u16 = 10;
const IRQ_TIM4: u16 = 30;
const IRQ_USART2: u16 = 38;
const IRQ_USART3: u16 = 39;
const IRQ_TIM6_DAC: u16 = 54;
pub(super) const IRQ_OTG_FS: u16 = 67;

impl Bus {
    /// Duration of a byte on the serial line, processor cycles.
    pub fn byte_cycles(&self) -> u64 {
        (self.usart.byte_clocks() * self.apb_ratio(0)).max(1)
    }

    /// Cycle of the next event that no instruction causes.
    pub fn next_event(&self) -> u64 {
        let bite = self.iwdg.next_event_ns().map(|ns| self.time.cycle_at(ns));
        let events = [
            self.spi.next_event(),
            self.usart.next_event(self.line_dma.is_on()),
            self.tim4.next_event(self.timer_ratio()),
            self.tim6.next_event(self.timer_ratio()),
            self.drdy_falls,
            self.usb_rises,
            self.next_transfer(),
            bite,
        ];
        events.into_iter().flatten().min().unwrap_or(u64::MAX)
    }

    /// Updates the time of the next falling edge of DRDY. Call this after anything that may change
    /// the ADC's schedule.
    pub fn expect_drdy(&mut self) {
        self.drdy_falls = self
            .adc
            .chip
            .next_drdy_fall_ns()
            .map(|ns| self.time.cycle_at(ns).max(self.time.cycles + 1));
    }

    /// Processes all events that are due, and sets the interrupt lines.
    pub fn catch_up(&mut self) {
        let now = self.time.cycles;
        let overruns = (self.spi.overruns, self.usart.overruns);
        self.spi.advance(now);
        self.shift();
        self.convert();
        self.receive();
        self.usart.send(now, self.byte_cycles());
        self.tim4.advance(now, self.timer_ratio());
        if let Some(cycle) = self
            .tim6
            .advance(now, self.timer_ratio())
            .filter(|_| self.tim6.triggers())
        {
            self.trigger_dac(cycle);
        }
        if self.drdy_falls.is_some_and(|cycle| cycle <= now) {
            self.drdy_edge();
        }
        if self.spi.overruns > overruns.0 {
            self.broke(
                Rule::SpiOverrun,
                "a byte arrives before the one before is read",
            );
        }
        if self.usart.overruns > overruns.1 {
            self.broke(
                Rule::UsartOverrun,
                "a byte arrives before the one before is read",
            );
        }
        if self
            .iwdg
            .next_event_ns()
            .is_some_and(|ns| ns <= self.time.ns())
            && !self.has_bitten
        {
            self.has_bitten = true;
            self.broke(Rule::Watchdog, "nobody has fed it");
        }
        self.scs.now = now;
        if self.rcc.requests_nmi() {
            self.scs.request_nmi();
        }
        self.scs.set_line(IRQ_EXTI4, self.exti.is_requested(4));
        self.scs.set_line(IRQ_TIM4, self.tim4.is_requested());
        self.scs.set_line(IRQ_TIM6_DAC, self.tim6.is_requested());
        for stream in [&self.dma, &self.line_dma] {
            self.scs.set_line(stream.irq(), stream.is_requested());
        }
        let irq = if self.wiring.usart == 2 {
            IRQ_USART2
        } else {
            IRQ_USART3
        };
        self.scs.set_line(irq, self.usart.is_requested());
        // Nothing in the model serves USB, so the interrupt stays pending.
        if self.usb_rises.take_if(|cycle| *cycle <= now).is_some() {
            self.scs.set_line(IRQ_OTG_FS, true);
        }
    }

    /// Receives bytes from the serial line. The DMA writes the bytes that it fetches to memory.
    fn receive(&mut self) {
        let (now, byte_cycles) = (self.time.cycles, self.byte_cycles());
        while let Some(byte) = self.usart.receive(now, byte_cycles, self.line_dma.is_on()) {
            if let Some((address, _)) = self.line_dma.transfer() {
                self.put_by_dma(address, &[byte]);
            }
        }
    }

    pub fn put_by_dma(&mut self, address: u32, bytes: &[u8]) {
        let at = address.wrapping_sub(0x2000_0000) as usize;
        if let Some(place) = self.ram.get_mut(at..at + bytes.len()) {
            place.copy_from_slice(bytes);
        }
    }

    /// Processes the falling edges of DRDY since the last call.
    fn drdy_edge(&mut self) {
        let Some(AdcPins {
            drdy: Pin(port, pin),
            ..
        }) = self.wiring.adc
        else {
            return;
        };
        self.adc.chip.advance_to(self.time.ns());
        if self.syscfg.port(pin) == port {
            self.exti.fall(pin);
        }
        self.expect_drdy();
    }

    pub fn trigger_dac(&mut self, cycle: u64) {
        /// Delay from the trigger to DOR1, cycles of APB1 (RM0090, 14.3.4).
        const TRIGGER_CYCLES: u64 = 3;
        self.dac
            .trigger(self.time.ns_at(cycle + TRIGGER_CYCLES * self.apb_ratio(0)));
    }

    /// Starts the next byte on SPI, if one is waiting.
    fn shift(&mut self) {
        let Some(out) = self.spi.take_next() else {
            return;
        };
        let now = self.time.cycles;
        let bit = self.spi.divider() * self.apb_ratio(1);
        // In mode 0 the first edge is half a bit after the start, and the byte ends with the last
        // falling edge.
        let (first_ns, last_ns) = (
            self.time.ns_at(now + bit / 2),
            self.time.ns_at(now + 8 * bit),
        );
        let (incoming, broken) = self.adc.exchange(out, first_ns, last_ns);
        self.spi
            .begin(incoming, now + 8 * bit - bit / 2, now + 8 * bit);
        self.note(broken);
        self.expect_drdy();
    }
}
