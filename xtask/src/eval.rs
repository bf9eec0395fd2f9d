//! Tasks that `ridgetone-eval` does, with the images that they need: `bench`, `board`, `noise`,
//! `touch`, `faults`, `reproduce`.

use crate::images::{self, Board};
use crate::tools::{announce, program, root, run};
use anyhow::Result;
use std::process::Command;

/// A command of `ridgetone-eval`, built from this tree.
fn eval(command: &str) -> Command {
    announce(format_args!(
        "`ridgetone-eval {command}`, built from this tree"
    ));
    program("ridgetone-eval", "ridgetone-eval", command)
}

/// Measures accuracy here, and scan plans on the Feather's image.
pub fn bench(flags: &[String]) -> Result<()> {
    if flags.iter().any(|flag| flag.starts_with("--plans")) {
        images::build(Board::FeatherF405.image())?;
    }
    run(eval("bench").args(flags))
}

/// Builds the bench image and that of the Feather, and counts instructions on the emulator.
pub fn counts() -> Result<()> {
    let (flashed, _) = images::build(Board::FeatherF405.image())?;
    let (bench, _) = images::build(images::COUNTS)?;
    announce("instructions of the fit, on the emulator");
    let package = "ridgetone-bench";
    run(program(package, package, &bench.to_string_lossy()).arg(flashed))
}

/// A command that needs no image: `noise`, `touch`, `real`.
pub fn plain(command: &str, arguments: &[String]) -> Result<()> {
    run(eval(command).args(arguments))
}

/// Fills in a page of `docs/results` from its figures.
pub fn page(topic: &str) -> Result<()> {
    run(eval("pages").args(["--topic", topic]))
}

/// Builds the boards' images and measures them on the register model; with `--write` it fills in
/// `docs/results/boards.md`.
pub fn board(write: bool) -> Result<()> {
    for board in Board::REAL {
        images::build(board.image())?;
    }
    let mut board = eval("board");
    if write {
        board.arg("--write").arg(root().join("docs/results"));
    }
    run(&mut board)
}

/// Builds the Feather's image and injects faults: ten thousand; with `--quick` one thousand;
/// with `--full` a hundred thousand, for `docs/results/faults.md`. Fails if a number is not zero that must
/// be.
pub fn faults(flags: &[String]) -> Result<()> {
    let mut faults = eval("faults");
    faults.args(
        flags
            .iter()
            .filter(|flag| !["--quick", "--full"].contains(&flag.as_str())),
    );
    // With a plan it runs on the PC alone.
    if !has(flags, "--help")
        && !flags
            .iter()
            .any(|flag| flag == "--plan" || flag.starts_with("--plan="))
    {
        let (elf, _) = images::build(Board::FeatherF405.image())?;
        let (injections, emulated) = match (has(flags, "--quick"), has(flags, "--full")) {
            (true, _) => ("1000", "1"),
            (_, true) => ("100000", "10"),
            _ => ("10000", "4"),
        };
        faults
            .args(["--injections", injections, "--emulated", emulated, "--elf"])
            .arg(elf);
        if has(flags, "--full") {
            faults.arg("--write").arg(root().join("docs/results"));
        }
    }
    run(&mut faults)
}

/// Repeats the paper's experiment. With `--emulated` it builds the image, unless `--elf` names one.
pub fn reproduce(flags: &[String]) -> Result<()> {
    let mut reproduce = eval("reproduce");
    reproduce.args(flags);
    if has(flags, "--emulated") && !has(flags, "--elf") {
        reproduce
            .arg("--elf")
            .arg(images::build(Board::FeatherF405.image())?.0);
    }
    run(&mut reproduce)
}

fn has(flags: &[String], flag: &str) -> bool {
    flags.iter().any(|given| given == flag)
}
