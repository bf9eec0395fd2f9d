//! `bench`: what the firmware costs, in instructions and in memory.

use crate::images::{self, Board};
use crate::setup;
use crate::tools::{self, clean, tell};
use anyhow::Result;

/// Builds the benchmark and the images of both boards, counts in the emulator, and prints the table or its JSON.
pub fn run(json: bool) -> Result<()> {
    setup::qemu()?;
    let (_, sizes) = images::build(Board::FeatherF405.image())?;
    let (elf, _) = images::build(images::BENCH)?;
    let (firmware, _) = images::build(Board::Emulated.image())?;
    tell("counting, on the command `ridgetone` built from this tree");
    let mut bench = clean("cargo");
    bench.args(["run", "--quiet", "--release", "--package", "ridgetone-host", "--bin", "ridgetone", "--", "bench"]);
    bench.arg("--elf").arg(elf).arg("--firmware").arg(firmware);
    bench.args(["--flash-bytes", &sizes.flash.to_string(), "--ram-bytes", &sizes.ram.to_string()]);
    if json {
        bench.arg("--json");
    }
    tools::run(&mut bench)
}
