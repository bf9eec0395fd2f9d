//! Tasks that `ridgetone-eval` does, with the images that they need: `bench`, `board`, `noise`,
//! `touch`, `faults`, `reproduce`.

use crate::images::{self, Board};
use crate::setup;
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

/// Builds the benchmarks and the images of both boards, counts in the emulator and measures
/// accuracy here.
pub fn bench(flags: &[String]) -> Result<()> {
    let mut bench = eval("bench");
    bench.args(flags);
    let measures = |what: &str| {
        let mut names = flags.iter().filter_map(|flag| flag.split('=').next());
        names.any(|name| name == what)
    };
    if measures("--plans") {
        images::build(Board::FeatherF405.image())?;
    } else if !measures("--help") && !measures("--converters") {
        // What measures nothing needs no image.
        setup::qemu()?;
        let (_, sizes) = images::build(Board::FeatherF405.image())?;
        let (elf, _) = images::build(images::BENCH)?;
        let (baselines, _) = images::build(images::BASELINES)?;
        let (firmware, _) = images::build(Board::Emulated.image())?;
        bench
            .arg("--elf")
            .arg(elf)
            .arg("--baselines-elf")
            .arg(baselines)
            .arg("--firmware")
            .arg(firmware);
        bench.args([
            "--flash-bytes",
            &sizes.flash.to_string(),
            "--ram-bytes",
            &sizes.ram.to_string(),
        ]);
    }
    run(&mut bench)
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

/// Builds the emulated board's image and injects faults: ten thousand; with `--quick` one thousand;
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
        setup::qemu()?;
        let (elf, _) = images::build(Board::Emulated.image())?;
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
        setup::qemu()?;
        reproduce
            .arg("--elf")
            .arg(images::build(Board::Emulated.image())?.0);
    }
    run(&mut reproduce)
}

fn has(flags: &[String], flag: &str) -> bool {
    flags.iter().any(|given| given == flag)
}
