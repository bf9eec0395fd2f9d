//! The benchmark of a display of pins: as `ridgetone-bench`, an image of its own, since its memory
//! does not fit beside the fit's.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(target_os = "none")]
#[path = "../bench/files.rs"]
mod files;
#[cfg(target_os = "none")]
mod jobs;
#[cfg(target_os = "none")]
#[path = "../bench/machine.rs"]
// It is the fit whose stack is measured.
#[allow(dead_code)]
mod machine;

/// On a PC there is nothing to run.
#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!(
        "This is the pins' benchmark of the chip; run it in the emulator: cargo xtask distance --chip"
    );
    std::process::exit(2);
}
