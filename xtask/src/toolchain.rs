//! The compiler and the core library for the Cortex-M4F, from one of two sources:
//!
//! 1. `rustup target add thumbv7em-none-eabihf`: what most people have.
//! 2. Debian's packages, with the library's sources, which cargo compiles: for machines where
//!    rustup may not download.
//!
//! The environment variable `RIDGETONE_TOOLCHAIN` forces a source: `rustup` or `debian`.

use crate::install;
use crate::tools::{announce, cargo, clean, find, output_of};
use anyhow::{Context, Result, bail, ensure};
use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The Cortex-M4F with hardware floating point.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// Environment variable that forces a source.
const FORCE: &str = "RIDGETONE_TOOLCHAIN";

/// Packages of source 2. Debian 12 has a recent compiler because its web browsers need one.
const DEBIAN_PACKAGES: [&str; 3] = ["rustc-web", "cargo-web", "rust-web-src"];

/// Oldest usable compiler (`rust-version` of the workspace): 1.88.
const OLDEST: (u32, u32) = (1, 88);

/// An installed toolchain for [`TARGET`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Toolchain {
    /// The usual cargo; its compiler has the library.
    Rustup,
    /// Debian's cargo, which builds the library as well, and a linker for Arm.
    Debian { linker: PathBuf },
}

impl Toolchain {
    /// Finds a toolchain, or installs one.
    pub fn find_or_install() -> Result<Self> {
        let forced = env::var(FORCE).unwrap_or_default();
        match forced.as_str() {
            "rustup" => return Self::rustup().or_else(|_| Self::install_rustup()),
            "debian" => return Self::debian().or_else(|_| Self::install_debian()),
            "" => {}
            other => bail!("{FORCE} is `{other}`; it may be `rustup` or `debian`"),
        }
        let found = Self::rustup()
            .or_else(|_| Self::debian())
            .or_else(|_| Self::install_rustup());
        found.or_else(|first| {
            announce(format_args!("rustup cannot ({first:#}); trying Debian's packages"));
            let packages = DEBIAN_PACKAGES.join(", ");
            Self::install_debian().with_context(|| {
                format!("no core library for {TARGET}: neither `rustup target add {TARGET}` ({first:#}) nor Debian's {packages}")
            })
        })
    }

    /// A cargo command for [`TARGET`], such as `build`.
    pub fn cargo(&self, subcommand: &str) -> Command {
        match self {
            Self::Rustup => cargo(subcommand, ["--target", TARGET]),
            Self::Debian { linker } => {
                let mut command = clean("/usr/bin/cargo");
                let path = env::var_os("PATH").unwrap_or_default();
                let path = env::split_paths(&path);
                if let Ok(path) =
                    env::join_paths([PathBuf::from("/usr/bin")].into_iter().chain(path))
                {
                    command.env("PATH", path);
                }
                command
                    .env("RUSTC", "/usr/bin/rustc")
                    // Lets a stable compiler accept the -Z below.
                    .env("RUSTC_BOOTSTRAP", "1")
                    .env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", linker)
                    .args([subcommand, "--target", TARGET, "-Z", "build-std=core,alloc"])
                    .args(["-Z", "build-std-features=compiler-builtins-mem"]);
                command
            }
        }
    }

    fn rustup() -> Result<Self> {
        let library =
            output_of(clean("rustc").args(["--print", "target-libdir", "--target", TARGET]))?;
        let entries = Path::new(&library)
            .read_dir()
            .with_context(|| format!("no {library}"))?;
        let has_core = entries
            .flatten()
            .any(|entry| entry.file_name().to_string_lossy().starts_with("libcore-"));
        ensure!(has_core, "no core library in {library}");
        Ok(Self::Rustup)
    }

    fn install_rustup() -> Result<Self> {
        announce(format_args!(
            "rustup target add {TARGET}, which may take a minute"
        ));
        add_target(TARGET)?;
        Self::rustup()
    }

    fn debian() -> Result<Self> {
        ensure!(Path::new("/usr/bin/cargo").exists(), "no /usr/bin/cargo");
        let version = output_of(clean("/usr/bin/rustc").arg("--version"))?;
        let is_new = parse_version(&version).is_some_and(|version| version >= OLDEST);
        ensure!(
            is_new,
            "/usr/bin/rustc is `{version}`, 1.88 or newer is needed"
        );
        let sysroot = output_of(clean("/usr/bin/rustc").args(["--print", "sysroot"]))?;
        let core = Path::new(&sysroot).join("lib/rustlib/src/rust/library/core/Cargo.toml");
        ensure!(core.exists(), "no sources of the core library in {sysroot}");
        Ok(Self::Debian { linker: linker()? })
    }

    fn install_debian() -> Result<Self> {
        if linker().is_err() {
            install::debian(&["lld"])?;
        }
        if let Ok(found) = Self::debian() {
            return Ok(found);
        }
        install::debian(&DEBIAN_PACKAGES)?;
        Self::debian()
    }
}

/// Has rustup fetch a target's core library, if missing. Tries once: where downloads are not
/// allowed, a retry would fail too.
pub fn add_target(target: &str) -> Result<()> {
    let rustup =
        find("rustup").with_context(|| format!("{target} comes with rustup, which is not here"))?;
    let mut add = clean(rustup);
    add.env("RUSTUP_MAX_RETRIES", "1");
    output_of(add.args(["--quiet", "target", "add", target])).map(drop)
}

/// Parses `rustc 1.96.0 (...)` as (1, 96).
fn parse_version(text: &str) -> Option<(u32, u32)> {
    let mut numbers = text.split_whitespace().nth(1)?.split('.').map(str::parse);
    Some((numbers.next()?.ok()?, numbers.next()?.ok()?))
}

/// Returns rust-lld from the rustup toolchain, or else LLVM's own.
fn linker() -> Result<PathBuf> {
    let sysroots = ["rustc", "/usr/bin/rustc"]
        .map(|rustc| output_of(clean(rustc).args(["--print", "sysroot"])));
    let libraries = sysroots
        .into_iter()
        .flatten()
        .map(|root| Path::new(&root).join("lib/rustlib"));
    let hosts = libraries
        .filter_map(|library| library.read_dir().ok())
        .flatten()
        .flatten();
    let mut linkers = hosts.map(|host| host.path().join("bin/rust-lld"));
    let with_toolchain = linkers.find(|path| path.is_file());
    let found = with_toolchain
        .or_else(|| find("rust-lld"))
        .or_else(|| find("ld.lld"));
    found.context("no linker for Arm (rust-lld or ld.lld)")
}

#[test]
fn versions_are_read() {
    for (text, version) in [
        ("rustc 1.96.0 (ac68faa20 2026-05-25)", Some((1, 96))),
        ("rustc 1.88.0-nightly", Some((1, 88))),
        ("command not found", None),
    ] {
        assert_eq!(parse_version(text), version, "{text}");
    }
}
