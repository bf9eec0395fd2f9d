//! WeAct Black Pill V3.0 with an STM32F401CEU6, 84 MHz from its 25 MHz crystal. Pins, line and
//! interrupts are the same as in `blackpill_f411.rs`.
//!
//! With 96 KiB of RAM the ring has half its usual size: windows and slides last up to 2.3 s at 241
//! frames a second.

use super::Memory;
use super::clocks::{Clocks, Oscillator};

pub use stm32f4xx_hal::gpio::{PA2 as Tx, PA3 as Rx};
pub use stm32f4xx_hal::gpio::{PA4 as DrdyPin, PB0 as Cs, PB1 as Start, PB10 as Reset};
pub use stm32f4xx_hal::pac::USART2 as Usart;

pub const CLOCKS: Clocks = Clocks {
    oscillator: Oscillator::Crystal(25),
    sysclk_mhz: 84,
    apb1_mhz: 42,
    apb2_mhz: 84,
    vos: None,
};

pub const MEMORY: Memory = Memory {
    chip: "STM32F401CEUx",
    flash_kib: 512,
    ram_kib: 96,
    ccm_kib: 0,
    stack_bytes: 20480,
};

interrupts! {
    LINE: USART2,
    DRDY: EXTI4,
    DETECT: SDIO,
    REPORT: I2C3_EV,
    FIT: I2C3_ER,
}

line! { USART2: Stream5, 5, DMA1_STREAM5 }
