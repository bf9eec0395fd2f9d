//! The benchmark: jobs of [`ridgetone_eval::workload`] with their instructions counted, on QEMU's
//! `netduinoplus2` with `-icount shift=0`, where a timer tick is one instruction.
//!
//! It reads the file `workload` in the emulator's working directory and writes `results`. The fit
//! reads its window from the same ring as in the firmware, but for the lock; everything is compiled
//! with the firmware's profile. `cargo xtask bench` builds and runs it.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(target_os = "none")]
mod files;
#[cfg(target_os = "none")]
mod intake;
#[cfg(target_os = "none")]
mod jobs;
#[cfg(target_os = "none")]
mod machine;

/// On a PC there is nothing to run.
#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("This is the benchmark of the chip; run it in the emulator: cargo xtask bench");
    std::process::exit(2);
}
