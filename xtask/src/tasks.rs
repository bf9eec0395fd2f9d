//! Tasks that run a different program of this workspace, with the images that the program needs.

use crate::images::{self, Board};
use crate::toolchain::Toolchain;
use crate::tools::{
    announce, cargo, clean, create, find, output_of, read, root, run, target_dir, write,
};
use crate::{inspect, toolchain};
use anyhow::{Context, Result, anyhow, ensure};
use std::path::Path;
use std::process::Command;
use std::{fs, thread};

/// A command of `ridgetone-eval`, built from this tree.
fn eval(command: &str) -> Command {
    announce(format_args!(
        "`ridgetone-eval {command}`, built from this tree"
    ));
    cargo(
        "run --quiet --release --package ridgetone-eval --bin ridgetone-eval --",
        [command],
    )
}

/// True if `flags` contain `flag`, with or without `=`.
fn has(flags: &[String], flag: &str) -> bool {
    flags
        .iter()
        .any(|given| given.split('=').next() == Some(flag))
}

/// Builds the bench image and the Feather's, counts instructions on the emulator, and measures the
/// scan plans there, for `docs/results/counts.json`.
pub fn counts() -> Result<()> {
    let (flashed, _) = images::build(Board::FeatherF405.image())?;
    let (bench, _) = images::build(images::COUNTS)?;
    announce("instructions of the fit, on the emulator");
    let mut counts = cargo("run --quiet --release --package ridgetone-bench --", []);
    counts.arg(bench).arg(flashed).arg("--json");
    run(counts.arg(root().join("docs/results/counts.json")))
}

/// Injects ten thousand faults, with `--quick` one thousand, with `--full` a hundred thousand, for
/// `docs/results/faults.md`. Fails if a count that must be zero is not.
pub fn faults(flags: &[String]) -> Result<()> {
    let mut faults = eval("faults");
    let amounts = ["--quick", "--full"];
    faults.args(
        flags
            .iter()
            .filter(|flag| !amounts.contains(&flag.as_str())),
    );
    // With a plan, the campaign runs only on the PC.
    if !has(flags, "--help") && !has(flags, "--plan") {
        let (injections, emulated) = match amounts.map(|flag| has(flags, flag)) {
            [true, _] => ("1000", "1"),
            [_, true] => ("100000", "10"),
            _ => ("10000", "4"),
        };
        faults.args(["--injections", injections, "--emulated", emulated, "--elf"]);
        faults.arg(images::build(Board::FeatherF405.image())?.0);
        if has(flags, "--full") {
            faults.arg("--write").arg(root().join("docs/results"));
        }
    }
    run(&mut faults)?;
    if has(flags, "--full") {
        run(clean("python3").arg("lab/pages.py"))?;
    }
    Ok(())
}

/// Installs and builds everything, runs a scene file or the demo's own, and prints the picture's
/// path.
pub fn demo(svg: &Path, scene: Option<&Path>) -> Result<()> {
    let mut demo = cargo(
        "run --quiet --release --package ridgetone-host -- demo --force",
        [],
    );
    if let Some(scene) = scene {
        let scene =
            fs::canonicalize(scene).with_context(|| format!("cannot read {}", scene.display()));
        demo.arg("--scene").arg(scene?);
    }
    announce("building the image and the command `ridgetone`: a few minutes the first time");
    // Not quiet, so that cargo shows its progress.
    let mut command = cargo("build --release --package ridgetone-host", []);
    // Both builds in parallel: the last step of each uses one core.
    let command = thread::spawn(move || run(&mut command));
    let image = images::build(Board::FeatherF405.image());
    command
        .join()
        .map_err(|_| anyhow!("the build panicked"))??;
    let svg = root().join(svg);
    create(svg.parent().unwrap_or(root()))?;
    announce("running the firmware under a simulated finger");
    run(demo.arg("--elf").arg(image?.0).arg("--svg").arg(&svg))?;
    println!("picture       {}", svg.display());
    println!(
        "command       target/release/ridgetone; `cargo install --path host` puts it on the path"
    );
    Ok(())
}

