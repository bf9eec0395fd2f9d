//! Time: TIM2 as the microsecond counter, 32 bit, wrapping after 71.6 minutes; TIM4 as a slow
//! heartbeat.

use stm32f4xx_hal::pac::{RCC, TIM2, TIM4};
use stm32f4xx_hal::rcc::{Enable, Reset};

/// Starts the counter. `ticks_per_us` is the timer's clock in MHz, up to 65536.
pub fn start(timer: TIM2, rcc: &mut RCC, ticks_per_us: u32) {
    TIM2::enable(rcc);
    TIM2::reset(rcc);
    timer
        .psc()
        .write(|w| w.psc().set(ticks_per_us.saturating_sub(1) as u16));
    // Manuals and register descriptions disagree on the reset value, so write it.
    timer.arr().write(|w| w.arr().set(u32::MAX));
    // Load the prescaler now instead of at the first wrap.
    timer.egr().write(|w| w.ug().set_bit());
    timer.cr1().write(|w| w.cen().set_bit());
}

/// Starts TIM4, which interrupts every half second. `ticks_per_us` is the timer's clock in MHz, up
/// to 130.
pub fn start_heartbeat(timer: TIM4, rcc: &mut RCC, ticks_per_us: u32) {
    TIM4::enable(rcc);
    TIM4::reset(rcc);
    // 1000 periods of 500 us each. The counter has 16 bits.
    timer.psc().write(|w| {
        w.psc()
            .set(ticks_per_us.saturating_mul(500).saturating_sub(1) as u16)
    });
    timer.arr().write(|w| w.arr().set(999));
    timer.egr().write(|w| w.ug().set_bit());
    timer.sr().write(|w| w.uif().clear_bit());
    timer.dier().write(|w| w.uie().set_bit());
    timer.cr1().write(|w| w.cen().set_bit());
}

pub fn acknowledge_heartbeat() {
    // SAFETY: TIM4 always exists, nothing else uses it once it runs, and a write to its status only
    // clears flags.
    unsafe { (*TIM4::ptr()).sr().write(|w| w.uif().clear_bit()) };
    cortex_m::asm::dsb();
}

/// Microseconds since [`start`], wrapping.
#[inline(always)]
pub fn now_us() -> u32 {
    // SAFETY: TIM2 always exists, and reading its counter has no side effect.
    unsafe { (*TIM2::ptr()).cnt().read().bits() }
}
