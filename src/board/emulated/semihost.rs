//! The emulator's host calls: files, messages, the end of the run.
//!
//! The calls and their argument blocks: Arm, "Semihosting for AArch32 and AArch64", 2.0.

use core::fmt::Write;
use cortex_m_semihosting::{nr, syscall};

/// SYS_EXIT_EXTENDED: unlike SYS_EXIT it carries a status on a 32-bit core too.
const EXIT_EXTENDED: usize = 0x20;

/// Code for `ADP_Stopped_ApplicationExit`.
const APPLICATION_EXIT: usize = 0x2_0026;

/// `fopen` mode "rb" in SYS_OPEN's numbering.
const READ_BINARY: usize = 1;

/// `fopen` mode "wb" in SYS_OPEN's numbering.
const WRITE_BINARY: usize = 5;

/// `fopen` mode "a" in SYS_OPEN's numbering; of the console it is standard error.
const APPEND: usize = 8;

/// The console's name.
const CONSOLE: &core::ffi::CStr = c":tt";

/// How a run ends, as the emulator's exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// A file on the host.
#[derive(Clone, Copy, Debug)]
pub struct File(usize);

impl File {
    /// Opens for reading.
    pub fn read_from(path: &'static core::ffi::CStr) -> Option<Self> {
        Self::open(path, READ_BINARY)
    }

    /// Opens for writing.
    pub fn write_to(path: &'static core::ffi::CStr) -> Option<Self> {
        Self::open(path, WRITE_BINARY)
    }

    /// Its number on the host, which a reset of the processor does not change.
    pub const fn handle(self) -> u32 {
        self.0 as u32
    }

    /// An open file by its number.
    pub const fn of(handle: u32) -> Self {
        Self(handle as usize)
    }

    fn open(path: &'static core::ffi::CStr, mode: usize) -> Option<Self> {
        let block = [path.as_ptr() as usize, mode, path.to_bytes().len()];
        // SAFETY: SYS_OPEN reads a block of three words and the string, both alive during the call.
        let handle = unsafe { syscall(nr::OPEN, &block) };
        (handle != usize::MAX).then_some(Self(handle))
    }

    /// Writes all of `bytes`; false if that failed.
    pub fn write_all(self, bytes: &[u8]) -> bool {
        let block = [self.0, bytes.as_ptr() as usize, bytes.len()];
        // SAFETY: SYS_WRITE reads a block of three words and `bytes`, both alive during the call.
        let left = unsafe { syscall(nr::WRITE, &block) };
        left == 0
    }

    /// Fills `bytes`; false at the end of the file or on failure. A pipe may give less at a time.
    pub fn read_exact(self, bytes: &mut [u8]) -> bool {
        let mut rest = bytes;
        while !rest.is_empty() {
            let block = [self.0, rest.as_mut_ptr() as usize, rest.len()];
            // SAFETY: SYS_READ reads a block of three words and writes into `rest`, which is ours alone
            // and as long as given.
            let left = unsafe { syscall(nr::READ, &block) };
            let Some(read) = rest.len().checked_sub(left).filter(|read| *read > 0) else { return false };
            rest = rest.get_mut(read..).unwrap_or_default();
        }
        true
    }
}

/// Prints one line of at most 160 bytes on the emulator's standard error. There is no second try: without a reader it would
/// never end.
pub fn print(message: core::fmt::Arguments) {
    let mut line = heapless::String::<160>::new();
    let _ = line.write_fmt(message);
    let _ = line.push('\n');
    if let Some(stderr) = File::open(CONSOLE, APPEND) {
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
