//! The processor's own converter and its DMA.

use super::{AHB1ENR, APB2ENR, Bench, GPIOA, MODER};
use crate::board::Board;
use crate::findings::Rule;
use hal_mock::{Amplifier, Constant, Stm32Adc};

const SR: u32 = 0x4001_2000;
const CR1: u32 = 0x4001_2004;
const CR2: u32 = 0x4001_2008;
const SMPR2: u32 = 0x4001_2010;
const SQR1: u32 = 0x4001_202C;
const SQR3: u32 = 0x4001_2034;
const DR: u32 = 0x4001_204C;
const CCR: u32 = 0x4001_2304;
const LISR: u32 = 0x4002_6400;
const LIFCR: u32 = 0x4002_6408;
const STREAM: u32 = 0x4002_6410;
const NDTR: u32 = 0x4002_6414;
const PAR: u32 = 0x4002_6418;
const M0AR: u32 = 0x4002_641C;
const BUFFER: u32 = 0x2000_0100;

const ADON: u32 = 1;
/// DDS, DMA, CONT, ADON; with SWSTART.
const ON: u32 = 1 << 9 | 1 << 8 | 1 << 1 | ADON;
const START: u32 = ON | 1 << 30;
/// Half words to memory that counts up, over and over, both interrupts; EN.
const TO_MEMORY: u32 = 1 << 13 | 1 << 11 | 1 << 10 | 1 << 8 | 1 << 4 | 1 << 3;
const EN: u32 = 1;
const FLAGS: u32 = 0x3D;
const HALF: u32 = 1 << 4;
const COMPLETE: u32 = 1 << 5;
const OVERRUN: u32 = 1 << 5;

/// PA4 and PA5 analogue with 1 V and 2 V, a sequence of both, 8 half words in a round; the converter
/// is off.
fn bench() -> Bench {
    let mut bench = Bench::of(Board::FeatherF405Adc);
    let mut volts = [0.0; 16];
    (volts[0], volts[1]) = (2.5 + 1.0 - 1.65, 2.5 + 2.0 - 1.65);
    let scene = Constant {
        volts,
        ..Constant::default()
    };
    bench.0.sensors = Stm32Adc::new(Box::new(scene), Amplifier::Gain(1.0), 1);
    bench.clocks();
    bench
        .set(AHB1ENR, 7 | 1 << 22)
        .set(APB2ENR, 1 << 8)
        .set(GPIOA + MODER, 0xA800_0F00);
    bench
        .set(CCR, 1 << 16)
        .set(CR1, 1 << 8)
        .set(SMPR2, 0o33 << 12)
        .set(SQR1, 1 << 20)
        .set(SQR3, 4 | 5 << 5);
    bench.set(PAR, DR).set(M0AR, BUFFER).set(NDTR, 8);
    bench
}

/// As above, and it converts.
fn converting() -> Bench {
    let mut bench = bench();
    bench
        .set(STREAM, TO_MEMORY | EN)
        .set(CR2, ON)
        .wait_us(4)
        .set(CR2, START);
    bench
}

#[test]
fn samples_come_into_memory_at_their_times() {
    let mut bench = converting();
    // 68 periods of 21 MHz each, 3.24 us: four after 12.95, eight after 25.9.
    assert_eq!(bench.wait_us(12).get(LISR) & FLAGS, 0);
    assert_eq!(bench.wait_us(1).get(LISR) & FLAGS, HALF);
    assert_eq!(bench.wait_us(13).get(LISR) & FLAGS, HALF | COMPLETE);
    for (place, volts) in [1.0, 2.0, 1.0, 2.0].into_iter().enumerate() {
        let sample = f64::from(bench.get(BUFFER + 2 * place as u32) & 0xFFFF);
        assert!(
            (sample - volts / 3.3 * 4096.0).abs() < 6.0,
            "{place}: {sample}"
        );
    }
    bench.set(LIFCR, FLAGS);
    assert_eq!(bench.wait_us(26).get(LISR) & FLAGS, HALF | COMPLETE);
    assert_eq!(bench.get(SR) & OVERRUN, 0);
    bench.keeps_all();
}

