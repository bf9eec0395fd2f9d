//! Tests of the encoder's counter, and of the DAC triggered by TIM6.

use super::{AFRL, APB1ENR, Bench, GPIOA, GPIOC, MODER};
use crate::board::Board;
use crate::findings::Rule;

const TIM3: u32 = 0x4000_0400;
const TIM6: u32 = 0x4000_1000;
const DAC: u32 = 0x4000_7400;
const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const SMCR: u32 = 0x08;
const DIER: u32 = 0x0C;
const SR: u32 = 0x10;
const CCMR1: u32 = 0x18;
const CNT: u32 = 0x24;
const PSC: u32 = 0x28;
const ARR: u32 = 0x2C;
const DHR12R1: u32 = 0x08;
const DOR1: u32 = 0x2C;

/// Creates a stylus with clocks on, PC6 and PC7 assigned to TIM3, PA4 analogue.
fn bench() -> Bench {
    let mut bench = Bench::of(Board::StylusF405);
    bench
        .clocks()
        .set(APB1ENR, 1 | 1 << 1 | 1 << 2 | 1 << 4 | 1 << 18 | 1 << 29);
    bench
        .set(GPIOC + MODER, 0b1010 << 12)
        .set(GPIOC + AFRL, 0x22 << 24)
        .set(GPIOA + MODER, 0xA800_0000 | 3 << 8);
    bench
}

#[test]
fn the_counter_follows_the_hand_to_both_sides() {
    let mut bench = bench();
    // The hand moves one count per microsecond for a millisecond, then back.
    bench.0.encoder.hand = Box::new(|ns| 1_000 - (ns as i64 / 1000 - 4_000).abs());
    bench
        .set(TIM3 + CCMR1, 0x8181)
        .set(TIM3 + SMCR, 3)
        .set(TIM3 + ARR, 0xFFFF)
        .set(TIM3 + CR1, 1);
    let from = bench.get(TIM3 + CNT);
    bench.wait_us(500);
    assert!((499..=501).contains(&bench.get(TIM3 + CNT).wrapping_sub(from)));
    bench.wait_us(4000);
    let counter = bench.get(TIM3 + CNT);
    assert!(counter > 0xF000, "below 0 it goes on at the top: {counter}");
    bench.keeps_all();
    // The counter does not count in the wrong mode, or with one channel.
    bench.set(TIM3 + CCMR1, 0x0001);
    let before = bench.get(TIM3 + CNT);
    assert_eq!(bench.wait_us(100).get(TIM3 + CNT), before);
}

#[test]
fn the_timer_triggers_the_converter() {
    let mut bench = bench();
    bench.set(DAC, 0b111);
    bench
        .set(TIM6 + PSC, 83)
        .set(TIM6 + ARR, 99)
        .set(TIM6 + CR2, 0x20)
        .set(TIM6 + 0x14, 1)
        .set(TIM6 + SR, 0);
    bench
        .set(TIM6 + DIER, 1)
        .set(TIM6 + CR1, 1)
        .set(DAC + DHR12R1, 0x7FF);
    let begun_ns = bench.0.time.ns();
    assert_eq!(
        (bench.get(DAC + DOR1), bench.get(TIM6 + SR)),
        (0, 0),
        "held until the trigger"
    );
    bench.wait_us(100);
    assert_eq!((bench.get(DAC + DOR1), bench.get(TIM6 + SR)), (0x7FF, 1));
    bench
        .set(TIM6 + SR, 0)
        .set(DAC + DHR12R1, 0x800)
        .wait_us(100);
    let triggered = &bench.0.dac.outputs[2..];
    let codes: Vec<_> = triggered.iter().map(|output| output.code).collect();
    assert_eq!(codes, [Some(0x7FF), Some(0x800)]);
    // Outputs change three cycles of 42 MHz after their triggers, and exactly one period apart.
    let at_ns = triggered[0].at_ns - begun_ns;
    assert!((100_000..100_100).contains(&at_ns), "{at_ns}");
    assert!((triggered[1].at_ns - triggered[0].at_ns).abs_diff(100_000) <= 1);
    bench.keeps_all();
}

#[test]
fn pins_of_the_encoder_and_the_converter() {
    let mut encoder = bench();
    encoder
        .set(GPIOC + AFRL, 0x32 << 24)
        .set(TIM3 + SMCR, 3)
        .set(TIM3 + CR1, 1);
    encoder.breaks(Rule::PinFunction);
    let mut converter = bench();
    converter.set(GPIOA + MODER, 0xA800_0000).set(DAC, 0b111);
    converter.breaks(Rule::PinFunction);
}
