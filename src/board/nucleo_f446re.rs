//! ST Nucleo-F446RE (MB1136), 168 MHz from the 8 MHz that its ST-LINK puts on OSC_IN (UM1724, "OSC
//! clock supply": the bridges are so from MB1136 C-02 on).
//!
//! Its pins are in `docs/guide/2-build.md`, which a test compares with this file.
//!
//! Telemetry leaves on PA2, requests arrive on PA3 (USART2, AF7), a serial port of the PC through
//! the ST-LINK, at 921600 baud, 8N1; 0.93 % slow as on the Feather. D0 and D1 are these pins only
//! after two bridges are soldered (UM1724).

use super::chip_clock::TimerClock;
use super::stm32f4::{self, External};
use super::{converter, parts, serial_line, usart2};
use ads1258::Ads1258;
use ridgetone_finger::Wiring;
use ridgetone_finger::converter::{Facts, WiredAds1258};
use ridgetone_proto::boot::Boot;
use stm32f4xx_hal::gpio::{Output, PA9, PC7, PinState, Pull};
use stm32f4xx_hal::pac::{self, USART2};
use stm32f4xx_hal::prelude::*;

pub use super::converter::POWER_UP_US;
pub use super::flash::SettingsFlash;
pub use stm32f4::{acknowledge_heartbeat, feed_watchdog, restart, sleep};

pub type Converter = WiredAds1258<converter::Spi<'B', 6>, PC7<Output>, PA9<Output>, TimerClock>;
pub type Drdy = converter::Drdy<'A', 4>;
pub type SerialLine = serial_line::SerialLine<USART2>;
pub type LineReceiver = serial_line::LineReceiver<USART2>;
pub type Board = parts::Parts<Converter, Drdy, (SerialLine, LineReceiver), SettingsFlash>;

pub const WIRING: Wiring = Wiring {
    converter: &Facts::of::<Converter>(),
};

pub fn init(device: pac::Peripherals, core: cortex_m::Peripherals) -> Board {
    let boot = stm32f4::begin(&device);
    let clock = External {
        mhz: 8,
        is_clock: true,
    };
    let (mut rcc, oscillator) = stm32f4::start_clocks(device.RCC, clock, device.TIM2, device.TIM4);
    let gpioa = device.GPIOA.split(&mut rcc);
    let gpiob = device.GPIOB.split(&mut rcc);
    let gpioc = device.GPIOC.split(&mut rcc);
    // Up: without a PC the line would float, and noise would look like bytes.
    let rx = gpioa.pa3.into_alternate::<7>().internal_resistor(Pull::Up);
    let start = gpioc.pc7.into_push_pull_output_in_state(PinState::Low);
    let reset = gpioa.pa9.into_push_pull_output_in_state(PinState::High);
    let spi = converter::spi(
        device.SPI1,
        converter::BusPins {
            sck: gpioa.pa5,
            miso: gpioa.pa6,
            mosi: gpioa.pa7,
        },
        gpiob.pb6,
        &mut rcc,
    );
    let clock = TimerClock::new(device.TIM10, gpiob.pb8, &mut rcc);
    let mut nvic = core.NVIC;
    usart2::forward(&mut nvic);
    Board {
        converter: WiredAds1258::new(Ads1258::new(spi), start, reset).clocked_by(clock),
        drdy: Drdy::new(gpioa.pa4, device.EXTI, device.SYSCFG, &mut rcc),
        line: SerialLine::new(device.USART2, gpioa.pa2, rx, device.DMA1, &mut rcc),
        boot: Boot { oscillator, ..boot },
        flash: SettingsFlash::new(device.FLASH),
    }
}
