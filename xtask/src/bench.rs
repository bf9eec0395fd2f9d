//! `bench`: what the firmware costs, in instructions and in memory, and what it brings.

use crate::images::{self, Board};
use crate::setup;
use crate::tools::{self, clean, root, tell};
use anyhow::Result;

/// What to measure and where it goes.
#[derive(clap::Args)]
pub struct BenchArguments {
    /// Only what is counted on the emulated chip: seconds instead of minutes.
    #[arg(long)]
    chip: bool,
    /// Accuracy over fewer windows, for a look.
    #[arg(long, conflicts_with = "chip")]
    quick: bool,
    /// Write docs/trade.md, its picture and its data from this run.
    #[arg(long, conflicts_with_all = ["chip", "quick"])]
    write: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Builds the benchmarks and the images of both boards, counts in the emulator, measures accuracy here, and prints tables or
/// their JSON.
pub fn run(arguments: &BenchArguments) -> Result<()> {
    setup::qemu()?;
    let (_, sizes) = images::build(Board::FeatherF405.image())?;
    let (elf, _) = images::build(images::BENCH)?;
    let (baselines, _) = images::build(images::BASELINES)?;
    let (firmware, _) = images::build(Board::Emulated.image())?;
    tell("counting, on `ridgetone-eval` built from this tree");
    let mut bench = clean("cargo");
    bench.args([
        "run",
        "--quiet",
        "--release",
        "--package",
        "ridgetone-eval",
        "--bin",
        "ridgetone-eval",
        "--",
        "bench",
    ]);
    bench.arg("--elf").arg(elf).arg("--baselines-elf").arg(baselines).arg("--firmware").arg(firmware);
    bench.args(["--flash-bytes", &sizes.flash.to_string(), "--ram-bytes", &sizes.ram.to_string()]);
    let flags = [("--chip", arguments.chip), ("--quick", arguments.quick), ("--json", arguments.json)];
    bench.args(flags.into_iter().filter(|(_, given)| *given).map(|(flag, _)| flag));
    if arguments.write {
        bench.arg("--write").arg(root().join("docs"));
    }
    tools::run(&mut bench)
}
