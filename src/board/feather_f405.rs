//! Adafruit Feather STM32F405 Express (product 4382), 168 MHz from its 12 MHz crystal.
//!
//! Its pins are in `docs/guide/2-build.md`, which a test compares with this file.
//!
//! Telemetry leaves on TX (PB10, USART3, AF7), requests arrive on RX (PB11), at 921600 baud, 8N1.
//! The baud rate generator divides 42 MHz by 46 and is 0.93 % slow, which every receiver tolerates
//! (8N1 allows about 4 %).
//!
//! A timer's input capture would date the edges of DRDY exactly, if DRDY were on D6 (PC6, TIM3 CH1)
//! and RESET on A4.

use super::chip_clock::TimerClock;
use super::stm32f4::{self, External};
use super::{converter, parts, serial_line};
use ads1258::Ads1258;
use ridgetone_finger::Wiring;
use ridgetone_finger::converter::{Facts, WiredAds1258};
use ridgetone_proto::boot::Boot;
use stm32f4xx_hal::gpio::{Output, PC5, PC6, PinState, Pull};
use stm32f4xx_hal::pac::{self, USART3};
use stm32f4xx_hal::prelude::*;

pub use super::converter::POWER_UP_US;
pub use super::flash::SettingsFlash;
pub use stm32f4::{acknowledge_heartbeat, feed_watchdog, restart, sleep};

pub type Converter = WiredAds1258<converter::Spi<'A', 4>, PC5<Output>, PC6<Output>, TimerClock>;
pub type Drdy = converter::Drdy<'C', 4>;
pub type SerialLine = serial_line::SerialLine<USART3>;
pub type LineReceiver = serial_line::LineReceiver<USART3>;
pub type Board = parts::Parts<Converter, Drdy, (SerialLine, LineReceiver), SettingsFlash>;

pub const WIRING: Wiring = Wiring {
    converter: &Facts::of::<Converter>(),
};

pub fn init(device: pac::Peripherals, _core: cortex_m::Peripherals) -> Board {
    let boot = stm32f4::begin(&device);
    let crystal = External {
        mhz: 12,
        is_clock: false,
    };
    let (mut rcc, oscillator) =
        stm32f4::start_clocks(device.RCC, crystal, device.TIM2, device.TIM4);
    let gpioa = device.GPIOA.split(&mut rcc);
    let gpiob = device.GPIOB.split(&mut rcc);
    let gpioc = device.GPIOC.split(&mut rcc);
    // Up: without a PC the line would float, and noise would look like bytes.
    let rx = gpiob.pb11.into_alternate::<7>().internal_resistor(Pull::Up);
    let start = gpioc.pc5.into_push_pull_output_in_state(PinState::Low);
    let reset = gpioc.pc6.into_push_pull_output_in_state(PinState::High);
    let spi = converter::spi(
        device.SPI1,
        converter::BusPins {
            sck: gpioa.pa5,
            miso: gpioa.pa6,
            mosi: gpioa.pa7,
        },
        gpioa.pa4,
        &mut rcc,
    );
    let clock = TimerClock::new(device.TIM10, gpiob.pb8, &mut rcc);
    Board {
        converter: WiredAds1258::new(Ads1258::new(spi), start, reset).clocked_by(clock),
        drdy: Drdy::new(gpioc.pc4, device.EXTI, device.SYSCFG, &mut rcc),
        line: SerialLine::new(device.USART3, gpiob.pb10, rx, device.DMA1, &mut rcc),
        boot: Boot { oscillator, ..boot },
        flash: SettingsFlash::new(device.FLASH),
    }
}
