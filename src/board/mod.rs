//! Board support: one file per board, limited to registers and timing.
//!
//! # Porting
//!
//! A board is a file of data, such as `blackpill_f411.rs`; everything else is derived at compile
//! time. The steps are in `docs/guide/6-how-it-works.md`.
//!
//! | item | meaning |
//! |---|---|
//! | `CLOCKS` | oscillator, CPU and bus clocks; PLL, timers, baud rate, SPI and CS times follow ([`clocks::Clocks`]) |
//! | `MEMORY` | the chip's name in probe-rs, its flash and RAM; `build.rs` reads it from the file for `memory.x` |
//! | `Cs`, `Start`, `Reset`, `DrdyPin` | the ADS1258's pins next to SPI1 on PA5 to PA7; DRDY on line 4 of EXTI |
//! | `Usart`, `Tx`, `Rx` | the line: telemetry out, requests in |
//! | `interrupts!` | the interrupt of each task of `main.rs`: `LINE` is the USART's, `DRDY` EXTI4; software alone pends `DETECT`, `REPORT` and `FIT`, which take interrupts that the board does not use |
//! | `line!` | the stream of DMA1 that receives for the USART (RM0090, table 42) |
//! | `inputs!` | scans per frame, and pins of the on-chip ADC |
//!
//! A board with a different chip family needs more code, but exposes the same interface to the
//! tasks. `init` returns a [`Board`] with a [`Converter`](ridgetone_finger::converter::Converter),
//! a [`DrdyPin`](ridgetone_finger::tasks::DrdyPin), a [`serial_line::SerialLine`] with its
//! [`serial_line::LineReceiver`] and a `NorFlash` of two pages for settings (words of 4 bytes, no
//! code in the pages). The board also has:
//!
//! | item | what it must do |
//! |---|---|
//! | `WIRING` | how the converter samples: a [`Wiring`] |
//! | `now_us() -> u32` | a free-running microsecond counter that wraps at 2^32 and does not stop in sleep |
//! | TIM4 interrupt, about twice a second | for the task `watch`, also while DRDY is silent |
//! | `acknowledge_heartbeat()` | clears the TIM4 interrupt and keeps debug access enabled |
//! | `POWER_UP_US` | from power-up to the first register access, microseconds |
//! | `sleep()` | waits until an interrupt is pending, even a masked one; a debugger must stay connected |
//! | `restart()` | resets the processor |
//! | `feed_watchdog()` | reloads the watchdog, which `init` has started; it resets the board after [`WATCHDOG_S`] |
//! | `die(record)` | saves the record ([`crash::keep`]) and resets; called by the panic and HardFault handlers |
//!
//! CS: low at least 2.5 tCLK before the first SCLK edge, high at least 2 tCLK between transactions
//! (159 ns and 127 ns at 15.72864 MHz, ADS1258 datasheet SBAS297G).
//!
//! The tasks need five interrupt priorities.
//!
//! Panics: a board has its own panic handler, which calls `die`.
//!
//! [`WATCHDOG_S`]: ridgetone_finger::tasks::WATCHDOG_S

// The only part of the firmware where unsafe code is allowed: registers and linker symbols.
#![allow(unsafe_code)]

/// Declares the on-chip ADC's pins, in the order of the inputs, and the default number of scans per
/// frame.
#[cfg_attr(
    feature = "blackpill-f401",
    allow(unused_macros, reason = "no image with its own ADC")
)]
macro_rules! inputs {
    ($scans:literal: [$($pin:ident),*]) => {
        #[cfg(feature = "own-adc")]
        pub const SCANS: u8 = $scans;
        #[cfg(feature = "own-adc")]
        pub const INPUTS: usize = [$(stringify!($pin)),*].len();

        /// Makes the pins analogue and returns their channels.
        #[cfg(feature = "own-adc")]
        pub fn channels() -> [u8; INPUTS] {
            [$(super::stm32_adc::channel(super::pin::<stm32f4xx_hal::gpio::$pin>())),*]
        }
    };
}

#[cfg(feature = "spi-adc")]
mod chip_clock;
mod clock;
mod clocks;
#[cfg(feature = "spi-adc")]
mod converter;
mod crash;
mod flash;
mod hard_fault;
#[macro_use]
mod interrupts;
#[macro_use]
mod serial_line;
mod stack;
#[cfg(feature = "own-adc")]
mod stm32_adc;
mod stm32f4;
mod wait;

