//! The end of a run: stores its record in RAM that start-up does not clear.

use super::clock::now_us;
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use ridgetone_proto::boot::Record;
use ridgetone_proto::crash::{STORED_WORDS, Stored};

/// RAM of the record. Used only by start-up, before tasks run, and by a crash, after they run.
struct Ram(UnsafeCell<MaybeUninit<Stored>>);

// SAFETY: start-up and a crash never overlap, and there is one core.
unsafe impl Sync for Ram {}

// Not cleared by start-up (cortex-m-rt, link.x).
#[unsafe(link_section = ".uninit.crash")]
static RAM: Ram = Ram(UnsafeCell::new(MaybeUninit::uninit()));

/// Copies the RAM, which may hold anything. No reference to the RAM is ever created, so a panic
/// during another copy cannot alias it.
fn read() -> Stored {
    let first = RAM.0.get().cast::<u32>();
    // SAFETY: within RAM; a volatile read accepts any value of a word.
    core::array::from_fn(|at| unsafe { first.add(at).read_volatile() })
}

fn write(stored: &Stored) {
    let first = RAM.0.get().cast::<u32>();
    for (at, word) in stored.iter().enumerate() {
        // SAFETY: within RAM, which has the same number of words as `stored`.
        unsafe { first.add(at).write_volatile(*word) };
    }
}

/// Takes the record of the previous run, if it crashed. Call this once, before tasks run.
pub fn take_record() -> Option<Record> {
    let mut stored = read();
    let record = Record::take(&mut stored);
    write(&stored);
    record
}

/// Keeps a record across the reset that must follow, and masks interrupts for good.
pub fn keep(record: &Record) {
    cortex_m::interrupt::disable();
    let mut stored = [0; STORED_WORDS];
    record.store(&mut stored);
    write(&stored);
}

pub fn record_of(info: &core::panic::PanicInfo) -> Record {
    let (file, line) = info
        .location()
        .map_or(("", 0), |place| (place.file(), place.line()));
    Record::of_panic(now_us(), file, line)
}
