//! Watchdog, timers, interrupts, and what is not modelled.

use super::{Bench, IWDG, SPI1, TIM2};
use crate::findings::Rule;

#[test]
pub(super) fn a_watchdog_that_nobody_feeds() {
    let mut bench = Bench::ready();
    bench
        .set(IWDG, 0xCCCC)
        .set(IWDG, 0x5555)
        .set(IWDG + 4, 0)
        .set(IWDG + 8, 31)
        .wait_us(160)
        .set(IWDG, 0xAAAA);
    bench.wait_us(3900).set(IWDG, 0xAAAA).wait_us(3900);
    bench.keeps_all();
    bench.wait_us(200);
    bench.breaks(Rule::Watchdog);
    assert!(bench.0.has_bitten);
}

#[test]
pub(super) fn a_timer_with_the_reload_value_of_the_reset() {
    let mut bench = Bench::ready();
    bench.set(TIM2 + 0x2C, u32::MAX).set(TIM2, 1);
    bench.keeps_all();
    let mut unset = Bench::ready();
    unset.set(TIM2, 1);
    unset.breaks(Rule::TimerReload);
}

#[test]
pub(super) fn the_counter_counts_microseconds_and_wraps() {
    let mut bench = Bench::ready();
    bench
        .set(TIM2 + 0x2C, u32::MAX)
        .set(TIM2 + 0x28, 83)
        .set(TIM2 + 0x14, 1)
        .set(TIM2, 1);
    let from = bench.get(TIM2 + 0x24);
    bench.wait_us(12_345);
    assert!(bench.get(TIM2 + 0x24) - from - 12_345 <= 1);
    bench.set(TIM2 + 0x24, u32::MAX - 10).wait_us(20);
    assert!((9..=10).contains(&bench.get(TIM2 + 0x24)));
}

#[test]
pub(super) fn an_interrupt_whose_cause_is_gone() {
    let mut bench = Bench::ready();
    let scs = &mut bench.0.scs;
    scs.set_line(10, true);
    scs.set_line(10, false);
    scs.begin(26);
    assert_eq!(std::mem::take(&mut scs.spurious), [10]);
    scs.write(0xE000_E200, 4, 1 << 10).expect("ISPR");
    scs.begin(26);
    assert_eq!(scs.spurious, [], "software's own");
    // Its cause rises while it runs, or another of the same priority, and that run serves it.
    scs.set_line(10, true);
    scs.set_line(10, false);
    scs.begin(26);
    assert_eq!(
        (
            std::mem::take(&mut scs.spurious),
            scs.served[26].served_before
        ),
        (vec![], 1)
    );
    // Somebody else takes the cause away between two runs.
    scs.end(26);
    scs.set_line(10, true);
    scs.set_line(10, false);
    scs.begin(26);
    assert_eq!(
        (
            std::mem::take(&mut scs.spurious),
            scs.served[26].served_before
        ),
        (vec![10], 1)
    );
}

#[test]
pub(super) fn what_is_not_modelled_ends_the_run() {
    let mut bench = Bench::ready();
    for address in [0x4000_0400, SPI1 + 4, 0xE000_E010, 0x4002_6400] {
        assert!(
            matches!(
                bench.0.write(address, 4, 0x80),
                Err(crate::stop::Stop::Failed(_))
            ),
            "{address:#x}"
        );
    }
    assert_eq!(
        bench.0.read(0x1FFF_FFFC, 4),
        Err(crate::stop::Stop::Bus(0x1FFF_FFFC)),
        "below the RAM is nothing"
    );
}
