//! The ADS1258's clock on CLKIO, from TIM10 on PB8, if the plan selects it.

use super::CLOCKS;
use ridgetone_finger::converter::ChipClock;
use stm32f4xx_hal::gpio::{Alternate, PB8, Speed};
use stm32f4xx_hal::pac::TIM10;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

const TIMER_HZ: u32 = CLOCKS.apb2_timers_mhz() * 1_000_000;
/// Timer clocks per period of the chip's clock, which may be up to 16 MHz.
const PERIOD: u16 = TIMER_HZ.div_ceil(16_000_000) as u16;
/// Timer clocks at high level: about 45 % of a period. The chip allows 40 to 60 % (SBAS297G).
const HIGH: u16 = (9 * PERIOD + 10) / 20;
const _: () = assert!(2 * PERIOD <= 5 * HIGH && 5 * HIGH <= 3 * PERIOD);
/// Value of the setting `plan.adc_clock_hz` that selects this clock, rounded: 15,272,727 at 168
/// MHz.
const CLOCK_HZ: u32 = (TIMER_HZ + PERIOD as u32 / 2) / PERIOD as u32;

/// The timer and its pin, which is an input while the chip runs from a different clock.
pub struct TimerClock {
    timer: TIM10,
    /// `None` only within [`ChipClock::run`].
    pin: Option<ClockPin>,
}

enum ClockPin {
    Off(PB8),
    On(PB8<Alternate<3>>),
}

impl TimerClock {
    pub fn new(timer: TIM10, pin: PB8, rcc: &mut Rcc) -> Self {
        let mut pin = pin.into_alternate::<3>();
        // Medium speed suffices up to 25 MHz at 50 pF (DS8626 and DS10693, I/O AC characteristics).
        pin.set_speed(Speed::Medium);
        let pin = pin.into_input();
        TIM10::enable(rcc);
        TIM10::reset(rcc);
        timer.arr().write(|w| w.arr().set(PERIOD - 1));
        timer.ccr1().write(|w| w.ccr().set(HIGH));
        timer.ccmr1_output().write(|w| w.oc1m().pwm_mode1());
        timer.ccer().write(|w| w.cc1e().set_bit());
        Self {
            timer,
            pin: Some(ClockPin::Off(pin)),
        }
    }
}

impl ChipClock for TimerClock {
    fn run(&mut self, hz: u32) -> bool {
        let runs = hz == CLOCK_HZ;
        self.timer.cr1().write(|w| w.cen().bit(runs));
        let pin = self.pin.take();
        let begins = runs && matches!(pin, Some(ClockPin::Off(_)));
        self.pin = match pin {
            Some(ClockPin::Off(pin)) if runs => Some(ClockPin::On(pin.into_alternate())),
            Some(ClockPin::On(pin)) if !runs => Some(ClockPin::Off(pin.into_input())),
            pin => pin,
        };
        begins
    }
}
