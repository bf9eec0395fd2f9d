//! Dispatches register accesses to the peripherals, and checks that their clocks are on.

use super::state::Bus;
use crate::findings::Rule;

const TIM2: u32 = 0x4000_0000;
const TIM3: u32 = 0x4000_0400;
const TIM4: u32 = 0x4000_0800;
const TIM6: u32 = 0x4000_1000;
const IWDG: u32 = 0x4000_3000;
const USART2: u32 = 0x4000_4400;
const USART3: u32 = 0x4000_4800;
const PWR: u32 = 0x4000_7000;
const DAC: u32 = 0x4000_7400;
const ADC1: u32 = 0x4001_2000;
const SPI1: u32 = 0x4001_3000;
const TIM10: u32 = 0x4001_4400;
const SYSCFG: u32 = 0x4001_3800;
const EXTI: u32 = 0x4001_3C00;
const GPIOA: u32 = 0x4002_0000;
const GPIOC: u32 = 0x4002_0800;
const RCC: u32 = 0x4002_3800;
const FLASH: u32 = 0x4002_3C00;
const DMA1: u32 = 0x4002_6000;
const DMA2: u32 = 0x4002_6400;

const USART_DR: u32 = 0x04;

/// Offsets of a timer's counter and of the register that forces an update.
const CNT: u32 = 0x24;
const EGR: u32 = 0x14;

/// Returns the bus (numbered as in [`crate::peripherals::rcc::Rcc`]) and the bit of a peripheral's
/// clock.
const fn clock_of(base: u32) -> Option<(usize, u32)> {
    Some(match base {
        TIM2 => (3, 0),
        TIM3 => (3, 1),
        TIM4 => (3, 2),
        TIM6 => (3, 4),
        USART2 => (3, 17),
        USART3 => (3, 18),
        PWR => (3, 28),
        DAC => (3, 29),
        ADC1 => (4, 8),
        SPI1 => (4, 12),
        SYSCFG => (4, 14),
        TIM10 => (4, 17),
        GPIOA..=GPIOC => (0, (base - GPIOA) / 0x400),
        DMA1 => (0, 21),
        DMA2 => (0, 22),
        _ => return None,
    })
}

impl Bus {
    /// Splits an address into base and offset; records a broken rule if the peripheral's clock is
    /// off.
    fn locate(&mut self, address: u32) -> (u32, u32) {
        let base = address & !0x3FF;
        if let Some((bus, bit)) = clock_of(base).filter(|(bus, bit)| !self.rcc.is_on(*bus, *bit)) {
            self.broke(
                Rule::ClockOn,
                format!("{address:#010x}: bit {bit} of bus {bus} is off in RCC"),
            );
        }
        (base, address - base)
    }

    fn line_base(&self) -> u32 {
        if self.wiring.usart == 2 {
            USART2
        } else {
            USART3
        }
    }

    /// Reads a peripheral's register; `None` if it is not modelled.
    pub fn register(&mut self, address: u32) -> Option<u32> {
        let (base, offset) = self.locate(address);
        let (now, ratio, line) = (self.time.cycles, self.timer_ratio(), self.line_base());
        match base {
            TIM2 => {
                let value = self.tim2.read(offset, now, ratio)?;
                if offset == CNT && std::mem::take(&mut self.dates_edge) {
                    self.adc.t_us = value;
                }
                Some(value)
            }
            TIM3 => self.encoder.read(offset, self.time.ns()),
            TIM4 => self.tim4.read(offset, now, ratio),
            TIM6 => self.tim6.read(offset, now, ratio),
            TIM10 => self.tim10.read(offset),
            DAC => self.dac.read(offset),
            IWDG => self.iwdg.read(offset, self.time.ns()),
            PWR => self.pwr.read(offset),
            ADC1 => self.own_adc.read(offset),
            DMA1 => self.line_dma.read(offset, now),
            DMA2 => self.dma.read(offset, now),
            SPI1 => self.spi.read(offset),
            SYSCFG => self.syscfg.read(offset),
            EXTI => self.exti.read(offset),
            GPIOA..=GPIOC => {
                self.show_drdy();
                self.gpio[((base - GPIOA) / 0x400) as usize].read(offset)
            }
            RCC => self.rcc.read(offset, self.time.ns()),
            FLASH => self.flash.read(offset),
            _ if base == line => {
                let stolen = self.usart.stolen;
                let value = self.usart.read(offset, self.line_dma.is_on())?;
                if self.usart.stolen > stolen {
                    self.broke(
                        Rule::UsartData,
                        "software reads a byte that the DMA is about to fetch",
                    );
                }
                Some(value)
            }
            _ => None,
        }
    }

