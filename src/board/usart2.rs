//! The Nucleo's line on USART2, for a task that `main.rs` binds to USART3.

use stm32f4xx_hal::interrupt;
use stm32f4xx_hal::pac::{Interrupt, NVIC};

/// Unmasks the interrupt and gives it the priority of the task that it forwards to.
pub fn forward(nvic: &mut NVIC) {
    // SAFETY: neither interrupts the other; RTIC has set the priority before it called `init`, and
    // serves no interrupt before the end of it.
    unsafe {
        nvic.set_priority(Interrupt::USART2, NVIC::get_priority(Interrupt::USART3));
        NVIC::unmask(Interrupt::USART2);
    }
}

/// This board does not use USART3 otherwise.
#[interrupt]
fn USART2() {
    // RTIC defines its handlers with Rust's ABI.
    unsafe extern "Rust" {
        fn USART3();
    }
    // SAFETY: that of USART3 cannot run at the same time: see `forward`.
    unsafe { USART3() }
}
