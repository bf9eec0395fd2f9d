//! Adafruit Feather STM32F405 Express (product 4382), 168 MHz from its 12 MHz crystal.
//!
//! Its pins are in `docs/guide/2-build.md`, which a test compares with this file. A timer's input
//! capture would measure the edges of DRDY exactly if DRDY were on D6 (PC6, TIM3 CH1) and RESET on
//! A4.
//!
//! The line is on TX and RX. The baud rate generator divides 42 MHz by 46, which is 0.93 % slow;
//! receivers tolerate about 4 % (8N1).

use super::Memory;
use super::clocks::{Clocks, Oscillator};

#[cfg(feature = "spi-adc")]
pub use stm32f4xx_hal::gpio::{PA4 as Cs, PC4 as DrdyPin, PC5 as Start, PC6 as Reset};
pub use stm32f4xx_hal::gpio::{PB10 as Tx, PB11 as Rx};
pub use stm32f4xx_hal::pac::USART3 as Usart;

pub const CLOCKS: Clocks = Clocks {
    oscillator: Oscillator::Crystal(12),
    sysclk_mhz: 168,
    apb1_mhz: 42,
    apb2_mhz: 84,
    vos: None,
};

pub const MEMORY: Memory = Memory {
    chip: "STM32F405RGTx",
    flash_kib: 1024,
    ram_kib: 128,
    ccm_kib: 64,
    stack_bytes: 20480,
};

// The second USB is not wired, so its interrupts are free for software.
interrupts! {
    LINE: USART3,
    DRDY: EXTI4,
    DETECT: OTG_HS_EP1_OUT,
    REPORT: OTG_HS_EP1_IN,
    FIT: OTG_HS_WKUP,
}

line! { USART3: Stream1, 1, DMA1_STREAM1 }

// A0 to A5, D12 and D11, at 241 frames a second. The other channels of ADC1 cannot be used: PA3
// (A6) is wired to the battery's divider, PC0 to the NeoPixel, PC1 (D13) to the red LED.
inputs! { 160: [PA4, PA5, PA6, PA7, PC4, PC5, PC2, PC3] }
