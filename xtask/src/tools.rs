//! Finds and runs programs, in an environment without cargo's variables.

use anyhow::{Context, Result, anyhow, ensure};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::{env, fs, thread};

pub fn root() -> &'static Path {
    let xtask = Path::new(env!("CARGO_MANIFEST_DIR"));
    xtask.parent().unwrap_or(xtask)
}

/// Folder of cargo's builds.
pub fn target_dir() -> PathBuf {
    root().join(
        env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from),
    )
}

/// A program's full path, if PATH has it.
pub fn find(program: &str) -> Option<PathBuf> {
    let name = format!("{program}{}", env::consts::EXE_SUFFIX);
    env::split_paths(&env::var_os("PATH")?)
        .map(|folder| folder.join(&name))
        .find(|path| path.is_file())
}

/// Announces a step that takes a while.
pub fn announce(what: impl std::fmt::Display) {
    eprintln!("xtask: {what}");
}

/// Prefixes of cargo's variables that an inner cargo needs.
const KEPT: &str = "CARGO_HOME CARGO_TARGET_DIR CARGO_NET_ CARGO_HTTP_ CARGO_TERM_ CARGO_REGISTR";

/// Other variables set by cargo and rustup.
const REMOVED: &str =
    "RUSTC RUSTDOC RUSTFLAGS RUSTUP_TOOLCHAIN RUST_RECURSION_COUNT LD_LIBRARY_PATH";

/// A command in the workspace's root, without the environment of `cargo run`, which would make the
/// inner cargo use the outer one's compiler.
pub fn clean(program: impl AsRef<std::ffi::OsStr>) -> Command {
    let mut command = Command::new(program);
    command.current_dir(root());
    for (name, _) in env::vars_os() {
        let Some(text) = name.to_str() else { continue };
        let is_kept = KEPT.split(' ').any(|start| text.starts_with(start));
        let is_removed = REMOVED.split(' ').any(|removed| removed == text);
        if is_removed || (text.starts_with("CARGO") && !is_kept) {
            command.env_remove(&name);
        }
    }
    command
}

/// Creates a cargo command from the words of a text and further words.
pub fn cargo<'a>(words: &str, more: impl IntoIterator<Item = &'a str>) -> Command {
    let mut cargo = clean("cargo");
    cargo.args(words.split_whitespace()).args(more);
    cargo
}

/// Runs a command to its end, with its output on the terminal.
pub fn run(command: &mut Command) -> Result<()> {
    finish(command).map(drop)
}

/// Runs a command and returns its output, without the final newline.
pub fn output_of(command: &mut Command) -> Result<String> {
    finish(
        command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped()),
    )
}

fn finish(command: &mut Command) -> Result<String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command
        .spawn()
        .and_then(Child::wait_with_output)
        .with_context(|| format!("cannot run {name}"))?;
    let [printed, errors] =
        [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    ensure!(
        output.status.success(),
        "{name} failed ({}) {}\n{}",
        output.status,
        errors.trim(),
        printed.trim()
    );
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Runs two closures in parallel. Returns both results, or all errors, as one may have caused the
/// other.
pub fn both<A, B: Send>(
    here: impl FnOnce() -> Result<A>,
    beside: impl FnOnce() -> Result<B> + Send,
) -> Result<(A, B)> {
    thread::scope(|scope| {
        let beside = scope.spawn(beside);
        let here = here();
        let beside = beside
            .join()
            .map_err(|_| anyhow!("what ran beside ended without a result"))?;
        match (here, beside) {
            (Ok(here), Ok(beside)) => Ok((here, beside)),
            (Err(here), Err(beside)) => Err(anyhow!("{here:#}; and beside it: {beside:#}")),
            (Err(error), _) | (_, Err(error)) => Err(error),
        }
    })
}

/// Creates a folder, if missing.
pub fn create(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))
}

/// Removes a folder, if present.
pub fn remove(folder: &Path) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder)
            .with_context(|| format!("cannot remove {}", folder.display()))?;
    }
    Ok(())
}

pub fn read(path: &Path) -> Result<Vec<u8>> {
    fs::read(path).with_context(|| format!("cannot read {}", path.display()))
}

pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

#[test]
fn two_things_at_once_give_both_results_or_all_errors() {
    type Side = Result<u8, &'static str>;
    let run = |here: Side, beside: Side| {
        let side = |result: Side| move || result.map_err(|error| anyhow!(error));
        both(side(here), side(beside)).map_err(|error| error.to_string())
    };
    assert_eq!(run(Ok(1), Ok(2)), Ok((1, 2)));
    assert_eq!(run(Ok(1), Err("one")), Err("one".into()));
    let all = run(Err("here"), Err("there")).expect_err("both fail");
    assert!(all.contains("here") && all.contains("there"), "{all}");
}
