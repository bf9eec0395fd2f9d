//! The emulated board's defmt log: frames into the FIFO `defmt.log` in the emulator's working directory. Its other end reads
//! it all the time, so that nothing waits. A call to the host takes no time of the emulated board.

use super::semihost::File;
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use critical_section::RestoreState;

/// No file: what is logged is dropped.
const NONE: u32 = u32::MAX;

/// The FIFO, once it is open.
static FILE: AtomicU32 = AtomicU32::new(NONE);

/// The state of a frame that is not complete.
struct Frame {
    encoder: UnsafeCell<defmt::Encoder>,
    interrupts: UnsafeCell<RestoreState>,
}

// SAFETY: only the holder of the logger uses it, with interrupts masked.
unsafe impl Sync for Frame {}

static FRAME: Frame =
    Frame { encoder: UnsafeCell::new(defmt::Encoder::new()), interrupts: UnsafeCell::new(RestoreState::invalid()) };

/// Opens the FIFO, if a reset has not kept it.
pub fn open(kept: Option<File>) {
    FILE.store(kept.or_else(|| File::write_to(c"defmt.log")).map_or(NONE, File::handle), Relaxed);
}

/// The FIFO, for a reset to keep.
pub fn file() -> File {
    File::of(FILE.load(Relaxed))
}

fn put(bytes: &[u8]) {
    if FILE.load(Relaxed) != NONE {
        // A log that is lost cannot be reported.
        let _ = file().write_all(bytes);
    }
}

#[defmt::global_logger]
struct Log;

// SAFETY: interrupts are masked from `acquire` to `release`, and nothing that is logged logs, so there is one frame at a
// time.
unsafe impl defmt::Logger for Log {
    fn acquire() {
        // SAFETY: `release` restores it; see above for the two cells.
        unsafe {
            let interrupts = critical_section::acquire();
            *FRAME.interrupts.get() = interrupts;
            (*FRAME.encoder.get()).start_frame(put);
        }
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: the caller has the logger.
        unsafe {
            (*FRAME.encoder.get()).end_frame(put);
            critical_section::release(*FRAME.interrupts.get());
        }
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: the caller has the logger.
        unsafe { (*FRAME.encoder.get()).write(bytes, put) };
    }
}
