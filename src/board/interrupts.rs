//! Interrupts by the names of tasks.

/// Binds the tasks of `main.rs` to interrupts of the chip. RTIC takes an interrupt as a literal name,
/// so `main.rs` names tasks, and this makes them interrupts: module `device` for RTIC, and the handler
/// of each interrupt, which calls the task's.
macro_rules! interrupts {
    ($($task:ident: $interrupt:ident,)*) => {
        /// The device as RTIC wants it, with the tasks as its interrupts.
        pub mod device {
            pub use stm32f4xx_hal::pac::{NVIC_PRIO_BITS, Peripherals};
            pub use Interrupt as interrupt;
            use stm32f4xx_hal::pac;

            /// Interrupts by their tasks.
            #[derive(Clone, Copy)]
            #[allow(clippy::upper_case_acronyms)]
            pub enum Interrupt {
                $($task = pac::Interrupt::$interrupt as isize,)*
                TIM4 = pac::Interrupt::TIM4 as isize,
            }

            // SAFETY: the numbers are the chip's.
            unsafe impl cortex_m::interrupt::InterruptNumber for Interrupt {
                fn number(self) -> u16 {
                    self as u16
                }
            }

            $(
                #[unsafe(no_mangle)]
                extern "C" fn $interrupt() {
                    // RTIC defines its handlers with Rust's ABI.
                    unsafe extern "Rust" {
                        fn $task();
                    }
                    // SAFETY: this is that interrupt's handler.
                    unsafe { $task() }
                }
            )*
        }
    };
}
