//! `ridgetone-eval`: Ridgetone's evaluation campaigns as commands. `cargo xtask` builds the images
//! and runs them.

fn main() -> std::process::ExitCode {
    ridgetone_eval::main()
}
