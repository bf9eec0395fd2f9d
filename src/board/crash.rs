//! Storage of a crash record in RAM that start-up does not clear.

use super::clock::now_us;
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use ridgetone_proto::boot::Record;
use ridgetone_proto::crash::{STORED_WORDS, Stored};

/// RAM of the record. Only start-up, before tasks run, and a crash, after they ran, access it.
struct Ram(UnsafeCell<MaybeUninit<Stored>>);

// SAFETY: start-up and a crash never overlap, and there is one core.
unsafe impl Sync for Ram {}

// Not cleared by start-up (cortex-m-rt, link.x).
#[unsafe(link_section = ".uninit.crash")]
static RAM: Ram = Ram(UnsafeCell::new(MaybeUninit::uninit()));

/// Copies the RAM, which may hold any value. No reference to the RAM is ever created, so a panic
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

/// Stores a record for the next run, and masks interrupts for good. The caller must reset.
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
