//! Adafruit Feather STM32F405 Express (product 4382) without another chip: eight sensors at the
//! processor's own converter. Clock and line are those of `feather_f405.rs`.
//!
//! Its pins are in `docs/guide/2-build.md`, which a test compares with this file: A0 to A5, D12 and
//! D11. Its other pins with a channel of ADC1 are no inputs: PA3 (A6) is the battery's divider, PC0
//! the NeoPixel, PC1 (D13) the red LED.

use super::stm32_adc::{self, FrameEnd, Stm32Adc, channel};
use super::stm32f4::{self, External};
use super::{parts, serial_line};
use ridgetone_finger::Wiring;
use ridgetone_proto::boot::Boot;
use stm32f4xx_hal::gpio::Pull;
use stm32f4xx_hal::pac::{self, USART3};
use stm32f4xx_hal::prelude::*;

pub use super::flash::SettingsFlash;
pub use super::stm32_adc::POWER_UP_US;
pub use stm32f4::{acknowledge_heartbeat, feed_watchdog, restart, sleep};

/// All inputs, at 241 frames a second.
pub type Converter = Stm32Adc<8, 160>;
pub type Drdy = FrameEnd;
pub type SerialLine = serial_line::SerialLine<USART3>;
pub type LineReceiver = serial_line::LineReceiver<USART3>;
pub type Board = parts::Parts<Converter, Drdy, (SerialLine, LineReceiver), SettingsFlash>;

pub const WIRING: Wiring = Wiring {
    converter: &stm32_adc::facts::<Converter>(),
};

pub fn init(device: pac::Peripherals, core: cortex_m::Peripherals) -> Board {
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
    let converter = stm32_adc::Parts {
        adc: device.ADC1,
        common: device.ADC_COMMON,
        dma: device.DMA2,
        channels: [
            channel(gpioa.pa4),
            channel(gpioa.pa5),
            channel(gpioa.pa6),
            channel(gpioa.pa7),
            channel(gpioc.pc4),
            channel(gpioc.pc5),
            channel(gpioc.pc2),
            channel(gpioc.pc3),
        ],
    };
    let mut nvic = core.NVIC;
    Board {
        converter: Converter::new(converter, &mut rcc),
        drdy: FrameEnd::new(&mut nvic),
        line: SerialLine::new(device.USART3, gpiob.pb10, rx, device.DMA1, &mut rcc),
        boot: Boot { oscillator, ..boot },
        flash: SettingsFlash::new(device.FLASH),
    }
}
