//! `bench`: what the firmware's steps cost, counted on the emulated Cortex-M4F.
//!
//! The images `ridgetone-bench` and `baselines-bench` do the jobs that are written for them ([`crate::workload`]); what
//! they find must be what this PC finds, to the last bit, or there is no table. `cargo xtask bench` builds the images and
//! runs this.

mod baselines;
mod emulated;
mod fits;
mod frames;
mod report;

pub use self::baselines::{BaselineCell, CARRIED as BASELINES_CARRIED};
pub use emulated::Jobs;
pub use fits::{CHANNELS, Cell, HARMONICS, PASS_INSTRUCTIONS, SNR_DB, WINDOWS_S, is_measured};
pub use frames::Phase;
pub use report::{Bar, Report, Stack, grouped};

use crate::workload::{Job, Measured, Wire, longest_packet};
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use ridgetone_host::demo;
use ridgetone_host::emulator::Options;
use ridgetone_proto::telemetry::WIRE_MAX;
use std::path::{Path, PathBuf};

/// `bench`
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// The image of the benchmark; without one nothing is counted.
    #[arg(long, value_name = "FILE.elf", requires_all = ["baselines_elf", "flash_bytes", "ram_bytes"])]
    pub elf: Option<PathBuf>,
    /// The image of the baselines' benchmark.
    #[arg(long, value_name = "FILE.elf")]
    pub baselines_elf: Option<PathBuf>,
    /// The emulated board's firmware, to measure its stack over a touch.
    #[arg(long, value_name = "FILE.elf", requires = "elf")]
    pub firmware: Option<PathBuf>,
    /// Flash that the board's image takes, bytes.
    #[arg(long)]
    pub flash_bytes: Option<u64>,
    /// RAM that its statics take, bytes.
    #[arg(long)]
    pub ram_bytes: Option<u64>,
    /// Only what is counted on the emulated chip.
    #[arg(long, requires = "elf")]
    pub chip: bool,
    /// Fewer windows, for a look.
    #[arg(long, conflicts_with = "chip")]
    pub quick: bool,
    /// Write trade.md, its picture and its data into a folder.
    #[arg(long, value_name = "FOLDER", requires = "elf", conflicts_with_all = ["chip", "quick"])]
    pub write: Option<PathBuf>,
    /// Write trade.md and its picture anew from the data in a folder, and measure nothing.
    #[arg(long, value_name = "FOLDER", exclusive = true)]
    pub render: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// Runs the benchmark and the baselines', and the default scene through the emulated board's `firmware` if there is one.
/// `flash_bytes` and `ram_bytes` are those of the board's image.
///
/// # Errors
/// The emulator or an image fails; the chip and this PC do not find the same.
pub fn run(
    elf: &Path,
    baselines_elf: &Path,
    firmware: Option<&Path>,
    flash_bytes: u64,
    ram_bytes: u64,
) -> Result<Report> {
    let fits = fits::Fits::new()?;
    let frames = frames::Frames::new()?;
    let mut jobs = Jobs::default();
    fits.write(&mut jobs);
    frames.write(&mut jobs);
    jobs.add(Job::Encode);
    jobs.add(Job::Intake);
    let mut measured = jobs.run(elf)?.into_iter();

    let cells = fits.read(&mut measured)?;
    let phases = frames.read(&mut measured)?;
    let (encode_instructions, wire) = message(&mut measured)?;
    let mut bytes = [0; WIRE_MAX];
    let used = Wire::write(&longest_packet(), &mut bytes);
    ensure!(wire == Wire::new(&bytes[..used]), "the longest packet: {wire:?} on the chip, {used} bytes here");
    let next = measured.next();
    let Some(Measured::Intake { instructions: intake }) = next else {
        bail!("the benchmark told of {next:?} where a conversion was due");
    };
    ensure!(measured.next().is_none(), "the benchmark told more than it was asked");

    let baselines = baselines::Baselines::new()?;
    let mut jobs = Jobs::default();
    baselines.write(&mut jobs);
    let mut measured = jobs.run(baselines_elf)?.into_iter();
    let baseline_cells = baselines.read(&mut measured)?;
    ensure!(measured.next().is_none(), "the baselines' benchmark told more than it was asked");

    let stack = firmware.map(stack).transpose()?;
    let encode = (encode_instructions, wire.bytes);
    Ok(Report::new(cells, baseline_cells, phases, encode, intake, stack, (flash_bytes, ram_bytes)))
}

/// The most stack that the firmware has in use over the default scene, by its own measure.
fn stack(firmware: &Path) -> Result<Stack> {
    let outcome = demo::run(hal_mock::Sliding::default(), Options::new(firmware), &mut |_, _| {})?.outcome;
    let said = outcome.messages.lines().find_map(Stack::parse);
    said.with_context(|| format!("the firmware did not tell its stack: {}", outcome.messages.trim()))
}

/// The next measurement, which must be that of a packet.
fn message(measured: &mut dyn Iterator<Item = Measured>) -> Result<(u32, Wire)> {
    let next = measured.next();
    let Some(Measured::Message { instructions, wire }) = next else {
        bail!("the benchmark told of {next:?} where a packet was due");
    };
    Ok((instructions, wire))
}
