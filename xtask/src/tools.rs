//! Programs: where they are, running them, and an environment that is not cargo's own.

use anyhow::{Context, Result, bail};
use std::env;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output};

/// The workspace's root directory.
pub fn root() -> &'static Path {
    let xtask = Path::new(env!("CARGO_MANIFEST_DIR"));
    xtask.parent().unwrap_or(xtask)
}

/// Where cargo puts what it builds.
pub fn target_dir() -> PathBuf {
    root().join(env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from))
}

/// A program's full path, if PATH has it.
pub fn find(program: &str) -> Option<PathBuf> {
    let name = format!("{program}{}", env::consts::EXE_SUFFIX);
    env::split_paths(&env::var_os("PATH")?).map(|folder| folder.join(&name)).find(|path| path.is_file())
}

/// Announces a step that takes a while.
pub fn announce(what: impl std::fmt::Display) {
    eprintln!("xtask: {what}");
}

/// A command in the workspace's root, without what `cargo run` has put into the environment: with it
/// the inner cargo would use the outer one's compiler.
pub fn clean(program: impl AsRef<std::ffi::OsStr>) -> Command {
    let mut command = Command::new(program);
    command.current_dir(root());
    for (name, _) in env::vars_os() {
        let Some(text) = name.to_str() else { continue };
        let kept = ["CARGO_HOME", "CARGO_TARGET_DIR"].contains(&text)
            || ["CARGO_NET_", "CARGO_HTTP_", "CARGO_TERM_", "CARGO_REGISTR"]
                .iter()
                .any(|start| text.starts_with(start));
        let cargos = text.starts_with("CARGO")
            || ["RUSTC", "RUSTDOC", "RUSTFLAGS", "RUSTUP_TOOLCHAIN", "RUST_RECURSION_COUNT", "LD_LIBRARY_PATH"]
                .contains(&text);
        if cargos && !kept {
            command.env_remove(&name);
        }
    }
    command
}

/// Runs a command to its end; its output goes to the terminal.
pub fn run(command: &mut Command) -> Result<()> {
    finish(start(command)?)
}

/// A command that runs.
pub struct Running {
    name: String,
    child: Child,
}

/// Starts a command; its output goes to the terminal.
pub fn start(command: &mut Command) -> Result<Running> {
    let name = command.get_program().to_string_lossy().into_owned();
    let child = command.spawn().with_context(|| format!("cannot run {name}"))?;
    Ok(Running { name, child })
}

/// Waits for its end.
pub fn finish(Running { name, mut child }: Running) -> Result<()> {
    let status = child.wait().with_context(|| format!("cannot run {name}"))?;
    if !status.success() {
        bail!("{name} failed ({status})");
    }
    Ok(())
}

/// Runs a command and gives its output, without the end of the last line.
pub fn output_of(command: &mut Command) -> Result<String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let Output { status, stdout, stderr } = command.output().with_context(|| format!("cannot run {name}"))?;
    if !status.success() {
        bail!("{name} failed ({status}): {}", String::from_utf8_lossy(&stderr).trim());
    }
    Ok(String::from_utf8_lossy(&stdout).trim().to_owned())
}
