//! QEMU's `netduinoplus2`, an STM32F405 with the ADS1258 simulated on the PC.
//!
//! The emulator has no RCC (the internal oscillator works, crystal and PLL would wait for ever), no
//! GPIO and no DMA. SPI, START, RESET and DRDY travel as [`hal_mock::bridge`] records through two
//! FIFOs, telemetry leaves and orders come on USART3 (the emulator's third serial port), and the run ends with the
//! exit status of [`super::semihost::Exit`]. Its timers run at 1 GHz of virtual time.

use super::semihost::{self, Exit};
use super::{Board, SerialLine, SettingsFlash, crash, kept::Kept, link};
use core::convert::Infallible;
use cortex_m::peripheral::{SCB, SYST};
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, Operation as Op, SpiDevice};
use hal_mock::bridge::{Operation, PAYLOAD_MAX};
use ridgetone::tasks::drdy::DrdyPin;
use ridgetone_proto::boot::{Boot, Death, Record, ResetCause};
use stm32f4xx_hal::pac::{self, USART3};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;

pub use link::{ended, feed_watchdog};

/// From power-up to the first register access, microseconds: the simulated chip's 2^18 tCLK.
pub const POWER_UP_US: u32 = 20_000;

/// Ticks of the emulator's timers in a microsecond.
const TICKS_PER_US: u32 = 1000;

/// SPI with CS.
pub type Spi = Bridge;
/// The pin START.
pub type Start = Pin;
/// The pin RESET.
pub type Reset = Pin;
/// What the line is on.
pub type Usart = USART3;

/// An SPI device whose transactions travel over the bridge, one record each.
pub struct Bridge;

/// The transaction is longer than a record.
#[derive(Clone, Copy, Debug)]
pub struct TooLong;

impl spi::Error for TooLong {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

impl spi::ErrorType for Bridge {
    type Error = TooLong;
}

impl SpiDevice for Bridge {
    fn transaction(&mut self, operations: &mut [Op<'_, u8>]) -> Result<(), TooLong> {
        let mut wire = [0; PAYLOAD_MAX];
        let mut length = 0;
        for operation in operations.iter() {
            let (said, bytes) = match operation {
                Op::Read(read) => (&[][..], read.len()),
                Op::Write(write) => (*write, write.len()),
                Op::Transfer(read, write) => (*write, read.len().max(write.len())),
                Op::TransferInPlace(both) => (&**both, both.len()),
                // Waiting inside a transaction needs no record: the bridge carries no partial one.
                Op::DelayNs(_) => continue,
            };
            let slot = wire.get_mut(length..length + bytes).ok_or(TooLong)?;
            slot.get_mut(..said.len()).ok_or(TooLong)?.copy_from_slice(said);
            length += bytes;
        }
        let wire = wire.get_mut(..length).ok_or(TooLong)?;
        link::exchange(Operation::Transfer, false, wire);

        let mut rest = &*wire;
        for operation in operations {
            let (heard, bytes): (&mut [u8], usize) = match operation {
                Op::Read(read) => {
                    let bytes = read.len();
                    (read, bytes)
                }
                Op::Write(write) => (&mut [], write.len()),
                Op::Transfer(read, write) => {
                    let bytes = read.len().max(write.len());
                    (read, bytes)
                }
                Op::TransferInPlace(both) => {
                    let bytes = both.len();
                    (both, bytes)
                }
                Op::DelayNs(_) => continue,
            };
            let (slot, after) = rest.split_at_checked(bytes).ok_or(TooLong)?;
            heard.copy_from_slice(slot.get(..heard.len()).ok_or(TooLong)?);
            rest = after;
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

/// The falling edge of DRDY.
pub struct Drdy;

impl DrdyPin for Drdy {
    #[inline(always)]
    fn acknowledge(&mut self) -> Option<bool> {
        link::take_edge().then_some(true)
    }

    /// The chip's own time of the edge: it does not depend on the speed of the emulated processor.
    fn edge_us(&self) -> u32 {
        link::edge_us()
    }

    fn mute(&mut self) {
        link::mute(true);
    }

    fn unmute(&mut self) {
        link::mute(false);
    }
}

/// Sets the board up.
pub fn init(device: pac::Peripherals, core: cortex_m::Peripherals) -> Board {
    let mut rcc = device.RCC.freeze(Config::hsi());
    let kept = Kept::take();
    super::clock::start(device.TIM2, &mut rcc, TICKS_PER_US);
    if let Some(kept) = &kept {
        // The other end knows one time only.
        super::clock::set_us(kept.now_us);
    }

    let gpiob = device.GPIOB.split(&mut rcc);
    let line = SerialLine::new(device.USART3, (gpiob.pb10, gpiob.pb11), &mut rcc);

    let cause = kept.as_ref().map_or_else(Default::default, |kept| kept.cause);
    let boot = Boot { cause, record: crash::take_record() };
    link::open(core.SYST, kept);
    let mut start = Pin(Operation::Start);
    let mut reset = Pin(Operation::Reset);
    let (Ok(()), Ok(())) = (start.set_low(), reset.set_high());
    // SAFETY: this is done once.
    let flash = unsafe { SettingsFlash::new() };
    Board { spi: Bridge, start, reset, drdy: Drdy, line, boot, flash }
}

/// Waits until an interrupt is pending, masked or not.
///
/// Not by WFI: the emulator then skips to the next event in another thread, and now and then some
/// nanoseconds off, so that no two runs are quite the same.
pub fn sleep() {
    /// The exception that is served next, 0 for none (Armv7-M, ICSR.VECTPENDING).
    const VECTPENDING: u32 = 0x1ff << 12;
    /// 2000 instructions are 16 us at 125 MIPS; so many ticks of SysTick, at 168 MHz, are 18 us.
    const LONG_TICKS: u32 = 3000;
    // SAFETY: reading ICSR has no side effect.
    while unsafe { (*SCB::PTR).icsr.read() } & VECTPENDING == 0 {
        // Only the alarm can end this. Few looks while it is far: each takes the emulator as long as
        // hundreds of instructions, while these take it next to nothing.
        let blocks = if SYST::get_current() > LONG_TICKS { 16 } else { 1 };
        // SAFETY: counts a register down, `blocks` is not 0.
        unsafe {
            core::arch::asm!(
                "2:", ".rept 123", "nop", ".endr", "subs {n}, #1", "bne 2b",
                n = inout(reg) blocks => _, options(nomem, nostack)
            );
        }
    }
}

/// Resets the processor; the bridge, the time and the pages of settings stay.
pub fn restart() -> ! {
    link::restart(ResetCause::Software)
}

/// Ends the emulator: all is done. Tells how deep the stack has been.
pub fn leave() {
    let (deepest, size) = (super::stack::used_bytes(), 4 * super::stack_words());
    semihost::say(format_args!("stack: {deepest} of {size} bytes used at most"));
    semihost::exit(Exit::Done)
}

/// Keeps what is known of the end and starts anew, if the PC has asked for that; else says it and ends the emulator.
pub fn die(record: &Record) -> ! {
    crash::keep(record);
    link::restart_if_asked(ResetCause::Software);
    let Record { death, pc, lr, .. } = record;
    match death {
        // Said by the panic handler, with its message.
        Death::Panic => semihost::exit(Exit::Panic),
        Death::HardFault => {
            semihost::say(format_args!("hard fault at {pc:#010x}, called from {lr:#010x}"));
            semihost::exit(Exit::Fault)
        }
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    // Only here is there room for the message.
    semihost::say(format_args!("firmware {info}"));
    die(&crash::record_of(info))
}
