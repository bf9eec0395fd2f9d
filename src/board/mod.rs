//! The hardware: one file a board, only registers and time.
//!
//! # Porting
//!
//! A board is a module with the items below; `docs/guide/6-how-it-works.md` has the steps.
//! `main.rs` names no pin and no register. A board with an STM32F4 is little more than its pins, as
//! `nucleo_f446re.rs` shows.
//!
//! | item | what it must do |
//! |---|---|
//! | `init(device, core) -> Board` | clocks, pins, SPI, interrupts, the microsecond counter; START low, RESET high |
//! | `Board::converter` | a [`Converter`](ridgetone_finger::converter::Converter): the processor's own (`stm32_adc.rs`), or an ADS1258 on an `embedded_hal` `SpiDevice` in mode 0, at most half the chip's clock (7.86 MHz), CS as below, with `OutputPin`s on START (high runs the scan) and RESET (active low) |
//! | `WIRING` | a [`Wiring`](ridgetone_finger::Wiring): how the converter samples, the low-pass before its inputs |
//! | `Board::drdy` | [`DrdyPin`]: the falling edge of DRDY and its time; its interrupt can be muted |
//! | `Board::line` | [`serial_line::SerialLine`] and [`serial_line::LineReceiver`] on the board's USART: telemetry out byte by byte, requests in by DMA1 |
//! | `Board::flash` | a `NorFlash` of two pages for settings, words of 4 bytes, where no code may lie (`memory.x`) |
//! | the types `Board`, `Converter`, `Drdy`, `SerialLine`, `LineReceiver`, `SettingsFlash` | [`parts::Parts`] and what it has on this board |
//! | `now_us() -> u32` | a free-running microsecond counter that wraps at 2^32 and does not stop in sleep |
//! | an interrupt TIM4 about twice a second | for the task `watch`, also while DRDY is silent |
//! | `acknowledge_heartbeat()` | clears that interrupt, and keeps the chip open for a debugger |
//! | `POWER_UP_US` | from power-up to the first register access, microseconds |
//! | `sleep()` | waits until an interrupt is pending, also a masked one; a debugger must stay connected |
//! | `restart()` | resets the processor |
//! | `Board::boot` | the cause of the reset, and the record of a crash before it ([`crash::take_record`]) |
//! | `feed_watchdog()` | puts off the reset by the watchdog, which `init` has started, by [`WATCHDOG_S`] |
//! | `die(record)` | keeps the record ([`crash::keep`]) and resets; the handlers of panics and of HardFault call it |
//!
//! CS: low at least 2.5 tCLK before the first SCLK edge, high at least 2 tCLK between transactions
//! (159 ns and 127 ns at 15.72864 MHz, ADS1258 datasheet SBAS297G).
//!
//! Interrupts: `EXTI4` is DRDY, or the end of a frame; `USART3` the line's "transmitter empty" and "idle" (DRDY on
//! another pin, the DMA and a line on another USART forward theirs, see `usart2.rs`). `OTG_HS_EP1_OUT`,
//! `OTG_HS_EP1_IN` and `OTG_HS_WKUP` are the three tasks that only software pends: no board wires
//! the second USB, while robots use CAN. On a chip that lacks these names change them in `main.rs`,
//! with `device` in `rtic::app`.
//! Priorities need five levels.
//!
//! Panics: a board has its own panic handler, which calls `die`.
//!
//! [`DrdyPin`]: ridgetone_finger::tasks::DrdyPin
//! [`WATCHDOG_S`]: ridgetone_finger::tasks::WATCHDOG_S

// The only place of the firmware where unsafe code is allowed: registers and
// linker symbols.
#![allow(unsafe_code)]

#[cfg(feature = "spi-adc")]
mod chip_clock;
mod clock;
#[cfg(feature = "spi-adc")]
mod converter;
mod crash;
mod hard_fault;
mod parts;
mod serial_line;
mod stack;
mod wait;

#[cfg(feature = "feather-f405")]
mod feather_f405;
#[cfg(feature = "feather-f405-adc")]
mod feather_f405_adc;
mod flash;
#[cfg(feature = "nucleo-f446re")]
mod nucleo_f446re;
#[cfg(feature = "nucleo-f446re-adc")]
mod nucleo_f446re_adc;
#[cfg(feature = "own-adc")]
mod stm32_adc;
mod stm32f4;
#[cfg(any(feature = "nucleo-f446re", feature = "nucleo-f446re-adc"))]
mod usart2;

#[cfg(feature = "feather-f405")]
pub use feather_f405::*;
#[cfg(feature = "feather-f405-adc")]
pub use feather_f405_adc::*;
#[cfg(feature = "nucleo-f446re")]
pub use nucleo_f446re::*;
#[cfg(feature = "nucleo-f446re-adc")]
pub use nucleo_f446re_adc::*;

pub use clock::now_us;
pub use stack::{word as stack_word, words as stack_words};
pub use wait::Wait;
