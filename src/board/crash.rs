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

/// A copy of the RAM, which may hold anything. No reference to it ever exists: a panic while
/// another copy is in use cannot alias it.
fn read() -> Stored {
    let first = RAM.0.get().cast::<u32>();
    // SAFETY: within RAM; a volatile read takes whatever a word holds as a value.
    core::array::from_fn(|at| unsafe { first.add(at).read_volatile() })
}

fn write(stored: &Stored) {
    let first = RAM.0.get().cast::<u32>();
    for (at, word) in stored.iter().enumerate() {
        // SAFETY: within RAM, which has as many words as `stored`.
        unsafe { first.add(at).write_volatile(*word) };
    }
}

/// The record of the run before, if it crashed. To be called once, before tasks run.
pub fn take_record() -> Option<Record> {
    let mut stored = read();
    let record = Record::take(&mut stored);
    write(&stored);
    record
}

/// Keeps a record over the reset that must follow, and masks interrupts for good.
pub fn keep(record: &Record) {
    cortex_m::interrupt::disable();
    let mut stored = [0; STORED_WORDS];
    record.store(&mut stored);
    write(&stored);
}

/// The record of a panic.
pub fn record_of(info: &core::panic::PanicInfo) -> Record {
    let (file, line) = info
        .location()
        .map_or(("", 0), |place| (place.file(), place.line()));
    Record::of_panic(now_us(), file, line)
}
