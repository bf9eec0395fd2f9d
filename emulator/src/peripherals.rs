//! The peripherals that the images use. Each decodes its registers by offset; `None` means not
//! modelled.
//!
//! Reset values are from the vendor's register descriptions (the crate `stm32f4` 0.16, `stm32f405`
//! and `stm32f446`), which agree with RM0090 and RM0390 as far as these were available; values from
//! memory alone are marked "(from memory)".

pub(crate) mod adc;
pub(crate) mod dac;
pub(crate) mod dma;
pub(crate) mod encoder;
pub(crate) mod exti;
pub(crate) mod flash;
pub(crate) mod gpio;
pub(crate) mod iwdg;
pub(crate) mod own_adc;
pub(crate) mod pwm;
pub(crate) mod rcc;
pub(crate) mod small;
pub(crate) mod spi;
pub(crate) mod timer;
pub(crate) mod usart;
