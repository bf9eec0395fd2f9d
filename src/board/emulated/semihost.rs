//! The emulator's host calls: files, messages, the end of the run.
//!
//! The calls and their argument blocks: Arm, "Semihosting for AArch32 and AArch64", 2.0.

use core::fmt::Write;
use cortex_m_semihosting::{nr, syscall};

/// SYS_EXIT_EXTENDED: unlike SYS_EXIT it carries a status on a 32-bit core too.
const EXIT_EXTENDED: usize = 0x20;

/// Code for `ADP_Stopped_ApplicationExit`.
const APPLICATION_EXIT: usize = 0x2_0026;

/// A file's mode, in SYS_OPEN's numbering of those of `fopen`.
#[repr(usize)]
pub enum Mode {
    /// "rb".
    Read = 1,
    /// "wb".
    Write = 5,
    /// "a"; of the console it is standard error.
    Append = 8,
}

/// How a run ends, as the emulator's exit status.
#[repr(usize)]
pub enum Exit {
    /// The scene has ended and all telemetry is out.
    Done = 0,
    /// A file of the bridge could not be opened, or its other end closed it or sent invalid data.
    Bridge = 2,
    /// The processor faulted.
    Fault = 3,
    /// A task hung until the watchdog acted.
    Watchdog = 4,
    /// The firmware panicked; a Rust program's usual status.
    Panic = 101,
}

/// A file on the host, by its handle, which a reset of the processor does not change.
#[derive(Clone, Copy)]
pub struct File(pub u32);

impl File {
    pub fn open(path: &'static core::ffi::CStr, mode: Mode) -> Option<Self> {
        let block = [path.as_ptr() as usize, mode as usize, path.to_bytes().len()];
        // SAFETY: SYS_OPEN reads a block of three words and the string, both alive during the call.
        let handle = unsafe { syscall(nr::OPEN, &block) };
        (handle != usize::MAX).then_some(Self(handle as u32))
    }

    /// Writes all of `bytes`; false if that failed.
    pub fn write_all(self, bytes: &[u8]) -> bool {
        let block = [self.0 as usize, bytes.as_ptr() as usize, bytes.len()];
        // SAFETY: SYS_WRITE reads a block of three words and `bytes`, both alive during the call.
        let left = unsafe { syscall(nr::WRITE, &block) };
        left == 0
    }

    /// Fills `bytes`; false at the end of the file or on failure. A pipe may give less at a time.
    pub fn read_exact(self, bytes: &mut [u8]) -> bool {
        let mut rest = bytes;
        while !rest.is_empty() {
            let block = [self.0 as usize, rest.as_mut_ptr() as usize, rest.len()];
            // SAFETY: SYS_READ reads a block of three words and writes into `rest`, which is ours
            // and as long as given.
            let left = unsafe { syscall(nr::READ, &block) };
            let Some(read) = rest.len().checked_sub(left).filter(|read| *read > 0) else {
                return false;
            };
            rest = rest.get_mut(read..).unwrap_or_default();
        }
        true
    }
}

/// Prints one line of at most 160 bytes on the emulator's standard error, in one try: a second one
/// might never end.
pub fn print(message: core::fmt::Arguments) {
    let mut line = heapless::String::<160>::new();
    let _ = line.write_fmt(message);
    let _ = line.push('\n');
    if let Some(stderr) = File::open(c":tt", Mode::Append) {
        stderr.write_all(line.as_bytes());
    }
}

/// Ends the emulator with an exit status.
pub fn exit(status: Exit) -> ! {
    let block = [APPLICATION_EXIT, status as usize];
    loop {
        // SAFETY: SYS_EXIT_EXTENDED reads a block of two words, alive during the call.
        unsafe { syscall(EXIT_EXTENDED, &block) };
    }
}
