//! The end of a run: its record goes into RAM that start-up does not clear.

use super::{now_us, stack};
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use cortex_m_rt::ExceptionFrame;
use ridgetone_proto::boot::Record;
use ridgetone_proto::crash::{STORED_WORDS, Stored};

/// Only start-up, before tasks run, and a crash, after they run, use it.
struct Ram(UnsafeCell<MaybeUninit<Stored>>);

// SAFETY: see above; there is one core.
unsafe impl Sync for Ram {}

// Not cleared by start-up (cortex-m-rt, link.x).
#[unsafe(link_section = ".uninit.crash")]
static RAM: Ram = Ram(UnsafeCell::new(MaybeUninit::uninit()));

/// The RAM, with any content.
fn ram() -> &'static mut Stored {
    let first = RAM.0.get().cast::<u32>();
    for at in 0..STORED_WORDS {
        // SAFETY: within RAM. A word may hold anything; read and written once, it is something to the compiler too.
        unsafe {
            let word = first.add(at);
            word.write_volatile(word.read_volatile());
        }
    }
    // SAFETY: all words are initialized, and nobody else has a reference: see `Ram`.
    unsafe { (*RAM.0.get()).assume_init_mut() }
}

/// The record of the run before, if it crashed. To be called once, before tasks run.
pub fn take_record() -> Option<Record> {
    Record::take(ram())
}

/// Keeps a record over the reset that must follow, and masks interrupts for good.
pub fn keep(record: &Record) {
    cortex_m::interrupt::disable();
    record.store(ram());
}

/// The record of a panic.
pub fn record_of(info: &core::panic::PanicInfo) -> Record {
    let (file, line) = info.location().map_or(("", 0), |place| (place.file(), place.line()));
    Record::of_panic(now_us(), file, line)
}

/// Entry of a HardFault. If less than 1 KiB of the stack is left, the handler starts at its top: it overwrites the
/// processor's frame only if that is near the top, which a full stack's frame is not.
#[unsafe(naked)]
#[unsafe(export_name = "HardFault")]
unsafe extern "C" fn enter_hard_fault() -> ! {
    core::arch::naked_asm!(
        "mrs r0, msp",
        "movw r1, #:lower16:_stack_end",
        "movt r1, #:upper16:_stack_end",
        "add r1, r1, #1024",
        "cmp r0, r1",
        "bhs 2f",
        "movw r1, #:lower16:_stack_start",
        "movt r1, #:upper16:_stack_start",
        "msr msp, r1",
        // No lazy stacking of the FPU's registers: without memory it would be a second fault (Armv7-M, FPCCR.LSPACT).
        "2:",
        "movw r2, #0xef34",
        "movt r2, #0xe000",
        "ldr r3, [r2]",
        "bic r3, r3, #1",
        "str r3, [r2]",
        "b {handle}",
        handle = sym handle_hard_fault,
    )
}

/// `frame`: where the processor has put its registers, or would have if the stack had not overflowed.
unsafe extern "C" fn handle_hard_fault(frame: *const ExceptionFrame) -> ! {
    let (pc, lr) = if stack::holds(frame) {
        // SAFETY: it lies in the stack, where the processor has put it; nothing has been put over it.
        unsafe { ((*frame).pc(), (*frame).lr()) }
    } else {
        (0, 0)
    };
    super::die(&Record::of_hard_fault(now_us(), pc, lr))
}
