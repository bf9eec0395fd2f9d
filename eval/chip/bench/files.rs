//! Jobs in, measurements out: what the benchmarks' images have in common.

use crate::machine::semihost;
use crate::machine::semihost::{Exit, File};
use core::fmt::Write;
use ridgetone_eval::workload::{FRAME_BYTES, LINE_MAX, Measured, decode_frame};
use ridgetone_tone::Values;

/// The two files of a benchmark.
pub struct Files {
    workload: File,
    results: File,
}

impl Files {
    /// Opens them, does `work` and leaves the emulator.
    pub fn run(work: impl FnOnce(&Self) -> Option<()>) -> ! {
        let (Some(workload), Some(results)) =
            (File::open(c"workload", semihost::Mode::Read), File::open(c"results", semihost::Mode::Write))
        else {
            semihost::print(format_args!("cannot open workload and results"));
            semihost::exit(Exit::Bridge)
        };
        match work(&Self { workload, results }) {
            Some(()) => semihost::exit(Exit::Done),
            None => {
                semihost::print(format_args!("the workload is not whole, or results cannot be written"));
                semihost::exit(Exit::Bridge)
            }
        }
    }

    /// The next bytes of the workload.
    pub fn read<const N: usize>(&self) -> Option<[u8; N]> {
        let mut bytes = [0; N];
        self.workload.read_exact(&mut bytes).then_some(bytes)
    }

    /// The next frame of the workload: its values and the mask of valid taxels.
    pub fn frame(&self) -> Option<(Values, u16)> {
        Some(decode_frame(&self.read::<FRAME_BYTES>()?))
    }

    /// Writes a result.
    pub fn write(&self, measured: Measured) -> Option<()> {
        let mut line = heapless::String::<LINE_MAX>::new();
        writeln!(line, "{measured}").ok()?;
        self.results.write_all(line.as_bytes()).then_some(())
    }
}
