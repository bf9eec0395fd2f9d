//! ST Nucleo-F446RE (MB1136), 168 MHz from the 8 MHz that its ST-LINK supplies on OSC_IN (UM1724,
//! "OSC clock supply": bridges set from MB1136 C-02 on).
//!
//! Its pins are in `docs/guide/2-build.md`, which a test compares with this file.
//!
//! The ST-LINK makes the line a serial port of the PC; the baud rate is 0.93 % low, as on the
//! Feather. PA2 and PA3 reach D1 and D0 only after two bridges are soldered (UM1724).

use super::Memory;
use super::clocks::{Clocks, Oscillator};

pub use stm32f4xx_hal::gpio::{PA2 as Tx, PA3 as Rx};
#[cfg(feature = "spi-adc")]
pub use stm32f4xx_hal::gpio::{PA4 as DrdyPin, PA9 as Reset, PB6 as Cs, PC7 as Start};
pub use stm32f4xx_hal::pac::USART2 as Usart;

pub const CLOCKS: Clocks = Clocks {
    oscillator: Oscillator::Clock(8),
    sysclk_mhz: 168,
    apb1_mhz: 42,
    apb2_mhz: 84,
    vos: None,
};

pub const MEMORY: Memory = Memory {
    chip: "STM32F446RETx",
    flash_kib: 512,
    ram_kib: 128,
    ccm_kib: 0,
    stack_bytes: 18016,
};

interrupts! {
    LINE: USART2,
    DRDY: EXTI4,
    DETECT: OTG_HS_EP1_OUT,
    REPORT: OTG_HS_EP1_IN,
    FIT: OTG_HS_WKUP,
}

line! { USART2: Stream5, 5, DMA1_STREAM5 }

// All sixteen channels of ADC1 except the two used by the line, at 237 frames a second. PA5 also
// drives the green LED until the solder bridge SB21 is opened (UM1724): open it, or leave input 3
// out of the plan.
inputs! { 93: [PA0, PA1, PA4, PA5, PA6, PA7, PB0, PB1, PC0, PC1, PC2, PC3, PC4, PC5] }
