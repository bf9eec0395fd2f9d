use super::{
    AFRH, APB2ENR, BSRR, Bench, FLASH_ACR, FLASH_CR, FREE, GPIOB, GPIOC, MODER, OSPEEDR, RCC_CFGR,
    RCC_CR, RCC_PLLCFGR, SPI1, TIM2, TIM10, USART3,
};
use crate::Pin;
use crate::stop::Stop;

const RCC_CIR: u32 = 0x4002_380C;

pub fn clock(speed: u32, period: u32, high: u32) -> Bench {
    let mut bench = Bench::ready();
    bench
        .set(APB2ENR, 1 << 12 | 1 << 14 | 1 << 17)
        .set(GPIOB + OSPEEDR, 0xC0 | speed << 16)
        .set(GPIOB + AFRH, 0x773)
        .set(GPIOB + MODER, 0b1010 << 20 | 0b10 << 16);
    bench
        .set(TIM10 + 0x2C, period - 1)
        .set(TIM10 + 0x34, high)
        .set(TIM10 + 0x18, 6 << 4)
        .set(TIM10 + 0x20, 1)
        .set(TIM10, 1);
    bench
}

#[test]
fn an_adc_without_another_clock_follows_the_boards() {
    let mut bench = clock(1, 11, 5);
    assert_eq!(bench.0.clock_output_hz, 15_272_727);
    bench.0.clkio_is_wired = true;
    bench.set(TIM10, 0);
    assert_eq!(bench.0.adc.clock_hz(), 0);
    bench.set(GPIOC + BSRR, 1 << 5).wait_us(1000);
    assert_eq!(bench.0.drdy_falls, None, "it does not convert");
    bench.set(TIM10, 1);
    assert_eq!(bench.0.adc.clock_hz(), 15_272_727);
    assert!(bench.0.drdy_falls.is_some());
    // Without the timer's alternate function on the pin, no clock is output.
    for moder in [0b10, 0] {
        let mut off = clock(1, 11, 5);
        off.set(GPIOB + AFRH, 0x774)
            .set(GPIOB + MODER, 0b1010 << 20 | moder << 16);
        assert_eq!(off.0.clock_output_hz, 0);
    }
    bench.keeps_all();
}

