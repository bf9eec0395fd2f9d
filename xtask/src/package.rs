//! `package`: checks that the published crates build from their packages alone.

use crate::tools::{clean, create, remove, run, target_dir};
use anyhow::{Context, Result, ensure};
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Those that are published, each after those that it needs.
const PACKAGES: [&str; 6] = [
    "ads1258",
    "ridgetone-proto",
    "ridgetone-tone",
    "ridgetone-feel",
    "ridgetone-stimulus",
    "ridgetone",
];

/// Packs each and builds it from its package, without network.
///
/// In a target folder and a home of cargo of their own: cargo never reads a package of the same
/// version again.
pub fn check() -> Result<()> {
    let folder = target_dir().join("package-check");
    remove(&folder)?;
    let home = folder.join("home");
    create(&home.join("registry"))?;
    let usual = env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .or_else(|| Some(env::home_dir()?.join(".cargo")));
    let usual = usual.context("neither CARGO_HOME nor a home directory")?;
    for part in ["registry/index", "registry/cache", "config.toml"] {
        if usual.join(part).exists() {
            link(&usual.join(part), &home.join(part))?;
        }
    }
    let target = folder.join("target");
    let mut cargo = clean("cargo");
    cargo.args(["package", "--quiet", "--offline", "--allow-dirty"]);
    cargo.args(PACKAGES.iter().flat_map(|name| ["--package", name]));
    run(cargo
        .env("CARGO_HOME", &home)
        .env("CARGO_TARGET_DIR", &target))
    .context("a package does not build")?;
    for name in PACKAGES {
        check_files(name)?;
        let file = target
            .join("package")
            .join(format!("{name}-{}.crate", env!("CARGO_PKG_VERSION")));
        let bytes = fs::metadata(&file)
            .with_context(|| format!("no {}", file.display()))?
            .len();
        println!("{name:<15} {bytes} bytes packed");
    }
    remove(&folder)
}

/// What a package must hold besides its code.
const FILES: [&str; 3] = ["LICENSE-APACHE", "LICENSE-MIT", "README.md"];

/// Fails if a package has no licences or no README.
fn check_files(name: &str) -> Result<()> {
    let mut cargo = clean("cargo");
    cargo.args([
        "package",
        "--list",
        "--offline",
        "--allow-dirty",
        "--package",
        name,
    ]);
    let listed = cargo.output().context("cargo package --list")?;
    let listed = String::from_utf8_lossy(&listed.stdout);
    for file in FILES {
        ensure!(
            listed.lines().any(|line| line == file),
            "{name} is packed without {file}: put it into the crate's folder"
        );
    }
    Ok(())
}

#[cfg(unix)]
fn link(from: &Path, to: &Path) -> Result<()> {
    std::os::unix::fs::symlink(from, to).with_context(|| format!("cannot link {}", to.display()))
}

#[cfg(not(unix))]
fn link(_: &Path, _: &Path) -> Result<()> {
    anyhow::bail!("only where there are symbolic links")
}
