//! `ridgetone-eval`: what proves Ridgetone, as commands. `cargo xtask` builds their images and runs
//! them.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    ridgetone_eval::main()
}
