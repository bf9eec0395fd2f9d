use super::{AHB1ENR, APB2ENR, Bench, GPIOA, MODER};
use crate::board::Board;
use hal_mock::{Amplifier, Constant, Stm32Adc};

pub(super) const SR: u32 = 0x4001_2000;
const CR1: u32 = 0x4001_2004;
pub(super) const CR2: u32 = 0x4001_2008;
pub(super) const SMPR2: u32 = 0x4001_2010;
pub(super) const SQR1: u32 = 0x4001_202C;
pub(super) const SQR3: u32 = 0x4001_2034;
const DR: u32 = 0x4001_204C;
pub(super) const CCR: u32 = 0x4001_2304;
const LISR: u32 = 0x4002_6400;
pub(super) const LIFCR: u32 = 0x4002_6408;
pub(super) const STREAM: u32 = 0x4002_6410;
pub(super) const NDTR: u32 = 0x4002_6414;
pub(super) const PAR: u32 = 0x4002_6418;
pub(super) const M0AR: u32 = 0x4002_641C;
pub(super) const BUFFER: u32 = 0x2000_0100;

const ADON: u32 = 1;
/// CR2 bits: DDS, DMA, CONT, ADON; `START` adds SWSTART.
pub(super) const ON: u32 = 1 << 9 | 1 << 8 | 1 << 1 | ADON;
pub(super) const START: u32 = ON | 1 << 30;
/// CR bits: half words to memory, increment, circular, both interrupts.
pub(super) const TO_MEMORY: u32 = 1 << 13 | 1 << 11 | 1 << 10 | 1 << 8 | 1 << 4 | 1 << 3;
pub(super) const EN: u32 = 1;
pub(super) const FLAGS: u32 = 0x3D;
const HALF: u32 = 1 << 4;
const COMPLETE: u32 = 1 << 5;
pub(super) const OVERRUN: u32 = 1 << 5;

/// Creates a board with 1 V at PA4 and 2 V at PA5, both analogue and in the sequence, a circular
/// buffer of 8 half words, and the ADC off.
pub(super) fn bench() -> Bench {
    let mut bench = Bench::of(Board::FeatherF405Adc);
    bench.clocks();
    configure(&mut bench);
    bench
}

/// Sets up the same inputs on any board. Does not change the processor's clocks.
pub(super) fn configure(bench: &mut Bench) {
    let mut volts = [0.0; 16];
    (volts[0], volts[1]) = (2.5 + 1.0 - 1.65, 2.5 + 2.0 - 1.65);
    let scene = Constant {
        volts,
        ..Constant::default()
    };
    bench.0.sensors = Stm32Adc::new(Box::new(scene), Amplifier::Gain(1.0), 1);
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
}

pub(super) fn converting() -> Bench {
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
    // A conversion takes 68 periods of 21 MHz, 3.24 us: four take 12.95 us, eight 25.9 us.
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
