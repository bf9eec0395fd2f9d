//! The end of a run: its record goes into RAM that start-up does not clear.

use super::clock::now_us;
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
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
        // SAFETY: within RAM. A word may hold anything; read and written once, it is something to
        // the compiler too.
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
    let (file, line) = info
        .location()
        .map_or(("", 0), |place| (place.file(), place.line()));
    Record::of_panic(now_us(), file, line)
}
