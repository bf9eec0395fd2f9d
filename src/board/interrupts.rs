//! Interrupts named after tasks.

/// Binds the tasks of `main.rs` to interrupts of the chip. RTIC requires a literal interrupt name,
/// so `main.rs` uses task names, and this macro maps them to interrupts: it declares the module
/// `device` for RTIC, and a handler for each interrupt that calls the task's handler.
macro_rules! interrupts {
    ($($task:ident: $interrupt:ident,)*) => {
        /// The device as RTIC expects it, with the tasks as its interrupts.
        pub mod device {
            pub use stm32f4xx_hal::pac::{NVIC_PRIO_BITS, Peripherals};
            pub use Interrupt as interrupt;
            use stm32f4xx_hal::pac;

            #[derive(Clone, Copy)]
            #[allow(clippy::upper_case_acronyms)]
            pub enum Interrupt {
                $($task = pac::Interrupt::$interrupt as isize,)*
                TIM4 = pac::Interrupt::TIM4 as isize,
            }

            // SAFETY: the numbers come from the chip's device crate.
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
                    // SAFETY: this is the handler of the task's interrupt.
                    unsafe { $task() }
                }
            )*
        }
    };
}
