//! Common to all boards with an STM32F4, the stylus included: clocks, the two timers, the watchdog,
//! the end of a run.

use super::clocks::Pll;
use super::{CLOCKS, crash};
use cortex_m::peripheral::NVIC;
use defmt_rtt as _;
use ridgetone_finger::tasks::WATCHDOG_S;
use ridgetone_proto::boot::{Boot, BrownOut, Oscillator, Record, ResetCause};
use stm32f4xx_hal::pac::{self, DBGMCU, IWDG, PWR, RCC, TIM2, TIM4};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Rcc};

/// Reads of RCC_CR, 4 cycles of 16 MHz each at least, that the external oscillator may take to
/// start: 100 ms. A crystal takes 2 ms (DS8626, HSE start-up time, typical).
const OSCILLATOR_READS: u32 = 400_000;

/// Starts the watchdog before the clocks, and finds out how this run began.
pub fn begin(device: &pac::Peripherals) -> Boot {
    // First: the wait for a crystal that does not start never ends.
    start_watchdog(&device.IWDG, &device.DBGMCU);
    let brown_out = BrownOut::from_option_bytes(device.FLASH.optcr().read().bits());
    let cause = take_reset_cause(&device.RCC);
    let boot = Boot {
        cause,
        oscillator: Oscillator::Unknown,
        brown_out,
        record: crash::take_record(),
    };
    stay_debuggable(&device.DBGMCU);
    boot
}

/// Keeps a debugger's clock and the memory of the RTT buffer while the processor sleeps.
fn stay_debuggable(debug: &DBGMCU) {
    debug.cr().modify(|_, w| {
        w.dbg_sleep()
            .set_bit()
            .dbg_stop()
            .set_bit()
            .dbg_standby()
            .set_bit()
    });
}

/// Clears the interrupt TIM4. A debugger that detaches restores DBGMCU_CR as it was before the
/// image ran (probe-rs does), so that the next one would find a processor that sleeps: the bits are
/// set again.
pub fn acknowledge_heartbeat() {
    super::clock::acknowledge_heartbeat();
    // SAFETY: nothing else uses it once tasks run, and the three bits affect debugging alone.
    let debug = unsafe { DBGMCU::steal() };
    stay_debuggable(&debug);
}

/// Runs the processor from the board's oscillator, or from its own if that one does not start, at
/// [`CLOCKS`], and starts the two timers.
pub fn start_clocks(rcc: RCC, counter: TIM2, heartbeat: TIM4) -> (Rcc, Oscillator) {
    const PLL: Pll = CLOCKS.pll();
    stop_pll(&rcc);
    if let Some(vos) = CLOCKS.vos {
        widen_voltage(&rcc, vos);
    }
    let has_started = start_external(&rcc);
    // The HAL (0.23) waits for an external oscillator for ever. So it sets up all from the internal
    // one. It is called once, with constants: so the compiler removes its panics. After it only the
    // PLL changes.
    let mut rcc = rcc.freeze(
        Config::hsi()
            .sysclk(CLOCKS.sysclk_mhz.MHz())
            .pclk1(CLOCKS.apb1_mhz.MHz())
            .pclk2(CLOCKS.apb2_mhz.MHz()),
    );
    let oscillator = if has_started {
        Oscillator::External
    } else {
        Oscillator::Internal
    };
    if has_started {
        stop_pll(&rcc);
        // SAFETY: of the allowed values, see `Clocks::pll`.
        rcc.pllcfgr().write(|w| unsafe {
            w.pllsrc()
                .hse()
                .pllm()
                .bits(PLL.m as u8)
                .plln()
                .bits(PLL.n as u16)
                .pllp()
                .bits((PLL.p / 2 - 1) as u8)
                .pllq()
                .bits(PLL.q as u8)
        });
        rcc.cr().modify(|_, w| w.pllon().set_bit());
        while rcc.cr().read().pllrdy().bit_is_clear() {}
        rcc.cfgr().modify(|_, w| w.sw().pll());
        while !rcc.cfgr().read().sws().is_pll() {}
        rcc.cr().modify(|_, w| w.csson().set_bit());
    }
    super::clock::start(counter, &mut rcc, CLOCKS.apb1_timers_mhz());
    super::clock::start_heartbeat(heartbeat, &mut rcc, CLOCKS.apb1_timers_mhz());
    (rcc, oscillator)
}

/// Chooses the voltage regulator's range, with the PLL off (RM0383, 5.4.1). It takes effect as the
/// PLL starts.
fn widen_voltage(rcc: &RCC, vos: u32) {
    rcc.apb1enr().modify(|_, w| w.pwren().set_bit());
    cortex_m::asm::dsb();
    // SAFETY: nothing else uses it; VOS is bits 15 and 14.
    unsafe {
        (*PWR::ptr())
            .cr()
            .modify(|r, w| w.bits(r.bits() & !(3 << 14) | vos << 14))
    };
}

