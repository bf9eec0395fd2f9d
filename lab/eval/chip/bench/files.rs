//! Jobs in, measurements out: what the benchmarks' images have in common.

use crate::machine::semihost::{self, Exit, File};
use ridgetone_eval::workload::{self, Measured, RECORD_MAX};
use serde::de::DeserializeOwned;

/// The two files of a benchmark.
pub struct Files {
    workload: File,
    results: File,
}

impl Files {
    /// Opens them, does `work` and leaves the emulator.
    pub fn run(work: impl FnOnce(&Self) -> Option<()>) -> ! {
        let (Some(workload), Some(results)) = (
            File::open(c"workload", semihost::Mode::Read),
            File::open(c"results", semihost::Mode::Write),
        ) else {
            semihost::print(format_args!("cannot open workload and results"));
            semihost::exit(Exit::Bridge)
        };
        match work(&Self { workload, results }) {
            Some(()) => semihost::exit(Exit::Done),
            None => {
                semihost::print(format_args!(
                    "the workload is not whole, or results cannot be written"
                ));
                semihost::exit(Exit::Bridge)
            }
        }
    }

    /// The next record of the workload.
    pub fn read<T: DeserializeOwned>(&self) -> Option<T> {
        workload::read(|bytes| self.workload.read_exact(bytes))
    }

    /// Adds a record to the results.
    pub fn write(&self, measured: Measured) -> Option<()> {
        self.results
            .write_all(workload::write(&measured, &mut [0; RECORD_MAX])?)
            .then_some(())
    }
}
