//! QEMU's `netduinoplus2`, an STM32F405 with the ADS1258 simulated on the PC.
//!
//! The emulator has no RCC (the internal oscillator works, crystal and PLL would wait for ever), no
//! GPIO and no DMA. SPI, START, RESET and DRDY travel as [`hal_mock::bridge`] records through two
//! FIFOs. Telemetry and requests use USART3 (the emulator's third serial port). Its timers run at 1
//! GHz of virtual time.

mod kept;
pub(super) mod link;
mod log;
mod memory;
mod semihost;

use super::{clock, crash, parts, serial_line, stack};
use ads1258::Ads1258;
use core::convert::Infallible;
use cortex_m::peripheral::{SCB, SYST};
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, Operation as Op, SpiDevice};
use hal_mock::bridge::{Operation, PAYLOAD_MAX};
use kept::KEPT;
use ridgetone_finger::Wiring;
use ridgetone_finger::converter::WiredAds1258;
use ridgetone_finger::tasks::DepthMeter;
use ridgetone_proto::boot::{Boot, Death, Record, ResetCause};
use semihost::Exit;
use stm32f4xx_hal::pac::{self, USART3};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;

pub use clock::acknowledge_heartbeat;
pub use link::{Drdy, ended, feed_watchdog};
pub use memory::SettingsFlash;

/// From power-up to the first register access, microseconds: the simulated chip's 2^18 tCLK.
pub const POWER_UP_US: u32 = 20_000;

/// Ticks of the emulator's timers in a microsecond.
const TICKS_PER_US: u32 = 1000;

pub type Converter = WiredAds1258<Bridge, Pin, Pin>;
pub type SerialLine = serial_line::SerialLine<USART3>;
pub type Board = parts::Parts<Converter, Drdy, SerialLine, SettingsFlash>;

/// An SPI device whose transactions travel over the bridge, for what the driver does: one write or
/// transfer in place.
pub struct Bridge;

impl spi::ErrorType for Bridge {
    type Error = spi::ErrorKind;
}

impl SpiDevice for Bridge {
    fn transaction(&mut self, operations: &mut [Op<'_, u8>]) -> Result<(), spi::ErrorKind> {
        match operations {
            [Op::TransferInPlace(bytes)] => link::exchange(Operation::Transfer, false, bytes),
            [Op::Write(bytes)] => {
                let mut wire = [0; PAYLOAD_MAX];
                let wire = wire.get_mut(..bytes.len()).ok_or(spi::ErrorKind::Other)?;
                wire.copy_from_slice(bytes);
                link::exchange(Operation::Transfer, false, wire);
            }
            _ => return Err(spi::ErrorKind::Other),
        }
        Ok(())
    }
}

/// START or RESET.
pub struct Pin(Operation);

impl digital::ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        link::exchange(self.0, false, &mut []);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        link::exchange(self.0, true, &mut []);
        Ok(())
    }
}

/// The guide's.
pub const WIRING: Wiring = Wiring::GUIDE;

pub fn init(device: pac::Peripherals, core: cortex_m::Peripherals) -> Board {
    let mut rcc = device.RCC.freeze(Config::hsi());
    let kept = KEPT.take();
    clock::start(device.TIM2, &mut rcc, TICKS_PER_US);
    if let Some((now_us, _)) = kept {
        // The chip's time goes on.
        clock::set_us(now_us);
    }

    let gpiob = device.GPIOB.split(&mut rcc);
    let line = SerialLine::new(device.USART3, gpiob.pb10, gpiob.pb11, &mut rcc);

    let cause = kept.map_or(ResetCause::Unknown, |(_, cause)| cause);
    let boot = Boot {
        cause,
        record: crash::take_record(),
        ..Boot::UNKNOWN
    };
    link::open(core.SYST, kept.is_some());
    let mut start = Pin(Operation::Start);
    let mut reset = Pin(Operation::Reset);
    let (Ok(()), Ok(())) = (start.set_low(), reset.set_high());
    // SAFETY: this is done once.
    let flash = unsafe { SettingsFlash::new() };
    Board {
        converter: Converter::new(Ads1258::new(Bridge), start, reset),
        drdy: Drdy,
        line,
        boot,
        flash,
    }
}

/// Waits until an interrupt is pending, masked or not.
///
/// Not by WFI: the emulator then skips to the next event some nanoseconds off, so that no two runs
/// are the same.
pub fn sleep() {
    /// The exception that is served next, 0 for none (Armv7-M, ICSR.VECTPENDING).
    const VECTPENDING: u32 = 0x1ff << 12;
    /// 2000 instructions are 16 us at 125 MIPS; this number of ticks of SysTick, at 168 MHz, is 18
    /// us.
    const LONG_TICKS: u32 = 3000;
    // SAFETY: reading ICSR has no side effect.
    while unsafe { (*SCB::PTR).icsr.read() } & VECTPENDING == 0 {
        // Only the alarm can end this. While it is far the register is read rarely: one read costs
        // hundreds of NOPs.
        let blocks = if SYST::get_current() > LONG_TICKS {
            16
        } else {
            1
        };
        // SAFETY: counts a register down, `blocks` is not 0.
        unsafe {
            core::arch::asm!(
                "2:", ".rept 123", "nop", ".endr", "subs {n}, #1", "bne 2b",
                n = inout(reg) blocks => _, options(nomem, nostack)
            );
        }
    }
}

/// The bridge, the time and the pages of settings stay.
pub fn restart() -> ! {
    link::restart(ResetCause::Software)
}

/// Ends the emulator: all is done. Prints the stack's greatest depth.
pub fn leave() {
    let mut meter = DepthMeter::new();
    let deepest = (0..stack::words()).fold(0, |_, _| meter.step(stack::words(), stack::word));
    let size = 4 * stack::words();
    semihost::print(format_args!(
        "stack: {deepest} of {size} bytes used at most"
    ));
    semihost::exit(Exit::Done)
}

/// Keeps the record and resets if the PC has requested the crash; else prints it and ends the
/// emulator.
pub fn die(record: &Record) -> ! {
    crash::keep(record);
    link::restart_if_requested(ResetCause::Software);
    let Record { death, pc, lr, .. } = record;
    match death {
        // The panic handler has printed its message.
        Death::Panic => semihost::exit(Exit::Panic),
        Death::HardFault => {
            semihost::print(format_args!(
                "hard fault at {pc:#010x}, called from {lr:#010x}"
            ));
            semihost::exit(Exit::Fault)
        }
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    // Real boards do not format the message: it would take 9 KB of flash.
    semihost::print(format_args!("firmware {info}"));
    die(&crash::record_of(info))
}