#[test]
fn the_counter_counts_microseconds_and_wraps() {
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
fn the_first_of_two_bytes_is_kept_and_the_flag_clears() {
    let mut line = Bench::ready();
    let now = line.0.time.cycles;
    line.0.usart.arrive(b'a', now + 10);
    line.0.usart.arrive(b'b', now + 2000);
    line.wait_us(15);
    assert_eq!(line.get(USART3) & 0x28, 0x28, "ORE and RXNE");
    assert_eq!(line.get(USART3 + 4), u32::from(b'a'));
    assert_eq!(line.get(USART3) & 0x28, 0, "SR and then DR clear ORE");
}

#[test]
fn the_flash_keeps_what_is_written_by_its_rules_alone() {
    let mut bench = Bench::ready();
    bench.set(FREE, 0).set(FLASH_CR, 1 | 2 << 8);
    assert_eq!((bench.get(FREE), bench.get(FLASH_CR)), (u32::MAX, 1 << 31));
    bench.unlock().set(FLASH_CR, 1 | 2 << 8).set(FREE, 0x1234);
    assert_eq!(bench.get(FREE), 0x1234);
    bench.set(FLASH_CR, 2 | 11 << 3 | 2 << 8 | 1 << 16);
    assert_eq!((bench.get(FREE), bench.0.flash.erased), (u32::MAX, 1));
    // The write that selects the sector also sets LOCK, so the next write, with STRT, is lost.
    let mut locks_itself = Bench::ready();
    locks_itself
        .unlock()
        .set(FLASH_CR, 2 | 11 << 3 | 2 << 8 | 1 << 31)
        .set(FLASH_CR, 2 | 11 << 3 | 2 << 8 | 1 << 16);
    assert_eq!(locks_itself.0.flash.erased, 0);
}

/// The PLL runs from HSI: 16 MHz / 8 * 84 / 2.
#[test]
fn an_internal_oscillator_that_is_off_takes_all_clocks_with_it() {
    for (ppm, hz) in [(0, 84_000_000), (4_000, 84_336_000), (-10_000, 83_160_000)] {
        let mut bench = Bench::new();
        bench.0.rcc.hsi_hz = (16_000_000 + 16 * ppm) as u64;
        bench.0.change_clocks();
        bench
            .set(FLASH_ACR, 0x705)
            .set(RCC_PLLCFGR, 8 | 84 << 6)
            .set(RCC_CR, 0x83 | 1 << 24)
            .wait_us(201)
            .set(RCC_CFGR, 5 << 10 | 2);
        assert_eq!((bench.0.time.hz(), bench.0.clocks.hclk), (hz, hz));
        bench.keeps_all();
    }
}

#[test]
fn the_clock_security_system_goes_on_with_hsi_and_asks_for_the_nmi() {
    for (css, nmis) in [(0, 0), (1 << 19, 1)] {
        let mut bench = Bench::ready();
        bench.set(RCC_CR, 0x83 | 1 << 16 | 1 << 24 | css);
        bench.0.stop_oscillator();
        bench.0.catch_up();
        let pending = |bench: &Bench| bench.0.scs.pending >> 2 & 1;
        assert_eq!((pending(&bench), bench.0.has_stopped), (nmis, nmis == 0));
        let mhz = if nmis == 1 { 16 } else { 168 };
        assert_eq!(bench.0.clocks.hclk, mhz * 1_000_000);
        if nmis == 1 {
            assert_eq!(bench.get(RCC_CIR), 1 << 7, "CSSF");
            // The interrupt is requested until the flag is cleared.
            bench.0.scs.begin(2);
            bench.0.scs.end(2);
            bench.wait_us(1);
            assert_eq!(pending(&bench), 1);
            bench.0.scs.begin(2);
            bench.set(RCC_CIR, 1 << 23);
            bench.0.scs.end(2);
            bench.wait_us(1);
            assert_eq!((pending(&bench), bench.get(RCC_CIR)), (0, 0));
        }
        bench.keeps_all();
    }
}

#[test]
fn pins_are_seen_and_set_from_outside() {
    let mut bench = Bench::ready();
    let [start, line4] = ["PC5", "PB4"].map(|name| Pin::named(name).expect("a pin"));
    assert_eq!(bench.0.port(start).driven(5), Some(false));
    bench.set(GPIOC + BSRR, 1 << 5);
    assert_eq!(bench.0.port(start).driven(5), Some(true));
    for name in ["PD1", "PA16", "A5", "P", ""] {
        assert_eq!(Pin::named(name), None, "{name}");
    }
    // Set EXTI4 to falling edges on port B.
    bench
        .set(0x4001_380C, 1)
        .set(0x4001_3C00, 1 << 4)
        .set(0x4001_3C0C, 1 << 4);
    for (high, requests) in [(true, false), (false, true)] {
        bench.0.set_outside(line4, high);
        assert_eq!(bench.0.exti.is_requested(4), requests);
    }
}

#[test]
fn an_interrupt_whose_cause_is_gone() {
    let mut bench = Bench::ready();
    let scs = &mut bench.0.scs;
    let mut take = |causes: fn(&mut crate::scs::Scs)| {
        causes(scs);
        scs.begin(26);
        let served_before = scs.served[26].served_before;
        (std::mem::take(&mut scs.spurious), served_before)
    };
    let flickers = |scs: &mut crate::scs::Scs| {
        scs.set_line(10, true);
        scs.set_line(10, false);
    };
    assert_eq!(take(flickers), (vec![10], 0));
    // Sets an exception pending by software.
    let by_software = |scs: &mut crate::scs::Scs| {
        scs.write(0xE000_E200, 4, 1 << 10).expect("ISPR");
    };
    assert_eq!(take(by_software), (vec![], 0));
    // A cause that rises while the handler or one of the same priority runs is served by that run.
    assert_eq!(take(flickers), (vec![], 1));
    // Other code removes the cause between two runs, so the second run is spurious.
    let between = |scs: &mut crate::scs::Scs| {
        scs.end(26);
        scs.set_line(10, true);
        scs.set_line(10, false);
    };
    assert_eq!(take(between), (vec![10], 1));
}

#[test]
fn accesses_that_are_not_modelled_end_the_run() {
    let mut bench = Bench::ready();
    for address in [0x4000_0400, SPI1 + 4, 0xE000_E010, 0x4002_6400] {
        let outcome = bench.0.write(address, 4, 0x80);
        assert!(matches!(outcome, Err(Stop::Failed(_))), "{address:#x}");
    }
    let below_ram = bench.0.read(0x1FFF_FFFC, 4);
    assert_eq!(below_ram, Err(Stop::Bus(0x1FFF_FFFC)));
}