#[test]
fn pins_and_clocks_that_do_not_fit() {
    let mut digital = bench();
    digital
        .set(GPIOA + MODER, 0xA800_0300)
        .set(CR2, ON)
        .wait_us(4)
        .set(CR2, START);
    digital.breaks(Rule::PinFunction);
    // 42 MHz.
    let mut fast = bench();
    fast.set(CCR, 0).set(CR2, ON).wait_us(4).set(CR2, START);
    fast.breaks(Rule::ClockLimit);
    let mut off = Bench::of(Board::FeatherF405Adc);
    off.get(SR);
    off.breaks(Rule::ClockOn);
}

#[test]
pub(super) fn a_converter_that_is_hurried() {
    let mut early = bench();
    early
        .set(STREAM, TO_MEMORY | EN)
        .set(CR2, ON)
        .wait_us(1)
        .set(CR2, START);
    early.breaks(Rule::AdcSettling);
    for (register, value) in [(SQR3, 0), (SQR1, 0), (SMPR2, 0), (CCR, 0)] {
        let mut bench = converting();
        bench.wait_us(10).set(register, value);
        bench.breaks(Rule::AdcSequence);
        let mut again = converting();
        again.wait_us(10).set(CR2, 0).set(register, value);
        again.keeps_all();
    }
}

#[test]
pub(super) fn samples_that_nobody_fetches() {
    let mut bench = converting();
    // The stream stops: the second conversion from then on finds the first one there.
    bench.wait_us(5).set(STREAM, TO_MEMORY).wait_us(10);
    bench.breaks(Rule::AdcOverrun);
    assert_eq!(bench.get(SR) & OVERRUN, OVERRUN);
    // It stays so until the converter is set up again.
    bench.set(CR2, START).wait_us(10);
    assert_eq!(bench.get(SR) & OVERRUN, OVERRUN);
    // Without DDS there are no requests after a round.
    let mut once = bench_without_dds();
    once.wait_us(40);
    once.breaks(Rule::AdcOverrun);
}

fn bench_without_dds() -> Bench {
    let mut bench = bench();
    bench
        .set(STREAM, TO_MEMORY | EN)
        .set(CR2, ON & !(1 << 9))
        .wait_us(4)
        .set(CR2, START & !(1 << 9));
    bench
}

#[test]
pub(super) fn a_stream_that_is_set_while_it_runs() {
    for (register, value) in [
        (NDTR, 16),
        (M0AR, BUFFER + 64),
        (PAR, SR),
        (STREAM, TO_MEMORY & !(1 << 8) | EN),
    ] {
        let mut bench = converting();
        bench.set(register, value);
        bench.breaks(Rule::DmaEnabled);
    }
    // Interrupts may change.
    let mut bench = converting();
    bench.set(STREAM, TO_MEMORY & !(1 << 4) | EN);
    bench.keeps_all();
    // Switched off, it must be seen to have stopped.
    for sees in [false, true] {
        let mut bench = converting();
        bench.set(CR2, 0).set(STREAM, TO_MEMORY).wait_us(1);
        if sees {
            assert_eq!(bench.get(STREAM) & EN, 0);
        }
        bench
            .set(LIFCR, FLAGS)
            .set(NDTR, 8)
            .set(STREAM, TO_MEMORY | EN);
        if sees {
            bench.keeps_all()
        } else {
            bench.breaks(Rule::DmaStop)
        }
    }
}

#[test]
pub(super) fn a_stream_that_starts_with_old_flags() {
    let mut bench = converting();
    bench
        .wait_us(30)
        .set(CR2, 0)
        .set(STREAM, TO_MEMORY)
        .wait_us(1);
    assert_eq!(bench.get(STREAM) & EN, 0);
    bench.set(NDTR, 8).set(STREAM, TO_MEMORY | EN);
    bench.breaks(Rule::DmaFlags);
}

#[test]
pub(super) fn a_stream_that_does_not_fit_the_converter() {
    // To the peripheral; bytes; words; without counting; another channel.
    for wrong in [1 << 6, 1 << 11, 1 << 12, 1 << 10, 1 << 25] {
        let mut bench = bench();
        bench.set(STREAM, (TO_MEMORY | EN) ^ wrong);
        bench.breaks(Rule::DmaSetting);
    }
    // Another register; CCM; an odd place; a half that is no whole scan; none.
    for (register, value) in [
        (PAR, SR),
        (M0AR, 0x1000_0000),
        (M0AR, BUFFER + 1),
        (NDTR, 6),
        (NDTR, 0),
    ] {
        let mut bench = bench();
        bench.set(register, value).set(STREAM, TO_MEMORY | EN);
        bench.breaks(Rule::DmaSetting);
    }
}
