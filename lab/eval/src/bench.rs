//! The cost of the firmware's steps, counted on the emulated Cortex-M4F.
//!
//! The images `ridgetone-bench` and `baselines-bench` do the jobs that are written for them
//! ([`crate::workload`]). Their results must be those of this PC, to the last bit, or there is no
//! table. `cargo xtask bench` builds the images and runs this.

pub mod baselines;
pub mod emulated;
pub mod fits;
mod frames;
pub mod report;

use crate::trade::setups::{SCENES, SCENES_S};
use crate::workload::{Job, Wire, longest_packet};
use anyhow::{Context, Result, ensure};
use clap::Args;
use emulated::{Jobs, next};
use fits::Fits;
use report::{Report, Stack};
use ridgetone_host::demo;
use ridgetone_host::emulator::Options;
use ridgetone_proto::telemetry::WIRE_MAX;
use std::path::{Path, PathBuf};

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
    /// Only the counts on the emulated chip.
    #[arg(long, requires = "elf")]
    pub chip: bool,
    /// Fewer windows, for a look.
    #[arg(long, conflicts_with = "chip")]
    pub quick: bool,
    /// Write trade.json and its picture into a folder, and fill in trade.md there.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/results", requires = "elf", conflicts_with_all = ["chip", "quick"])]
    pub write: Option<PathBuf>,
    /// Measure the scan plans instead: accuracy here, load and latency on the register model.
    /// Writes them into trade.json and trade.md in a folder. Takes three minutes.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/results", exclusive = true)]
    pub plans: Option<PathBuf>,
    /// Measure the STM32's own converter beside the ADS1258 instead. Writes them into trade.json and
    /// trade.md in a folder. Takes two minutes.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/results", exclusive = true)]
    pub converters: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// Runs the benchmark and the baselines', and the default scene through the emulated board's
/// `firmware` if there is one. `flash_bytes` and `ram_bytes` are those of the board's image.
pub fn run(
    elf: &Path,
    baselines_elf: &Path,
    firmware: Option<&Path>,
    flash_bytes: u64,
    ram_bytes: u64,
) -> Result<Report> {
    let (fits, scenes) = (Fits::new()?, Fits::of_scenes(&SCENES, &SCENES_S)?);
    let frames = frames::Frames::new()?;
    let mut jobs = Jobs::default();
    fits.write(&mut jobs);
    scenes.write(&mut jobs);
    frames.write(&mut jobs);
    jobs.add(Job::Encode, [(); 0]);
    jobs.add(Job::Intake, [(); 0]);
    let mut measured = jobs.run(elf)?.into_iter();

    let cells = fits.read(&mut measured)?;
    let scenes = scenes.read(&mut measured)?;
    let phases = frames.read(&mut measured)?;
    let (encode_instructions, wire) = next!(measured, Message { instructions, wire });
    let mut bytes = [0; WIRE_MAX];
    let used = Wire::write(&longest_packet(), &mut bytes);
    ensure!(
        wire == Wire::new(&bytes[..used]),
        "the longest packet: {wire:?} on the chip, {used} bytes here"
    );
    let intake_instructions = next!(measured, Intake { instructions });
    ensure!(
        measured.next().is_none(),
        "the benchmark gave more results than jobs"
    );

    let baselines = baselines::Baselines::new()?;
    let mut jobs = Jobs::default();
    baselines.write(&mut jobs);
    let mut measured = jobs.run(baselines_elf)?.into_iter();
    let baseline_cells = baselines.read(&mut measured)?;
    ensure!(
        measured.next().is_none(),
        "the baselines' benchmark gave more results than jobs"
    );

    let firmware_stack = firmware.map(stack).transpose()?;
    let report = Report {
        fits: cells,
        scenes,
        baselines: baseline_cells,
        frames: phases,
        encode_instructions,
        encode_bytes: wire.bytes,
        intake_instructions,
        flash_bytes,
        ram_bytes,
        firmware_stack,
        bars: Vec::new(),
    };
    Ok(report.with_bars())
}

/// The most stack that the firmware has in use over the default scene, by its own measure.
fn stack(firmware: &Path) -> Result<Stack> {
    let outcome = demo::run(
        hal_mock::Sliding::default(),
        Options::new(firmware),
        &mut |_, _| {},
    )?
    .outcome;
    let stack = outcome.messages.lines().find_map(Stack::parse);
    stack.with_context(|| {
        format!(
            "the firmware did not report its stack: {}",
            outcome.messages.trim()
        )
    })
}
