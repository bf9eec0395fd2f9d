//! WeAct Black Pill V2.0 and later with an STM32F411CEU6, 100 MHz from its 25 MHz crystal.
//!
//! Its pins are in `docs/guide/2-build.md`. The line sends on PA2 and receives on PA3; its baud
//! rate is 0.47 % high. The button KEY is on PA0; the footprint of a flash chip on PA4 to PA7 must
//! stay empty.

use super::Memory;
use super::clocks::{Clocks, Oscillator};

pub use stm32f4xx_hal::gpio::{PA2 as Tx, PA3 as Rx};
#[cfg(feature = "spi-adc")]
pub use stm32f4xx_hal::gpio::{PA4 as DrdyPin, PB0 as Cs, PB1 as Start, PB10 as Reset};
pub use stm32f4xx_hal::pac::USART2 as Usart;

pub const CLOCKS: Clocks = Clocks {
    oscillator: Oscillator::Crystal(25),
    sysclk_mhz: 100,
    apb1_mhz: 50,
    apb2_mhz: 100,
    // Scale 1, because scale 2, the reset value, allows only 84 MHz (RM0383, 5.4.1).
    vos: Some(0b11),
};

pub const MEMORY: Memory = Memory {
    chip: "STM32F411CEUx",
    flash_kib: 512,
    ram_kib: 128,
    ccm_kib: 0,
    stack_bytes: 18016,
};

// The chip has one USB and no pins for a card, so the interrupts of SDIO and I2C3 are free for
// software.
interrupts! {
    LINE: USART2,
    DRDY: EXTI4,
    DETECT: SDIO,
    REPORT: I2C3_EV,
    FIT: I2C3_ER,
}

line! { USART2: Stream5, 5, DMA1_STREAM5 }

// All ten channels of ADC1 except the two used by the line, at 242 frames a second.
inputs! { 190: [PA0, PA1, PA4, PA5, PA6, PA7, PB0, PB1] }
