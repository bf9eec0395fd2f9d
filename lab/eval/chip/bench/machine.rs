//! The emulated machine: a counter of instructions, the stack, files on the PC, and ways out.

// The only place of the benchmark that may: registers, the stack's words, host calls.
#![allow(unsafe_code)]

#[path = "../../../../src/board/emulated/semihost.rs"]
// The benchmark needs some of the firmware's calls and ways to end.
#[allow(dead_code)]
pub mod semihost;

use core::hint::black_box;
use core::sync::atomic::{Ordering::SeqCst, compiler_fence};
use cortex_m_rt::{ExceptionFrame, exception};
use semihost::Exit;

/// TIM2, control register 1 (RM0090, timers 2 to 5).
const TIM2_CR1: *mut u32 = 0x4000_0000 as *mut u32;
/// TIM2, counter.
const TIM2_CNT: *const u32 = 0x4000_0024 as *const u32;
/// TIM2, value at which it starts over.
const TIM2_ARR: *mut u32 = 0x4000_002c as *mut u32;

/// Counts instructions: TIM2 at the emulator's 1 GHz, where with `-icount shift=0` an instruction
/// takes a nanosecond. Exact and repeatable up to 2^32 of them.
pub struct Counter {
    /// Instructions that measuring nothing takes.
    nothing: u32,
}

impl Counter {
    /// Starts it and measures what measuring takes.
    pub fn start() -> Self {
        // SAFETY: the emulator has a TIM2 there, without clock gating, and nobody else uses it.
        unsafe {
            TIM2_CR1.write_volatile(1);
            TIM2_ARR.write_volatile(u32::MAX);
        }
        let mut counter = Self { nothing: 0 };
        counter.nothing = counter.measure(|| ()).0;
        counter
    }

    /// Instructions of `work`, and what it gave.
    pub fn measure<R>(&self, work: impl FnOnce() -> R) -> (u32, R) {
        compiler_fence(SeqCst);
        let from = now();
        compiler_fence(SeqCst);
        let result = work();
        // All of it is done before the counter is read again.
        black_box(&result);
        compiler_fence(SeqCst);
        let to = now();
        (to.wrapping_sub(from).wrapping_sub(self.nothing), result)
    }
}

fn now() -> u32 {
    // SAFETY: as in `Counter::start`; reading has no side effect.
    unsafe { TIM2_CNT.read_volatile() }
}

/// How deep the stack gets.
pub mod stack {
    /// What the unused stack is filled with.
    const PAINT: u32 = 0xcccc_cccc;

    unsafe extern "C" {
        /// Lowest address of the stack, from `memory.x`.
        static _stack_end: u32;
    }

    /// Left alone below the stack pointer, bytes: the compiler may read the pointer before it puts
    /// this function's own registers below it.
    const OWN: u32 = 128;

    /// Fills the free stack; returns its start.
    #[inline(never)]
    pub fn paint() -> u32 {
        let from = cortex_m::register::msp::read();
        let mut word = (&raw const _stack_end).cast_mut();
        while (word as u32) < from.saturating_sub(OWN) {
            // SAFETY: from `_stack_end` to `OWN` below the stack pointer there is RAM that nobody
            // uses: this function calls none, and no interrupt is enabled.
            unsafe { word.write_volatile(PAINT) };
            word = word.wrapping_add(1);
        }
        from
    }

    /// Bytes of it that have been used since.
    #[inline(never)]
    pub fn deepest(from: u32) -> u32 {
        let mut word = &raw const _stack_end;
        // SAFETY: RAM, aligned to words, only read.
        while (word as u32) < from && unsafe { word.read_volatile() } == PAINT {
            word = word.wrapping_add(1);
        }
        from - (word as u32).min(from)
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    semihost::print(format_args!("benchmark {info}"));
    semihost::exit(Exit::Panic)
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    semihost::print(format_args!(
        "hard fault at {:#010x}, called from {:#010x}",
        frame.pc(),
        frame.lr()
    ));
    semihost::exit(Exit::Fault)
}
