//! The benchmark's image in the emulator: jobs in, measurements out.

use crate::workload::{Job, Measured, RECORD_MAX, read, write};
use anyhow::{Context, Result, bail, ensure};
use ridgetone_host::emulator::process::{QEMU, qemu};
use serde::Serialize;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Clock of the STM32F405, hertz.
pub const CLOCK_HZ: f64 = 168e6;

/// The whole benchmark takes seconds: after this time the emulator hangs.
const TIMEOUT: Duration = Duration::from_secs(600);

/// Interval of the checks whether it has ended.
const CHECK_EVERY: Duration = Duration::from_millis(20);

/// A file of jobs in the making.
#[derive(Clone, Debug, Default)]
pub struct Jobs(Vec<u8>);

impl Jobs {
    /// A job and its items, which are counted in it.
    pub fn add<T: Serialize>(&mut self, job: Job, items: impl IntoIterator<Item = T>) {
        self.record(&job);
        items.into_iter().for_each(|item| self.record(&item));
    }

    fn record(&mut self, item: &impl Serialize) {
        self.0
            .extend(write(item, &mut [0; RECORD_MAX]).unwrap_or_default());
    }

    /// Has an image do all jobs, in a directory that is gone afterwards.
    pub fn run(mut self, elf: &Path) -> Result<Vec<Measured>> {
        let elf = elf
            .canonicalize()
            .with_context(|| elf.display().to_string())?;
        self.record(&Job::End);
        let directory = tempfile::Builder::new()
            .prefix("ridgetone-")
            .tempdir()
            .context("a temporary directory")?;
        fs::write(directory.path().join("workload"), &self.0).context("the workload")?;
        // One instruction a nanosecond: the timers, which run at 1 GHz here, count instructions.
        let mut child = qemu(&elf, directory.path(), "shift=0", &["null"], Stdio::null)?;
        let began = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().context(QEMU)? {
                break status;
            }
            if began.elapsed() > TIMEOUT {
                // Fails only if it has ended by itself meanwhile.
                let _ = child.kill();
                let _ = child.wait();
                bail!("the benchmark still runs after {} s", TIMEOUT.as_secs());
            }
            std::thread::sleep(CHECK_EVERY);
        };
        let mut words = String::new();
        if let Some(mut stderr) = child.stderr.take() {
            stderr.read_to_string(&mut words).context(QEMU)?;
        }
        ensure!(
            status.success(),
            "the benchmark ended with {status}: {}",
            words.trim()
        );
        let results =
            fs::read(directory.path().join("results")).context("the benchmark's results")?;
        let (mut rest, mut measured) = (&results[..], Vec::new());
        while !rest.is_empty() {
            measured.push(
                read(|bytes| rest.read_exact(bytes).is_ok())
                    .context("the benchmark's results are damaged")?,
            );
        }
        Ok(measured)
    }
}

/// The fields of the next measurement, which must be of this kind.
macro_rules! next {
    ($measured:expr, $kind:ident { $($field:ident),* }) => {
        match $measured.next() {
            Some($crate::workload::Measured::$kind { $($field),* }) => ($($field),*),
            other => anyhow::bail!("the benchmark gave {other:?} in place of {}", stringify!($kind)),
        }
    };
}
pub(crate) use next;