    /// Writes a peripheral's register; `None` if it is not modelled.
    pub fn set_register(&mut self, address: u32, value: u32) -> Option<()> {
        let (base, offset) = self.locate(address);
        let (now, ratio, line) = (self.time.cycles, self.timer_ratio(), self.line_base());
        match base {
            TIM2 => {
                self.tim2.write(offset, value, now, ratio)?;
                let detail = || "TIM2 runs, and nobody has written ARR".to_owned();
                self.note(
                    self.tim2
                        .runs_unset()
                        .then(|| (Rule::TimerReload, detail())),
                );
            }
            TIM3 => {
                let was_on = self.encoder.is_on();
                self.encoder.write(offset, value, self.time.ns())?;
                if !was_on && self.encoder.is_on() {
                    self.check_encoder();
                }
            }
            TIM4 => self.tim4.write(offset, value, now, ratio)?,
            TIM6 => {
                self.tim6.write(offset, value, now, ratio)?;
                if offset == EGR && self.tim6.triggers() {
                    self.trigger_dac(now);
                }
            }
            TIM10 => {
                self.tim10.write(offset, value)?;
                self.clock_adc();
            }
            DAC => {
                let was_on = self.dac.is_on();
                self.dac.write(offset, value, self.time.ns())?;
                if !was_on && self.dac.is_on() {
                    self.check_dac();
                }
            }
            IWDG => self.iwdg.write(offset, value, self.time.ns())?,
            PWR => {
                if self.pwr.write(offset, value)? && self.rcc.is_pll_on() {
                    self.broke(Rule::PllOff, "VOS is changed while PLLON");
                }
                self.check_accuracy()?;
            }
            ADC1 => {
                let was_converting = self.own_adc.is_converting();
                let broken = self.own_adc.write(offset, value, self.adc_now())?;
                self.note(broken);
                if !was_converting && self.own_adc.is_converting() {
                    self.check_inputs();
                    self.check_accuracy()?;
                }
            }
            DMA1 => {
                let broken = self.line_dma.write(offset, value, now, 1)?;
                self.note(broken);
            }
            DMA2 => {
                let sequence = self.own_adc.sequence_length();
                let broken = self.dma.write(offset, value, now, sequence)?;
                self.note(broken);
            }
            SPI1 => {
                let was_on = self.spi.is_on();
                self.spi.write(offset, value)?;
                if !was_on && self.spi.is_on() {
                    self.check_spi();
                }
            }
            SYSCFG => {
                self.syscfg.write(offset, value)?;
                self.check_accuracy()?;
            }
            EXTI => self.exti.write(offset, value)?,
            GPIOA..=GPIOC => {
                self.gpio[((base - GPIOA) / 0x400) as usize].write(offset, value)?;
                self.pins_changed();
            }
            RCC => {
                let changed = self.rcc.write(offset, value, self.time.ns())?;
                self.note(changed.broken);
                if changed.clocks {
                    self.change_clocks();
                }
                if let Some((bus, bits)) = changed.resets {
                    self.reset_peripherals(bus, bits)?;
                }
            }
            FLASH => {
                let effect = self.flash.write(offset, value)?;
                self.apply(effect);
                self.check_accuracy()?;
            }
            _ if base == line => {
                self.usart.write(offset, value)?;
                if offset == USART_DR && !std::mem::replace(&mut self.is_line_checked, true) {
                    self.check_line();
                }
            }
            _ => return None,
        }
        Some(())
    }

    /// Resets the peripherals of these bits in RCC; returns `None` if one of them is not modelled.
    fn reset_peripherals(&mut self, bus: usize, bits: u32) -> Option<()> {
        let line = self.line_base();
        let known = [
            TIM2,
            TIM3,
            TIM4,
            TIM6,
            TIM10,
            DAC,
            line,
            PWR,
            ADC1,
            DMA1,
            DMA2,
            SPI1,
            SYSCFG,
            GPIOA,
            GPIOA + 0x400,
            GPIOC,
        ];
        let mut left = bits;
        for base in known {
            let Some((_, bit)) =
                clock_of(base).filter(|(its, bit)| *its == bus && bits >> bit & 1 != 0)
            else {
                continue;
            };
            left &= !(1 << bit);
            match base {
                TIM2 => self.tim2.reset(),
                TIM3 => self.encoder.reset(),
                TIM4 => self.tim4.reset(),
                TIM6 => self.tim6.reset(),
                TIM10 => {
                    self.tim10 = Default::default();
                    self.clock_adc();
                }
                DAC => self.dac.reset(self.time.ns()),
                PWR => self.pwr = crate::peripherals::small::Pwr::new(self.wiring.pwr_cr),
                ADC1 => self.own_adc.reset(),
                DMA1 => self.line_dma.reset(),
                DMA2 => self.dma.reset(),
                SPI1 => self.spi.reset(),
                SYSCFG => self.syscfg = Default::default(),
                GPIOA..=GPIOC => {
                    self.gpio[((base - GPIOA) / 0x400) as usize].reset();
                    self.pins_changed();
                }
                _ => self.usart.reset(),
            }
        }
        (left == 0).then_some(())
    }
}