/// Builds a board's image, flashes it and shows its log until interrupted.
pub fn flash(board: Board) -> Result<()> {
    flash_image(&images::build(board.image())?.0)
}

/// Flashes a built image on its board. Used as cargo's runner.
pub fn flash_image(image: &Path) -> Result<()> {
    let chip = inspect::chip(&read(image)?);
    let chip = chip.with_context(|| format!("{} is for no board", image.display()))?;
    let probe_rs = find("probe-rs").context(
        "probe-rs is missing; install version 0.28 or later with `cargo install probe-rs-tools --locked` or from \
         https://probe.rs",
    )?;
    // Flags of probe-rs from 0.28 on. Without the last two the probe halts the chip at each reset
    // and HardFault, which disables the firmware's own recovery: restart, crash record, watchdog.
    let mut probe = clean(probe_rs);
    probe.args([
        "run",
        "--chip",
        &chip,
        "--no-catch-reset",
        "--no-catch-hardfault",
    ]);
    run(probe.arg(image))
}

/// Writes the schemas, the lists of `host/reference.md` and Python's classes generated by a module
/// of the command's library, `events` or `settings_form`. The unit test that compares these files
/// also writes them.
pub fn generate(module: &str) -> Result<()> {
    announce(format_args!("what follows from host/src/{module}"));
    let test = format!("{module}::generated");
    let mut test = cargo(
        "test --quiet --package ridgetone-host --lib",
        [test.as_str()],
    );
    run(test.env("RIDGETONE_WRITE", "1")).context(module.to_owned())
}

/// Builds the stimulus for the page of `ridgetone touch` as WebAssembly, and copies it to where the
/// command embeds it from.
pub fn worklet() -> Result<()> {
    const TARGET: &str = "wasm32-unknown-unknown";
    toolchain::add_target(TARGET)?;
    announce("building teletaction/assets/touch/stimulus.wasm");
    let library = "rustc --package ridgetone-teletaction --lib --crate-type cdylib --profile image";
    let mut cargo = cargo(library, ["--target", TARGET]);
    for setting in ["strip=true", "panic=\"abort\"", "opt-level=\"s\""] {
        cargo.args(["--config", &format!("profile.image.{setting}")]);
    }
    run(&mut cargo)?;
    let built = target_dir()
        .join(TARGET)
        .join("image/ridgetone_teletaction.wasm");
    let to = root().join("teletaction/assets/touch/stimulus.wasm");
    let bytes = read(&built)?;
    write(&to, &bytes)?;
    println!("{}: {} bytes", to.display(), bytes.len());
    Ok(())
}

/// Checks that the command builds for other systems, also as a package, if rustup may fetch their
/// core libraries.
pub fn check_systems() -> Result<()> {
    for target in [
        "x86_64-pc-windows-gnu",
        "aarch64-apple-darwin",
        "aarch64-unknown-linux-musl",
    ] {
        if let Err(error) = toolchain::add_target(target) {
            println!("not checked: {target}: {error:#}");
            continue;
        }
        announce(format_args!("checking the command for {target}"));
        let mut check = cargo("check --quiet --package ridgetone-host --target", [target]);
        run(&mut check).with_context(|| format!("the command does not build for {target}"))?;
    }
    Ok(())
}

/// Builds the driver's examples for boards. They are a separate workspace with additional crates:
/// if these or a compiler cannot be fetched, prints the reason and succeeds.
pub fn driver_boards() -> Result<()> {
    let folder = root().join("crates/ads1258/boards");
    let mut fetch = cargo("fetch --locked", []);
    let ready = output_of(fetch.current_dir(&folder)).and_then(|_| Toolchain::find_or_install());
    let toolchain = match ready {
        Ok(toolchain) => toolchain,
        Err(error) => {
            let error = format!("{error:#}");
            ensure!(
                !error.contains("--locked"),
                "its Cargo.lock is old: {error}"
            );
            println!("not built: {}: {error}", folder.display());
            return Ok(());
        }
    };
    announce(format_args!("building {}", folder.display()));
    let mut build = toolchain.cargo("build");
    build.args(["--quiet", "--release", "--locked"]);
    run(build.current_dir(&folder)).context("an example of ads1258 for a board does not build")
}
