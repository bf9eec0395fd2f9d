//! Tasks that `ridgetone-eval` does, with the images that they need: `bench`, `faults`, `reproduce`.

use crate::images::{self, Board};
use crate::setup;
use crate::tools::{clean, root, run, tell};
use anyhow::Result;
use std::process::Command;

/// `bench`
#[derive(clap::Args)]
pub struct BenchArguments {
    /// Only the counts on the emulated chip: seconds instead of minutes.
    #[arg(long)]
    chip: bool,
    /// Accuracy over fewer windows, for a look.
    #[arg(long, conflicts_with = "chip")]
    quick: bool,
    /// Write docs/trade.json and fill in docs/trade.md and its picture.
    #[arg(long, conflicts_with_all = ["chip", "quick"])]
    write: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// `faults`
#[derive(clap::Args)]
pub struct FaultsArguments {
    /// A thousand injections on this PC and few runs in the emulator, for a look.
    #[arg(long)]
    quick: bool,
    /// A hundred thousand injections instead of ten thousand, and fill in docs/faults.md. Takes most of an hour.
    #[arg(long, conflicts_with = "quick")]
    full: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// `ridgetone-eval` with a command, built from this tree.
fn eval(command: &str) -> Command {
    tell(format_args!("`ridgetone-eval {command}`, built from this tree"));
    let mut cargo = clean("cargo");
    cargo.args([
        "run",
        "--quiet",
        "--release",
        "--package",
        "ridgetone-eval",
        "--bin",
        "ridgetone-eval",
        "--",
        command,
    ]);
    cargo
}

/// Builds the benchmarks and the images of both boards, counts in the emulator and measures accuracy here.
pub fn bench(arguments: &BenchArguments) -> Result<()> {
    setup::qemu()?;
    let (_, sizes) = images::build(Board::FeatherF405.image())?;
    let (elf, _) = images::build(images::BENCH)?;
    let (baselines, _) = images::build(images::BASELINES)?;
    let (firmware, _) = images::build(Board::Emulated.image())?;
    let mut bench = eval("bench");
    bench.arg("--elf").arg(elf).arg("--baselines-elf").arg(baselines).arg("--firmware").arg(firmware);
    bench.args(["--flash-bytes", &sizes.flash.to_string(), "--ram-bytes", &sizes.ram.to_string()]);
    let flags = [("--chip", arguments.chip), ("--quick", arguments.quick), ("--json", arguments.json)];
    bench.args(flags.into_iter().filter(|(_, given)| *given).map(|(flag, _)| flag));
    if arguments.write {
        bench.arg("--write").arg(root().join("docs"));
    }
    run(&mut bench)
}

/// Builds the emulated board's image and injects faults. Fails if a number is not zero that must be.
pub fn faults(arguments: &FaultsArguments) -> Result<()> {
    setup::qemu()?;
    let (elf, _) = images::build(Board::Emulated.image())?;
    let (injections, emulated) = match (arguments.quick, arguments.full) {
        (true, _) => ("1000", "1"),
        (_, true) => ("100000", "10"),
        _ => ("10000", "4"),
    };
    let mut faults = eval("faults");
    faults.args(["--injections", injections, "--emulated", emulated, "--elf"]).arg(elf);
    if arguments.full {
        faults.arg("--write").arg(root().join("docs"));
    }
    if arguments.json {
        faults.arg("--json");
    }
    run(&mut faults)
}

/// Repeats the paper's experiment. With `--emulated` it builds the image, unless `--elf` names one.
pub fn reproduce(arguments: &[String]) -> Result<()> {
    let has = |flag: &str| arguments.iter().any(|argument| argument == flag);
    let elf = match has("--emulated") && !has("--elf") {
        true => {
            setup::qemu()?;
            Some(images::build(Board::Emulated.image())?.0)
        }
        false => None,
    };
    let mut reproduce = eval("reproduce");
    reproduce.args(arguments);
    if let Some(elf) = elf {
        reproduce.arg("--elf").arg(elf);
    }
    run(&mut reproduce)
}
