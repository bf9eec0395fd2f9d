//! The stylus's board: an Adafruit Feather STM32F405 Express with an encoder and an actuator in
//! place of a finger. Register access only.
//!
//! The pins are listed in `teletaction/README.md`. Files for any STM32F4 are shared with the
//! finger, from `src/board/`.
//!
//! Two timers work without the processor: TIM3 counts all four edges of the encoder's period; TIM6
//! triggers the converter, which then outputs the code that the previous trigger's interrupt left
//! in the holding register.

// As in `src/board/`: registers and linker symbols.
#![allow(unsafe_code)]

#[path = "../../src/board/clock.rs"]
mod clock;
#[path = "../../src/board/clocks.rs"]
mod clocks;
#[path = "../../src/board/crash.rs"]
mod crash;
#[path = "../../src/board/hard_fault.rs"]
mod hard_fault;
#[macro_use]
#[path = "../../src/board/interrupts.rs"]
mod interrupts;
#[macro_use]
#[path = "../../src/board/serial_line.rs"]
mod serial_line;
#[path = "../../src/board/stack.rs"]
mod stack;
#[path = "../../src/board/stm32f4.rs"]
mod stm32f4;

pub use clock::now_us;
pub use stack::{word as stack_word, words as stack_words};
pub use stm32f4::{acknowledge_heartbeat, feed_watchdog, restart, sleep};

use clocks::{Clocks, Oscillator};
use ridgetone_proto::boot::Boot;
use ridgetone_teletaction::stylus::SAMPLE_US;
use stm32f4xx_hal::gpio::Pull;
use stm32f4xx_hal::pac::{self, DAC, RCC, TIM3, TIM6, USART3};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Enable, Reset};

pub type SerialLine = serial_line::SerialLine<USART3>;
pub type LineReceiver = serial_line::LineReceiver<USART3>;

pub const CLOCKS: Clocks = Clocks {
    oscillator: Oscillator::Crystal(12),
    sysclk_mhz: 168,
    apb1_mhz: 42,
    apb2_mhz: 84,
    vos: None,
};

interrupts! {
    LINE: USART3,
    SAMPLE: TIM6_DAC,
    REPORT: OTG_HS_EP1_IN,
    REQUESTS: OTG_HS_WKUP,
}

line! { USART3: Stream1, 1, DMA1_STREAM1 }

/// TIM6 prescaler for a count per microsecond.
const MICROSECONDS: u16 = CLOCKS.apb1_timers_mhz() as u16 - 1;

/// Reload value of TIM6: one less than the microseconds of a sample.
const RELOAD: u16 = SAMPLE_US as u16 - 1;

/// The board's parts for the tasks.
pub struct Board {
    pub samples: Samples,
    pub line: (SerialLine, LineReceiver),
    pub boot: Boot,
}

/// The encoder, the converter and their timers.
pub struct Samples(());

impl Samples {
    /// Clears the trigger's interrupt. Returns the encoder's counter, the board time, and the
    /// microseconds since the trigger.
    #[inline(always)]
    pub fn read(&mut self) -> (u16, u32, u32) {
        // SAFETY: nothing else uses these timers once they run, and only the status bit is written.
        unsafe {
            let counter = (*TIM3::ptr()).cnt().read().bits() as u16;
            (*TIM6::ptr()).sr().write(|w| w.bits(0));
            let late_us = (*TIM6::ptr()).cnt().read().bits();
            (counter, now_us(), late_us)
        }
    }

    /// Leaves the code for the next trigger. Returns true if that trigger has already occurred.
    #[inline(always)]
    pub fn write(&mut self, code: u16) -> bool {
        // SAFETY: as above; the converter takes the lower 12 bits.
        unsafe {
            (*DAC::ptr()).dhr12r1().write(|w| w.bits(code.into()));
            // The write must complete before the status is read.
            cortex_m::asm::dsb();
            (*TIM6::ptr()).sr().read().uif().bit_is_set()
        }
    }
}

