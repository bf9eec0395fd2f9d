//! The baselines' benchmark: as `ridgetone-bench`, an image of its own. The fit's image is compiled
//! without them, so that they do not change what is measured there.
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
        "This is the baselines' benchmark of the chip; run it in the emulator: cargo xtask bench"
    );
    std::process::exit(2);
}