/// Runs on the internal oscillator, with the PLL off: its divisors can be written only then
/// (RM0090, 7.3.2). The boot loader in the chip's ROM starts an image with it on.
fn stop_pll(rcc: &RCC) {
    rcc.cr().modify(|_, w| w.hsion().set_bit());
    while rcc.cr().read().hsirdy().bit_is_clear() {}
    rcc.cfgr().modify(|_, w| w.sw().hsi());
    while !rcc.cfgr().read().sws().is_hsi() {}
    rcc.cr().modify(|_, w| w.pllon().clear_bit());
    while rcc.cr().read().pllrdy().bit_is_set() {}
}

/// Starts the external oscillator anew. False, and it is off, if it does not start within
/// [`OSCILLATOR_READS`].
fn start_external(rcc: &RCC) -> bool {
    rcc.cr().modify(|_, w| w.hseon().clear_bit());
    // Its kind can be chosen only while it is off (RM0090, 7.3.1).
    while rcc.cr().read().hserdy().bit_is_set() {}
    rcc.cr().modify(|_, w| w.hsebyp().bit(CLOCKS.is_clock()));
    rcc.cr().modify(|_, w| w.hseon().set_bit());
    let has_started = (0..OSCILLATOR_READS).any(|_| rcc.cr().read().hserdy().bit_is_set());
    if !has_started {
        rcc.cr().modify(|_, w| w.hseon().clear_bit());
    }
    has_started
}

/// Handles the failure of the external oscillator. The processor now runs at 16 MHz (RM0090, 7.2.7), so
/// every time in this run is wrong: the board restarts on the internal oscillator and reports it.
#[cortex_m_rt::exception]
unsafe fn NonMaskableInt() -> ! {
    die(&Record::of_oscillator(super::clock::now_us()))
}

/// Masks an interrupt that no task serves. The boot loader in the chip's ROM may have left one on,
/// such as USB's. cortex-m-rt's own handler would wait for the watchdog.
#[cortex_m_rt::exception]
unsafe fn DefaultHandler(number: i16) {
    /// An interrupt by its number.
    #[derive(Clone, Copy)]
    struct Unserved(u16);
    // SAFETY: the number is that of the interrupt that is being served.
    unsafe impl cortex_m::interrupt::InterruptNumber for Unserved {
        fn number(self) -> u16 {
            self.0
        }
    }
    if let Ok(number) = u16::try_from(number) {
        NVIC::mask(Unserved(number));
    }
}

/// Starts the independent watchdog (RM0090, 21.3). It stops for a debugger that halts the
/// processor.
fn start_watchdog(watchdog: &IWDG, debug: &DBGMCU) {
    /// Divides by 64: a tick takes 2 ms of the nominal 32 kHz.
    const PRESCALER: u16 = 4;
    const TICKS: u32 = 500 * WATCHDOG_S;
    const { assert!(TICKS <= 4095, "the counter has 12 bits") };
    debug.apb1_fz().modify(|_, w| w.dbg_iwdg_stop().set_bit());
    // SAFETY: the keys that start it and open its registers.
    watchdog.kr().write(|w| unsafe { w.bits(0xcccc) });
    watchdog.kr().write(|w| unsafe { w.bits(0x5555) });
    // SAFETY: 0 to 6 are allowed.
    watchdog.pr().write(|w| unsafe { w.bits(PRESCALER) });
    // SAFETY: 12 bits, see above.
    watchdog.rlr().write(|w| unsafe { w.bits(TICKS as u16) });
    // Both values take some of its ticks to arrive; if fed before, it would start from the old
    // ones.
    while watchdog.sr().read().bits() != 0 {}
    feed_watchdog();
}

pub fn feed_watchdog() {
    // SAFETY: the key that reloads the counter, without any other effect.
    unsafe { (*IWDG::ptr()).kr().write(|w| w.bits(0xaaaa)) };
}

/// The cause of the reset. The flags are cleared, or they would add up.
fn take_reset_cause(rcc: &RCC) -> ResetCause {
    let flags = rcc.csr().read().bits();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    ResetCause::from_flags(flags)
}

/// Keeps the record for the next run's greeting and log, and resets. Nothing is logged here: the
/// panic may be the log's.
pub fn die(record: &Record) -> ! {
    crash::keep(record);
    cortex_m::peripheral::SCB::sys_reset()
}

/// Formatting the message would take 9 KB of flash.
#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    die(&crash::record_of(info))
}

pub fn sleep() {
    cortex_m::asm::wfi();
}

pub fn restart() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}
