//! Clocks, and who needs them.

use super::{Bench, FLASH_ACR, RCC_CFGR, RCC_CR, RCC_PLLCFGR, SPI1};
use crate::findings::Rule;

#[test]
pub(super) fn a_peripheral_without_its_clock() {
    let mut bench = Bench::new();
    bench.get(SPI1);
    bench.breaks(Rule::ClockOn);
}

#[test]
pub(super) fn the_pll_is_set_while_it_runs() {
    let mut bench = Bench::ready();
    bench.set(RCC_PLLCFGR, 6 | 168 << 6 | 1 << 22);
    bench.breaks(Rule::PllOff);
}

#[test]
pub(super) fn hse_becomes_a_clock_while_it_runs() {
    let mut bench = Bench::ready();
    bench.set(RCC_CR, 0x83 | 5 << 16 | 1 << 24);
    bench.breaks(Rule::HseOff);
    assert_eq!(bench.get(RCC_CR) & 1 << 18, 0, "the write is lost");
    let mut right = Bench::new();
    right
        .set(RCC_CR, 0x83 | 1 << 18)
        .set(RCC_CR, 0x83 | 5 << 16);
    right.keeps_all();
}

#[test]
pub(super) fn too_few_wait_states() {
    let mut bench = Bench::ready();
    bench
        .set(RCC_CFGR, 0)
        .set(FLASH_ACR, 4)
        .set(RCC_CFGR, 5 << 10 | 4 << 13 | 2);
    bench.breaks(Rule::WaitStates);
}

#[test]
pub(super) fn clocks_beyond_their_limits() {
    for cfgr in [4 << 10 | 4 << 13 | 2, 5 << 10 | 2] {
        let mut bench = Bench::ready();
        bench.set(RCC_CFGR, cfgr);
        bench.breaks(Rule::ClockLimit);
    }
    let mut too_early = Bench::new();
    too_early
        .set(FLASH_ACR, 5)
        .set(RCC_CR, 0x83 | 1 << 16)
        .wait_us(1000)
        .set(RCC_CFGR, 1);
    too_early.breaks(Rule::ClockLimit);
}
