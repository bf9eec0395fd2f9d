//! Pins, SPI and the serial line.

use super::{
    AFRH, AFRL, APB2ENR, BSRR, Bench, GPIOA, GPIOB, GPIOC, MODER, OSPEEDR, SPI_ON, SPI1, TIM10,
    USART3,
};
use crate::findings::Rule;

#[test]
pub(super) fn a_slow_pad_of_sck() {
    for (speed, is_broken) in [(0, true), (1, true), (2, false), (3, false)] {
        let mut bench = Bench::new();
        bench
            .clocks()
            .pins()
            .set(GPIOA + OSPEEDR, speed << 10)
            .set(SPI1, SPI_ON);
        if is_broken {
            bench.breaks(Rule::PadSpeed)
        } else {
            bench.keeps_all()
        }
    }
}

#[test]
pub(super) fn a_pin_with_another_function() {
    let mut bench = Bench::new();
    bench
        .clocks()
        .pins()
        .set(GPIOA + AFRL, 0x565 << 20)
        .set(SPI1, SPI_ON);
    bench.breaks(Rule::PinFunction);
    let mut line = Bench::new();
    line.clocks()
        .pins()
        .set(GPIOB + MODER, 0b1000 << 20)
        .set(USART3 + 0x0C, 0x200C)
        .set(USART3 + 4, 0);
    line.breaks(Rule::PinFunction);
}

#[test]
pub(super) fn another_mode_and_a_faster_clock() {
    for (cr1, rule) in [
        (SPI_ON | 1, Rule::SpiMode),
        (SPI_ON | 2, Rule::SpiMode),
        (SPI_ON | 1 << 7, Rule::SpiMode),
        (SPI_ON & !0x38 | 2 << 3, Rule::SpiClock),
    ] {
        let mut bench = Bench::new();
        bench.clocks().pins().set(SPI1, cr1);
        bench.breaks(rule);
    }
}

#[test]
pub(super) fn cs_that_leaves_no_time() {
    let mut bench = Bench::ready();
    bench.wait_us(1).cs(true).wait_us(1).byte(0x30);
    bench.cs(false).wait_us(1).cs(true).wait_us(1).byte(0x30);
    bench.keeps_all();
    bench.cs(false).wait_us(1).cs(true).byte(0x30);
    bench.breaks(Rule::ChipSelect);

    let mut short = Bench::ready();
    short.wait_us(1).cs(true).wait_us(1).byte(0x30);
    short.cs(false).cs(true);
    short.breaks(Rule::ChipSelect);

    // The last bit is received half a clock, 16 cycles, before it ends.
    for (waits_for_busy, is_broken) in [(false, true), (true, false)] {
        let mut bench = Bench::ready();
        bench.wait_us(1).cs(true).wait_us(1).set(SPI1 + 0x0C, 0x30);
        while bench.get(SPI1 + 8) & 1 == 0 {}
        bench.get(SPI1 + 0x0C);
        while waits_for_busy && bench.get(SPI1 + 8) & 1 << 7 != 0 {}
        bench.cs(false);
        if is_broken {
            bench.breaks(Rule::ChipSelect)
        } else {
            bench.keeps_all()
        }
    }
}

#[test]
pub(super) fn a_register_of_the_adc_written_while_it_scans() {
    let mut bench = Bench::ready();
    let write = |bench: &mut Bench| {
        bench.cs(true).wait_us(1);
        bench.byte(0x61);
        bench.byte(0x83);
        bench.cs(false).wait_us(1);
    };
    bench.wait_us(1);
    write(&mut bench);
    bench.keeps_all();
    bench.set(GPIOC + BSRR, 1 << 5);
    write(&mut bench);
    bench.breaks(Rule::AdcWrite);
}

/// A clock on PB8 with a speed of its pad.
fn clock(speed: u32, period: u32, high: u32) -> Bench {
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
pub(super) fn a_clock_for_the_adc_beyond_its_limits() {
    for (period, high, broken) in [
        (11, 5, false),
        (11, 6, false),
        (11, 4, true),
        (11, 7, true),
        (10, 5, true),
    ] {
        let bench = clock(1, period, high);
        assert_eq!(bench.0.clock_output_hz, (168_000_000 + period / 2) / period);
        if broken {
            bench.breaks(Rule::AdcClock)
        } else {
            bench.keeps_all()
        }
    }
    clock(0, 11, 5).breaks(Rule::PadSpeed);
    // Another function of the pin, or none.
    for moder in [0b10, 0] {
        let mut off = clock(1, 11, 5);
        off.set(GPIOB + AFRH, 0x774)
            .set(GPIOB + MODER, 0b1010 << 20 | moder << 16);
        assert_eq!(off.0.clock_output_hz, 0);
    }
}

#[test]
fn an_adc_without_another_clock_follows_the_boards() {
    let mut bench = clock(1, 11, 5);
    bench.0.clkio_is_wired = true;
    bench.set(TIM10, 0);
    assert_eq!(bench.0.adc.clock_hz(), 0);
    bench.set(GPIOC + BSRR, 1 << 5).wait_us(1000);
    assert_eq!(bench.0.drdy_falls, None, "it does not convert");
    bench.set(TIM10, 1);
    assert_eq!(bench.0.adc.clock_hz(), 15_272_727);
    assert!(bench.0.drdy_falls.is_some());
    bench.keeps_all();
}

#[test]
pub(super) fn bytes_that_nobody_fetches() {
    let mut spi = Bench::ready();
    spi.set(SPI1 + 0x0C, 0)
        .wait_us(2)
        .set(SPI1 + 0x0C, 0)
        .wait_us(2);
    spi.breaks(Rule::SpiOverrun);
    assert_eq!(spi.get(SPI1 + 8) & 1 << 6, 1 << 6, "OVR");

    let mut line = Bench::ready();
    let now = line.0.time.cycles;
    line.0.usart.arrive(b'a', now + 10);
    line.0.usart.arrive(b'b', now + 2000);
    line.wait_us(5);
    line.keeps_all();
    line.wait_us(10);
    line.breaks(Rule::UsartOverrun);
    assert_eq!(line.get(USART3) & 0x28, 0x28, "ORE and RXNE");
    assert_eq!(
        line.get(USART3 + 4),
        u32::from(b'a'),
        "the first byte is kept"
    );
    assert_eq!(line.get(USART3) & 0x28, 0, "SR and then DR clear ORE");
}
