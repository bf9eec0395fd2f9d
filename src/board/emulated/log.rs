//! The emulated board's defmt log: frames into the FIFO `defmt.log` in the emulator's working
//! directory. Its other end reads it all the time, so that nothing waits. A call to the host takes
//! no time of the emulated board.

use super::kept::KEPT;
use super::semihost::{File, Mode};
use core::cell::UnsafeCell;
use core::sync::atomic::Ordering::Relaxed;
use critical_section::RestoreState;

/// The state of a frame that is not complete.
struct Frame {
    encoder: UnsafeCell<defmt::Encoder>,
    interrupts: UnsafeCell<RestoreState>,
}

// SAFETY: only the holder of the logger uses it, with interrupts masked.
unsafe impl Sync for Frame {}

static FRAME: Frame = Frame {
    encoder: UnsafeCell::new(defmt::Encoder::new()),
    interrupts: UnsafeCell::new(RestoreState::invalid()),
};

/// Opens the FIFO. Without it what is logged is dropped.
pub fn open() {
    KEPT.log.store(
        File::open(c"defmt.log", Mode::Write).map_or(0, |file| file.0),
        Relaxed,
    );
}

fn put(bytes: &[u8]) {
    let handle = KEPT.log.load(Relaxed);
    if handle != 0 {
        // A log that is lost cannot be reported.
        let _ = File(handle).write_all(bytes);
    }
}

#[defmt::global_logger]
struct Log;

// SAFETY: interrupts are masked from `acquire` to `release`, and nothing that is logged logs, so
// there is one frame at a time.
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
