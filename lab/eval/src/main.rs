//! `ridgetone-eval`: evaluation campaigns of Ridgetone, as commands. `cargo xtask` builds their
//! images and runs them.

fn main() -> std::process::ExitCode {
    ridgetone_eval::main()
}
