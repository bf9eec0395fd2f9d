//! `faults`: what becomes of faults injected into chip, bus and lines.

use crate::images::{self, Board};
use crate::setup;
use crate::tools::{self, clean, root, tell};
use anyhow::Result;

/// How much of it.
#[derive(clap::Args)]
pub struct FaultsArguments {
    /// A thousand injections on this PC and few runs in the emulator, for a look.
    #[arg(long)]
    quick: bool,
    /// A hundred thousand injections instead of ten thousand, and docs/faults.md anew. Takes most of an hour.
    #[arg(long, conflicts_with = "quick")]
    full: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Builds the emulated board's image, injects, and prints the table; of a full run it writes `docs/faults.md`. Fails if something is
/// not zero that must be.
pub fn run(arguments: &FaultsArguments) -> Result<()> {
    setup::qemu()?;
    let (elf, _) = images::build(Board::Emulated.image())?;
    tell("injecting, with `ridgetone-eval` built from this tree");
    let (injections, emulated) = match (arguments.quick, arguments.full) {
        (true, _) => ("1000", "1"),
        (_, true) => ("100000", "10"),
        _ => ("10000", "4"),
    };
    let mut faults = clean("cargo");
    faults.args([
        "run",
        "--quiet",
        "--release",
        "--package",
        "ridgetone-eval",
        "--bin",
        "ridgetone-eval",
        "--",
        "faults",
    ]);
    faults.args(["--injections", injections, "--emulated", emulated, "--elf"]).arg(elf);
    if arguments.full {
        faults.arg("--write").arg(root().join("docs"));
    }
    if arguments.json {
        faults.arg("--json");
    }
    tools::run(&mut faults)
}
