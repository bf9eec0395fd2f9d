//! Puts `memory.x` where the linker looks for it and hands over the linker scripts, for a target
//! without an operating system only. Not in `.cargo/config.toml`: there the arguments vanish when
//! RUSTFLAGS is set, and what is then linked is an empty image that nobody complains about.

use std::{env, fs, path::PathBuf};

/// The firmware's boards, which are its features.
const BOARDS: [&str; 4] = [
    "feather-f405",
    "nucleo-f446re",
    "feather-f405-adc",
    "nucleo-f446re-adc",
];

/// Says what to type where no board is chosen, or two, and where the profile is not the images'.
fn check_choice(has: &dyn Fn(&str) -> bool) {
    let feature = |board: &&str| board.to_uppercase().replace('-', "_");
    let chosen = BOARDS.iter().filter(|board| has(&feature(board))).count();
    if chosen != 1 {
        println!(
            "cargo::error={chosen} boards are chosen; choose one: --features {}. `cargo feather` and \
             `cargo nucleo` build, flash and log",
            BOARDS.join(", or ")
        );
    } else if env::var("OPT_LEVEL").is_ok_and(|level| level != "s") {
        println!(
            "cargo::warning=this profile is the PC's: the image is slower, and too large for the \
             Nucleo. Take --profile image in its place, as `cargo feather` and `cargo nucleo` do"
        );
    }
}

fn main() {
    // This file and the linker script are part of the script itself: when they change it is built,
    // and run, anew.
    println!("cargo::rerun-if-changed=Cargo.toml");
    let bare = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    let has = |feature: &str| env::var_os(format!("CARGO_FEATURE_{feature}")).is_some();
    if !bare {
        return;
    }
    // The stylus's image and the bench have features of their own.
    if env::var("CARGO_PKG_NAME").is_ok_and(|name| name == "ridgetone-firmware") {
        check_choice(&has);
    }
    if !(has("FIRMWARE") || has("BENCH")) {
        return;
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    // STM32F446RE with 512 KiB and STM32F405RG with 1 MiB, but for two sectors of 128 KiB each.
    let (flash, chip) = if has("NUCLEO_F446RE") || has("NUCLEO_F446RE_ADC") {
        ("256K", "STM32F446RETx")
    } else {
        ("768K", "STM32F405RGTx")
    };
    // `cargo xtask flash` finds the chip's name at probe-rs in the symbol's name.
    let chip = if has("STM32F4") {
        format!("_chip_{chip} = 0;\n")
    } else {
        String::new()
    };
    let size = format!("_flash_size = {flash};\n{chip}");
    for (name, text) in [
        ("memory.x", include_str!("../memory.x")),
        ("flash_size.x", &size),
    ] {
        fs::write(out.join(name), text).expect("OUT_DIR is writable");
    }
    println!("cargo::rustc-link-search={}", out.display());
    // --nmagic: sections need no page alignment in flash. --icf: functions with the same code are
    // one, which takes 1 kB less; nothing here compares their addresses.
    for argument in ["--nmagic", "--icf=all", "-Tlink.x"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
    if has("FIRMWARE") {
        // The log strings' section; the benchmarks have no log.
        println!("cargo::rustc-link-arg-bins=-Tdefmt.x");
    }
}
