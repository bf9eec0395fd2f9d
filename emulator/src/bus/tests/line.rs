use super::{AHB1ENR, Bench, USART3};

pub(super) const STREAM: u32 = 0x4002_6000 + 0x10 + 0x18;
pub(super) const NDTR: u32 = STREAM + 0x04;
pub(super) const PAR: u32 = STREAM + 0x08;
pub(super) const M0AR: u32 = STREAM + 0x0C;
const LISR: u32 = 0x4002_6000;
const LIFCR: u32 = 0x4002_6008;
/// Flags of stream 1: half transfer, and transfer complete.
const HALF: u32 = 1 << 10;
const COMPLETE: u32 = 1 << 11;
pub(super) const BUFFER: u32 = 0x2000_0100;
/// CR bits: channel 4, bytes to memory, increment, circular, both interrupts, EN.
pub(super) const ON: u32 = 4 << 25 | 1 << 10 | 1 << 8 | 1 << 4 | 1 << 3 | 1;
const SR: u32 = USART3;
const DR: u32 = USART3 + 0x04;
const IDLE: u32 = 1 << 4;
/// Duration of a byte, processor cycles: ten bits of 46 APB1 cycles.
const BYTE: u64 = 1840;

/// Creates a line whose DMA stream is set up for a circular buffer of 16 bytes, but off.
pub(super) fn bench() -> Bench {
    let mut bench = Bench::ready();
    bench
        .set(AHB1ENR, 7 | 1 << 21)
        .set(USART3 + 0x14, 1 << 6)
        .set(PAR, DR)
        .set(M0AR, BUFFER)
        .set(NDTR, 16);
    bench
}

/// Creates a line whose DMA fetches the bytes that arrive.
pub(super) fn receiving() -> Bench {
    let mut bench = bench();
    bench.set(STREAM, ON);
    bench
}

/// Schedules bytes that end these numbers of cycles from now.
pub(super) fn arrive(bench: &mut Bench, ends: impl IntoIterator<Item = u64>) {
    let now = bench.0.time.cycles;
    for (byte, end) in (b'a'..).zip(ends) {
        bench.0.usart.arrive(byte, now + end);
    }
}

fn wait(bench: &mut Bench, cycles: u64) {
    bench.0.time.cycles += cycles;
    bench.0.catch_up();
}

#[test]
fn bytes_come_into_memory_while_the_processor_stands_still() {
    let mut bench = receiving();
    arrive(&mut bench, (1..=20).map(|byte| BYTE * byte));
    let begun = bench.0.time.cycles;
    for (bytes, flags) in [(7, 0), (8, HALF), (15, HALF), (16, HALF | COMPLETE)] {
        bench.0.time.cycles = begun + BYTE * bytes + 20;
        bench.0.catch_up();
        assert_eq!(bench.get(LISR), flags, "{bytes} bytes");
    }
    bench.set(LIFCR, HALF | COMPLETE);
    wait(&mut bench, 10 * BYTE);
    assert_eq!((bench.get(NDTR), bench.get(LISR)), (12, 0));
    let memory: Vec<u8> = (0..16).map(|at| bench.get(BUFFER + at) as u8).collect();
    assert_eq!(memory, *b"qrstefghijklmnop");
    assert_eq!((bench.0.usart.overruns, bench.0.usart.taken), (0, 20));
    bench.keeps_all();
}

/// Tests that the idle flag is set once, a byte's duration after the last byte ended, or later if a
/// further byte has begun by then.
#[test]
fn the_line_becomes_idle_after_the_last_byte() {
    let mut bench = receiving();
    // The second byte begins before the line is idle, the third after that, and the fourth as the
    // third ends.
    arrive(
        &mut bench,
        [BYTE, 2 * BYTE + 1000, 4 * BYTE + 2000, 5 * BYTE + 2000],
    );
    for (cycles, is_idle) in [(2 * BYTE + 1500, false), (BYTE - 200, true)] {
        wait(&mut bench, cycles);
        assert_eq!(bench.get(SR) & IDLE != 0, is_idle);
    }
    // Reading SR, then DR, clears the flag.
    assert_eq!(bench.get(SR) & IDLE, IDLE);
    bench.get(DR);
    assert_eq!(bench.get(SR) & IDLE, 0);
    for (cycles, is_idle) in [(2 * BYTE, false), (2 * BYTE, true)] {
        wait(&mut bench, cycles);
        assert_eq!(bench.get(SR) & IDLE != 0, is_idle);
    }
    bench.get(DR);
    wait(&mut bench, 10 * BYTE);
    assert_eq!(bench.get(SR) & IDLE, 0, "not again without a byte");
    bench.keeps_all();
}
