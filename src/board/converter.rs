//! The ADS1258's pins on the STM32F4 boards: SPI1 on PA5 to PA7, DRDY on a line of EXTI.
//!
//! The time of a DRDY edge is read at the start of its interrupt: 12 cycles (0.07 us) late, or a
//! few microseconds if interrupts were masked. A timer's input capture would be exact, but the
//! boards' DRDY pins are not on a free timer channel.

use super::chip_clock::TimerClock;
use super::chosen::{Cs, DrdyPin, Reset, Start};
use super::{CLOCKS, pin};
use ads1258::{Ads1258, SettledCs};
use embedded_hal::delay::DelayNs;
use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
use ridgetone_finger::Wiring;
use ridgetone_finger::converter::{Facts, WiredAds1258};
use stm32f4xx_hal::gpio::{
    Edge, ExtiPin, Input, Output, PA5, PA6, PA7, PB8, PinState, Pull, Speed,
};
use stm32f4xx_hal::pac::{EXTI, SPI1, SYSCFG, TIM10};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::spi;

/// Time from power-up to the first register access, microseconds: 2^18 tCLK are 16.7 ms at 15.72864
/// MHz, and the chip's own crystal may take 150 ms to start (SBAS297G, typical after power-down).
pub const POWER_UP_US: u32 = 200_000;

/// SPI clock, hertz: at most half of the chip's clock.
const SPI_HZ: u32 = CLOCKS.spi1_hz(15_728_640 / 2);

/// Slowest clock of the chip for which the CS times are long enough, hertz.
const CHIP_MIN_HZ: u32 = 13_200_000;

/// The ADS1258 on SPI1, with START, RESET and a timer for its clock.
pub type Converter = WiredAds1258<Spi, Start<Output>, Reset<Output>, TimerClock>;

pub const WIRING: Wiring = Wiring {
    converter: &Facts::of::<Converter>(),
};

type Spi = ExclusiveDevice<spi::Spi<SPI1>, SettledCs<Cs<Output>, Cycles>, NoDelay>;

/// Delays by processor cycles, up to 20 ms.
pub struct Cycles;

impl DelayNs for Cycles {
    #[inline]
    fn delay_ns(&mut self, ns: u32) {
        cortex_m::asm::delay(CLOCKS.cycles(ns));
    }
}

pub struct Drdy {
    pin: DrdyPin<Input>,
    exti: EXTI,
    edge_us: u32,
}

impl Drdy {
    pub fn new(mut exti: EXTI, syscfg: SYSCFG, rcc: &mut Rcc) -> Self {
        let mut syscfg = syscfg.constrain(rcc);
        // Pull-up: without a chip the pin would float, and every noise edge would cost a read.
        let mut pin = pin::<DrdyPin>().internal_resistor(Pull::Up);
        pin.make_interrupt_source(&mut syscfg);
        pin.trigger_on_edge(&mut exti, Edge::Falling);
        pin.enable_interrupt(&mut exti);
        Self {
            pin,
            exti,
            edge_us: 0,
        }
    }
}

impl ridgetone_finger::tasks::DrdyPin for Drdy {
    #[inline(always)]
    fn acknowledge(&mut self) -> Option<bool> {
        self.edge_us = super::clock::now_us();
        let has_fallen = self.pin.check_interrupt();
        self.pin.clear_interrupt_pending_bit();
        // The write must reach EXTI before the handler returns, or the interrupt fires twice.
        cortex_m::asm::dsb();
        let is_low = self.pin.is_low();
        (has_fallen || is_low).then_some(is_low)
    }

    fn edge_us(&self) -> u32 {
        self.edge_us
    }

    fn mute(&mut self) {
        self.pin.disable_interrupt(&mut self.exti);
    }

    fn unmute(&mut self) {
        // A masked edge sets the pending bit too (RM0090): discard it.
        self.pin.clear_interrupt_pending_bit();
        self.pin.enable_interrupt(&mut self.exti);
    }
}

/// Sets up the chip's pins: START low, RESET high.
pub fn new(spi1: SPI1, timer: TIM10, rcc: &mut Rcc) -> Converter {
    let start = pin::<Start>().into_push_pull_output_in_state(PinState::Low);
    let reset = pin::<Reset>().into_push_pull_output_in_state(PinState::High);
    let spi = bus(spi1, rcc);
    let clock = TimerClock::new(timer, pin::<PB8>(), rcc);
    WiredAds1258::new(Ads1258::new(spi), start, reset).clocked_by(clock)
}

fn bus(spi1: SPI1, rcc: &mut Rcc) -> Spi {
    let mut cs = pin::<Cs>().into_push_pull_output_in_state(PinState::High);
    let mut sck = pin::<PA5>().into_alternate::<5>();
    let miso = pin::<PA6>().into_alternate::<5>();
    let mut mosi = pin::<PA7>().into_alternate::<5>();
    // The slowest pin setting is too slow above 4 MHz (datasheets DS8626 and DS10693, I/O AC
    // characteristics).
    cs.set_speed(Speed::Medium);
    // SPI1 takes its input clock from this pad: at 84 MHz, medium speed delays it so much that the
    // last bit may be wrong (errata ES0182 and ES0298, "corrupted last bit of data and/or CRC ...
    // delayed SCK feedback").
    sck.set_speed(Speed::High);
    mosi.set_speed(Speed::Medium);
    let bus = spi::Spi::new(
        spi1,
        (Some(sck), Some(miso), Some(mosi)),
        ads1258::MODE,
        SPI_HZ.Hz(),
        rcc,
    );
    let cs = SettledCs::new(cs, Cycles, CHIP_MIN_HZ, SPI_HZ);
    // Setting CS cannot fail.
    match ExclusiveDevice::new_no_delay(bus, cs) {
        Ok(spi) => spi,
        Err(never) => match never {},
    }
}
