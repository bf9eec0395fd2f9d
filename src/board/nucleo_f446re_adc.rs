//! ST Nucleo-F446RE without another chip: fourteen sensors at its own converter. Clock and line are
//! those of `nucleo_f446re.rs`.
//!
//! Its pins are in `docs/guide/2-build.md`, which a test compares with this file. Sixteen pins of
//! the processor have a channel of ADC1; PA2 and PA3 are the line. PA5 carries the green LED until
//! the solder bridge SB21 is opened (UM1724): open it, or leave input 3 out of the plan.

use super::stm32_adc::{self, FrameEnd, Stm32Adc, channel};
use super::stm32f4::{self, External};
use super::{parts, serial_line, usart2};
use ridgetone_finger::Wiring;
use ridgetone_proto::boot::Boot;
use stm32f4xx_hal::gpio::Pull;
use stm32f4xx_hal::pac::{self, USART2};
use stm32f4xx_hal::prelude::*;

pub use super::flash::SettingsFlash;
pub use super::stm32_adc::POWER_UP_US;
pub use stm32f4::{acknowledge_heartbeat, feed_watchdog, restart, sleep};

/// All inputs, at 237 frames a second.
pub type Converter = Stm32Adc<14, 93>;
pub type Drdy = FrameEnd;
pub type SerialLine = serial_line::SerialLine<USART2>;
pub type LineReceiver = serial_line::LineReceiver<USART2>;
pub type Board = parts::Parts<Converter, Drdy, (SerialLine, LineReceiver), SettingsFlash>;

pub const WIRING: Wiring = Wiring {
    converter: &stm32_adc::facts::<Converter>(),
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
    let converter = stm32_adc::Parts {
        adc: device.ADC1,
        common: device.ADC_COMMON,
        dma: device.DMA2,
        channels: [
            channel(gpioa.pa0),
            channel(gpioa.pa1),
            channel(gpioa.pa4),
            channel(gpioa.pa5),
            channel(gpioa.pa6),
            channel(gpioa.pa7),
            channel(gpiob.pb0),
            channel(gpiob.pb1),
            channel(gpioc.pc0),
            channel(gpioc.pc1),
            channel(gpioc.pc2),
            channel(gpioc.pc3),
            channel(gpioc.pc4),
            channel(gpioc.pc5),
        ],
    };
    let mut nvic = core.NVIC;
    usart2::forward(&mut nvic);
    Board {
        converter: Converter::new(converter, &mut rcc),
        drdy: FrameEnd::new(&mut nvic),
        line: SerialLine::new(device.USART2, gpioa.pa2, rx, device.DMA1, &mut rcc),
        boot: Boot { oscillator, ..boot },
        flash: SettingsFlash::new(device.FLASH),
    }
}
