//! Code common to all boards with an STM32F4, including the stylus: clocks, the two timers, the
//! watchdog, crash and reset.

use super::clocks::Pll;
use super::{CLOCKS, crash};
use cortex_m::peripheral::NVIC;
use defmt_rtt as _;
use ridgetone_finger::tasks::WATCHDOG_S;
use ridgetone_proto::boot::{Boot, BrownOut, Oscillator, Record, ResetCause};
use stm32f4xx_hal::pac::{self, DBGMCU, IWDG, PWR, RCC, TIM2, TIM4};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Rcc};

/// Number of reads of RCC_CR while the external oscillator starts: 100 ms, at 4 or more cycles of
/// 16 MHz each. A crystal takes 2 ms (DS8626, HSE start-up time, typical).
const OSCILLATOR_READS: u32 = 400_000;

/// Starts the watchdog before the clocks, and determines how this run began.
pub fn begin(device: &pac::Peripherals) -> Boot {
    // Start the watchdog first, because a wait for a dead oscillator may never end.
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

/// Keeps a debugger's clock and the memory of the RTT buffer on while the processor sleeps.
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

/// Clears the TIM4 interrupt. A debugger that detaches restores DBGMCU_CR to its value before the
/// image ran (as probe-rs does), and the next debugger would then find a sleeping processor, so
/// this sets the bits again.
pub fn acknowledge_heartbeat() {
    super::clock::acknowledge_heartbeat();
    // SAFETY: nothing else uses DBGMCU once tasks run, and the three bits only affect debugging.
    let debug = unsafe { DBGMCU::steal() };
    stay_debuggable(&debug);
}

/// Runs the processor at [`CLOCKS`] from the board's oscillator, or from the internal one if that
/// does not start, and starts the two timers.
pub fn start_clocks(rcc: RCC, counter: TIM2, heartbeat: TIM4) -> (Rcc, Oscillator) {
    const PLL: Pll = CLOCKS.pll();
    stop_pll(&rcc);
    if let Some(vos) = CLOCKS.vos {
        widen_voltage(&rcc, vos);
    }
    let has_started = start_external(&rcc);
    // The HAL (0.23) waits for an external oscillator for ever, so let it set up everything from
    // the internal one. It is called once, with constants, so that the compiler removes its panics.
    // Afterwards only the PLL changes.
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
        // SAFETY: allowed values, see `Clocks::pll`.
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

/// Selects the voltage regulator's range while the PLL is off (RM0383, 5.4.1). The range takes
/// effect when the PLL starts.
fn widen_voltage(rcc: &RCC, vos: u32) {
    rcc.apb1enr().modify(|_, w| w.pwren().set_bit());
    cortex_m::asm::dsb();
    // SAFETY: nothing else uses PWR; VOS is bits 15 and 14.
    unsafe {
        (*PWR::ptr())
            .cr()
            .modify(|r, w| w.bits(r.bits() & !(3 << 14) | vos << 14))
    };
}

/// Switches to the internal oscillator and turns the PLL off, because its dividers can only be
/// written then (RM0090, 7.3.2). The boot loader in the chip's ROM starts an image with the PLL on.
fn stop_pll(rcc: &RCC) {
    rcc.cr().modify(|_, w| w.hsion().set_bit());
    while rcc.cr().read().hsirdy().bit_is_clear() {}
    rcc.cfgr().modify(|_, w| w.sw().hsi());
    while !rcc.cfgr().read().sws().is_hsi() {}
    rcc.cr().modify(|_, w| w.pllon().clear_bit());
    while rcc.cr().read().pllrdy().bit_is_set() {}
}

/// Restarts the external oscillator. Returns false, with the oscillator off, if it does not start
/// within [`OSCILLATOR_READS`].
fn start_external(rcc: &RCC) -> bool {
    rcc.cr().modify(|_, w| w.hseon().clear_bit());
    // Crystal or clock can only be selected while HSE is off (RM0090, 7.3.1).
    while rcc.cr().read().hserdy().bit_is_set() {}
    rcc.cr().modify(|_, w| w.hsebyp().bit(CLOCKS.is_clock()));
    rcc.cr().modify(|_, w| w.hseon().set_bit());
    let has_started = (0..OSCILLATOR_READS).any(|_| rcc.cr().read().hserdy().bit_is_set());
    if !has_started {
        rcc.cr().modify(|_, w| w.hseon().clear_bit());
    }
    has_started
}

/// Handles a failure of the external oscillator. The processor now runs at 16 MHz (RM0090, 7.2.7),
/// so all times in this run are wrong: the board restarts on the internal oscillator and reports
/// the failure.
#[cortex_m_rt::exception]
unsafe fn NonMaskableInt() -> ! {
    die(&Record::of_oscillator(super::clock::now_us()))
}

/// Masks an interrupt that no task serves. The boot loader in the chip's ROM may have left one on,
/// such as USB's. cortex-m-rt's default handler would loop until the watchdog resets the board.
#[cortex_m_rt::exception]
unsafe fn DefaultHandler(number: i16) {
    /// Number of an interrupt that no task serves.
    #[derive(Clone, Copy)]
    struct Unserved(u16);
    // SAFETY: this is the number of the interrupt being served.
    unsafe impl cortex_m::interrupt::InterruptNumber for Unserved {
        fn number(self) -> u16 {
            self.0
        }
    }
    if let Ok(number) = u16::try_from(number) {
        NVIC::mask(Unserved(number));
    }
}

/// Starts the independent watchdog (RM0090, 21.3). It pauses while a debugger halts the processor.
fn start_watchdog(watchdog: &IWDG, debug: &DBGMCU) {
    /// Divides by 64: a tick takes 2 ms at the nominal 32 kHz.
    const PRESCALER: u16 = 4;
    const TICKS: u32 = 500 * WATCHDOG_S;
    const { assert!(TICKS <= 4095, "the counter has 12 bits") };
    debug.apb1_fz().modify(|_, w| w.dbg_iwdg_stop().set_bit());
    // SAFETY: the keys that start the watchdog and unlock its registers.
    watchdog.kr().write(|w| unsafe { w.bits(0xcccc) });
    watchdog.kr().write(|w| unsafe { w.bits(0x5555) });
    // SAFETY: 0 to 6 are allowed.
    watchdog.pr().write(|w| unsafe { w.bits(PRESCALER) });
    // SAFETY: 12 bits, as asserted above.
    watchdog.rlr().write(|w| unsafe { w.bits(TICKS as u16) });
    // Both values take a few ticks to take effect; if fed earlier, the watchdog would start from
    // the old values.
    while watchdog.sr().read().bits() != 0 {}
    feed_watchdog();
}

pub fn feed_watchdog() {
    // SAFETY: this key reloads the counter and has no other effect.
    unsafe { (*IWDG::ptr()).kr().write(|w| w.bits(0xaaaa)) };
}

/// Returns the cause of the reset. Clears the flags, which would otherwise accumulate.
fn take_reset_cause(rcc: &RCC) -> ResetCause {
    let flags = rcc.csr().read().bits();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    ResetCause::from_flags(flags)
}

/// Keeps the record for the next run's greeting and log, and resets. Nothing is logged here,
/// because the log itself may have panicked.
pub fn die(record: &Record) -> ! {
    crash::keep(record);
    cortex_m::peripheral::SCB::sys_reset()
}

/// Records a panic without its message: formatting it would take 9 KB of flash.
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