#[cfg_attr(
    any(feature = "feather-f405", feature = "feather-f405-adc"),
    path = "feather_f405.rs"
)]
#[cfg_attr(
    any(feature = "nucleo-f446re", feature = "nucleo-f446re-adc"),
    path = "nucleo_f446re.rs"
)]
#[cfg_attr(
    any(feature = "blackpill-f411", feature = "blackpill-f411-adc"),
    path = "blackpill_f411.rs"
)]
#[cfg_attr(feature = "blackpill-f401", path = "blackpill_f401.rs")]
mod chosen;

pub use chosen::device;
pub use clock::now_us;
pub use flash::SettingsFlash;
pub use stack::{word as stack_word, words as stack_words};
pub use stm32f4::{acknowledge_heartbeat, feed_watchdog, restart, sleep};
pub use wait::Wait;

#[cfg(feature = "spi-adc")]
pub use converter::{Converter, Drdy, POWER_UP_US, WIRING};
#[cfg(feature = "own-adc")]
pub use stm32_adc::{Converter, Drdy, POWER_UP_US, WIRING};

use chosen::{CLOCKS, MEMORY};
use ridgetone_proto::boot::Boot;
use stm32f4xx_hal::gpio::Pull;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;

/// Flash and RAM of a chip, and size of the stack. build.rs reads the numbers.
pub struct Memory {
    /// Name of the chip in probe-rs.
    pub chip: &'static str,
    /// Total flash, of which the last two sectors, 256 KiB, are for settings.
    pub flash_kib: u32,
    /// Main RAM, contiguous.
    pub ram_kib: u32,
    /// CCM RAM, only for the stack.
    pub ccm_kib: u32,
    /// Size of the stack, which is in CCM RAM if it fits there, else in main RAM.
    pub stack_bytes: u32,
}

const _: () = {
    let Memory {
        chip,
        flash_kib,
        ram_kib,
        ccm_kib,
        stack_bytes,
    } = MEMORY;
    assert!(!chip.is_empty() && flash_kib >= 512 && ram_kib >= 96);
    assert!(stack_bytes >= 18_016 && (ccm_kib == 0 || stack_bytes <= 1024 * ccm_kib));
};

pub type SerialLine = serial_line::SerialLine<chosen::Usart>;
pub type LineReceiver = serial_line::LineReceiver<chosen::Usart>;

pub struct Board {
    pub converter: Converter,
    pub drdy: Drdy,
    pub line: (SerialLine, LineReceiver),
    pub boot: Boot,
    pub flash: SettingsFlash,
}

/// Sets up clocks, pins, SPI or ADC, line and interrupts.
pub fn init(device: pac::Peripherals, core: cortex_m::Peripherals) -> Board {
    let boot = stm32f4::begin(&device);
    let (mut rcc, oscillator) = stm32f4::start_clocks(device.RCC, device.TIM2, device.TIM4);
    // Only switches the ports' clocks on: `pin` creates the pins.
    device.GPIOA.split(&mut rcc);
    device.GPIOB.split(&mut rcc);
    device.GPIOC.split(&mut rcc);
    #[cfg(feature = "spi-adc")]
    let (converter, drdy) = {
        let _ = core;
        let drdy = Drdy::new(device.EXTI, device.SYSCFG, &mut rcc);
        (converter::new(device.SPI1, device.TIM10, &mut rcc), drdy)
    };
    #[cfg(feature = "own-adc")]
    let (converter, drdy) = {
        let (adc, common) = (device.ADC1, device.ADC_COMMON);
        let mut nvic = core.NVIC;
        let drdy = Drdy::new(&mut nvic);
        (Converter::new(adc, common, device.DMA2, &mut rcc), drdy)
    };
    // Pull-up: without a PC the line would float, and noise would look like bytes.
    let rx = pin::<chosen::Rx>().internal_resistor(Pull::Up);
    // SAFETY: `device` owns the USART, under a name that depends on the board.
    let usart = unsafe { chosen::Usart::steal() };
    Board {
        converter,
        drdy,
        line: SerialLine::new(usart, pin::<chosen::Tx>(), rx, device.DMA1, &mut rcc),
        boot: Boot { oscillator, ..boot },
        flash: SettingsFlash::new(device.FLASH),
    }
}

/// Creates a pin of the board from its type. Only `init` calls this, once for each use of a pin.
fn pin<P>() -> P {
    const { assert!(size_of::<P>() == 0, "a pin is a token without data") };
    // SAFETY: the type has no data; `init` has switched the port's clock on, and owns all ports.
    unsafe { core::mem::transmute_copy(&()) }
}