pub fn init(device: pac::Peripherals) -> Board {
    let boot = stm32f4::begin(&device);
    let (mut rcc, oscillator) = stm32f4::start_clocks(device.RCC, device.TIM2, device.TIM4);
    let gpioa = device.GPIOA.split(&mut rcc);
    let gpiob = device.GPIOB.split(&mut rcc);
    let gpioc = device.GPIOC.split(&mut rcc);
    // Before the converter is enabled: otherwise the pin's input draws current (RM0090, 14.3.1).
    gpioa.pa4.into_analog();
    // Pull-up: open-collector encoders need it, and unconnected inputs must not float.
    gpioc
        .pc6
        .into_alternate::<2>()
        .set_internal_resistor(Pull::Up);
    gpioc
        .pc7
        .into_alternate::<2>()
        .set_internal_resistor(Pull::Up);
    let rx = gpiob.pb11.into_alternate::<7>().internal_resistor(Pull::Up);
    start_encoder(device.TIM3, &mut rcc);
    start_converter(device.DAC, &mut rcc);
    start_samples(device.TIM6, &mut rcc);
    Board {
        samples: Samples(()),
        line: SerialLine::new(device.USART3, gpiob.pb10, rx, device.DMA1, &mut rcc),
        boot: Boot { oscillator, ..boot },
    }
}

/// TIM3 counts every edge of both channels, up or down (RM0090, 18.3.12 and 18.4).
fn start_encoder(timer: TIM3, rcc: &mut RCC) {
    /// CC1S and CC2S: TI1 and TI2. IC1F and IC2F: a level counts after 6 samples at 84 MHz / 8,
    /// 0.57 us; the edges of a channel are 3.3 us apart at 3 m/s and 5 um.
    const INPUTS: u32 = 0b01 | 0b1000 << 4 | 0b01 << 8 | 0b1000 << 12;
    /// SMS: encoder mode 3.
    const BOTH_CHANNELS: u32 = 0b011;
    TIM3::enable(rcc);
    TIM3::reset(rcc);
    // SAFETY: values of the manual's tables.
    unsafe {
        timer.ccmr1_input().write(|w| w.bits(INPUTS));
        timer.smcr().write(|w| w.bits(BOTH_CHANNELS));
        timer.arr().write(|w| w.bits(u16::MAX.into()));
    }
    timer.cr1().write(|w| w.cen().set_bit());
}

/// Channel 1, triggered by TIM6 (RM0090, 14.5.1), starts at code 0. Its buffer is off: it would
/// stop 0.2 V before both rails, which causes a step when it is switched on and cuts the largest
/// amplitudes (DS8626, DAC characteristics).
fn start_converter(converter: DAC, rcc: &mut RCC) {
    /// EN1, BOFF1 and TEN1; TSEL1 0: TIM6's TRGO.
    const ON: u32 = 1 | 1 << 1 | 1 << 2;
    DAC::enable(rcc);
    DAC::reset(rcc);
    // SAFETY: bits of the manual's table.
    converter.cr().write(|w| unsafe { w.bits(ON) });
}

/// TIM6 triggers the converter and requests the sample interrupt at each update (RM0090, 20.4).
fn start_samples(timer: TIM6, rcc: &mut RCC) {
    /// MMS: the update is TRGO.
    const UPDATE: u32 = 0b010 << 4;
    TIM6::enable(rcc);
    TIM6::reset(rcc);
    // SAFETY: values of the manual's tables.
    unsafe {
        timer.psc().write(|w| w.bits(MICROSECONDS.into()));
        timer.arr().write(|w| w.bits(RELOAD.into()));
        timer.cr2().write(|w| w.bits(UPDATE));
        // Loads the prescaler now, which is itself an update.
        timer.egr().write(|w| w.ug().set_bit());
        timer.sr().write(|w| w.bits(0));
    }
    timer.dier().write(|w| w.uie().set_bit());
    timer.cr1().write(|w| w.cen().set_bit());
}
