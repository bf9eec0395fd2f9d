//! Puts `memory.x` where the linker finds it and passes the linker scripts, only for a target
//! without an operating system. `.cargo/config.toml` cannot do this: its arguments vanish when
//! RUSTFLAGS is set, and the result is an empty image without any error.

use std::{env, fs, path::PathBuf};

/// Boards and their files. A board's features are its name, and its name with `-adc`.
const BOARDS: [(&str, &str); 4] = [
    ("feather-f405", include_str!("board/feather_f405.rs")),
    ("nucleo-f446re", include_str!("board/nucleo_f446re.rs")),
    ("blackpill-f411", include_str!("board/blackpill_f411.rs")),
    ("blackpill-f401", include_str!("board/blackpill_f401.rs")),
];

/// Returns the value of a field of `MEMORY` in a board's file.
fn field<'a>(file: &'a str, name: &str) -> &'a str {
    let (_, memory) = file
        .split_once("const MEMORY: Memory =")
        .expect("a board has MEMORY");
    let (_, value) = memory
        .split_once(&format!("{name}: "))
        .expect("MEMORY has it");
    value
        .split([',', ' ', '\n'])
        .next()
        .unwrap_or_default()
        .trim_matches('"')
}

/// Returns the chosen board's feature and file. If none or two are chosen, or the profile is not
/// that of the images, prints what to type.
fn board(has: &dyn Fn(&str) -> bool) -> Option<(String, &'static str)> {
    let features = BOARDS.iter().flat_map(|(name, file)| {
        let own_adc = format!("{name}-adc");
        [((*name).to_owned(), *file), (own_adc, *file)]
    });
    let is_chosen = |(name, _): &(String, _)| has(&name.to_uppercase().replace('-', "_"));
    let mut chosen = features.filter(is_chosen).collect::<Vec<_>>();
    if chosen.len() != 1 {
        println!(
            "cargo::error={} boards are chosen; choose one: --features {}, or one of them with -adc. \
             `cargo feather`, `cargo nucleo` and `cargo blackpill` build, flash and log",
            chosen.len(),
            BOARDS.map(|(name, _)| name).join(", or ")
        );
    } else if env::var("OPT_LEVEL").is_ok_and(|level| level != "s") {
        println!(
            "cargo::warning=this profile is the PC's: the image is slower, and too large for most \
             boards. Take --profile image in its place, as `cargo feather` and `cargo nucleo` do"
        );
    }
    chosen.pop()
}

fn main() {
    // This file and the linker script are part of the build script, which is rebuilt and rerun when
    // they change.
    println!("cargo::rerun-if-changed=Cargo.toml");
    let bare = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    let has = |feature: &str| env::var_os(format!("CARGO_FEATURE_{feature}")).is_some();
    if !bare {
        return;
    }
    // The stylus's image and the benchmarks have their own features, and run on a Feather.
    let is_finger = env::var("CARGO_PKG_NAME").is_ok_and(|name| name == "ridgetone-firmware");
    let [(feather, its_file), ..] = BOARDS;
    let chosen = if is_finger {
        board(&has)
    } else {
        Some((feather.into(), its_file))
    };
    if !(has("FIRMWARE") || has("BENCH")) {
        return;
    }
    let Some((board, file)) = chosen else { return };
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let number = |name| field(file, name).parse::<u32>().expect("a number");
    // Two sectors of 128 KiB each are reserved for settings. `cargo xtask flash` and the emulator
    // read the board and the chip's name in probe-rs from symbol names.
    let mut sizes = format!(
        "_flash_size = {}K;\n_ram_size = {}K;\n_ccm_size = {}K;\n_stack_size = {};\n",
        number("flash_kib") - 256,
        number("ram_kib"),
        number("ccm_kib"),
        number("stack_bytes")
    );
    if has("STM32F4") {
        sizes += &format!("_chip_{} = 0;\n", field(file, "chip"));
    }
    if is_finger && !has("MINIMAL") {
        sizes += &format!("_board_{} = 0;\n", board.replace('-', "_"));
    }
    for (name, text) in [
        ("memory.x", include_str!("../memory.x")),
        ("sizes.x", &sizes),
    ] {
        fs::write(out.join(name), text).expect("OUT_DIR is writable");
    }
    println!("cargo::rustc-link-search={}", out.display());
    // --nmagic: sections need no page alignment in flash. --icf: functions with identical code are
    // merged, which saves 1 kB; nothing here compares their addresses.
    for argument in ["--nmagic", "--icf=all", "-Tlink.x"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
    if has("FIRMWARE") {
        // The log strings' section; the benchmarks have no log.
        println!("cargo::rustc-link-arg-bins=-Tdefmt.x");
    }
}
