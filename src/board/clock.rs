//! Time: TIM2 as the microsecond counter, 32 bit, free running, wrapping after 71.6 minutes; SysTick as
//! a slow heartbeat.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use stm32f4xx_hal::pac::{RCC, TIM2};
use stm32f4xx_hal::rcc::{Enable, Reset};

/// Starts the counter. `ticks_per_us`: the timer's clock in MHz, at most 65536.
pub fn start(timer: TIM2, rcc: &mut RCC, ticks_per_us: u32) {
    TIM2::enable(rcc);
    TIM2::reset(rcc);
    timer.psc().write(|w| w.psc().set(ticks_per_us.saturating_sub(1) as u16));
    // Loads the prescaler now instead of at the first wrap.
    timer.egr().write(|w| w.ug().set_bit());
    timer.cr1().write(|w| w.cen().set_bit());
}

/// Starts SysTick's interrupt. Period: `ticks` of an eighth of the processor's clock, at most 2^24.
pub fn start_heartbeat(mut syst: SYST, ticks: u32) {
    syst.set_clock_source(SystClkSource::External);
    syst.set_reload(ticks.saturating_sub(1));
    syst.clear_current();
    syst.enable_interrupt();
    syst.enable_counter();
}

/// Microseconds since [`start`], wrapping.
#[inline(always)]
pub fn now_us() -> u32 {
    // SAFETY: TIM2 exists for ever, and reading its counter has no side effect, so no owner can mind.
    unsafe { (*TIM2::ptr()).cnt().read().bits() }
}
