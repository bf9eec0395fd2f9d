//! Firmware and command built with another scan, in the emulator.
#![cfg(target_os = "linux")]

mod common;

use common::{json_lines, stderr};
use hal_mock::{Sliding, SlidingScene};
use std::path::Path;
use std::process::{Command, Output};

#[test]
#[ignore = "builds the emulated firmware and the command, and needs the emulator: cargo xtask test --all"]
fn firmware_and_command_of_another_scan_find_the_frequency() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let target = root.join("target/scan");
    let cargo = |package: &str, arguments: &str| -> Output {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["run", "--release", "--package", package, "--"]).args(arguments.split(' ')).current_dir(root);
        let output = cargo.env("CARGO_TARGET_DIR", &target).env("RIDGETONE_INPUTS", "8").output().expect("cargo");
        assert!(output.status.success(), "{}", stderr(&output));
        output
    };
    cargo("xtask", "firmware --board emulated");
    let elf = "target/scan/firmware/emulated/ridgetone-firmware.elf";
    let output = cargo("ridgetone-host", &format!("emulate --elf {elf} --scene-speed 30 --period 3.6 --json"));

    let scene = Sliding { speed_mm_s: 30.0, period_mm: 3.6, ..Sliding::physical() };
    let true_hz = SlidingScene::new(scene).expect("a scene").truth().frequency_hz;
    let mut fits = json_lines(&output);
    fits.retain(|event| event["type"] == "estimate");
    assert!(["slide", "window"].iter().all(|span| fits.iter().any(|fit| fit["span"] == *span)), "{fits:?}");
    for fit in fits {
        assert!(fit["status"] == "good" && fit["channels"].as_array().is_some_and(|list| list.len() == 8), "{fit}");
        let (hz, sigma_hz) = (fit["frequency_hz"].as_f64().expect("Hz"), fit["sigma_hz"].as_f64().expect("Hz"));
        assert!((hz - true_hz).abs() < (3.0 * sigma_hz).max(0.001 * true_hz), "{true_hz} Hz: {fit}");
    }
}
