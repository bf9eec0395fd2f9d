//! Builds the Python package as a wheel for any Linux on this processor, with embedded firmware
//! images.

use super::command::{EMBEDDED, Made, check_embedded, images};
use super::empty_root::EmptyRoot;
use crate::python;
use crate::tools::{announce, clean, create, output_of, read, remove, root, run, target_dir};
use anyhow::{Context, Result, ensure};
use std::env;
use std::env::consts::OS;
use std::path::{Path, PathBuf};

/// PyPI packages that build and check a wheel.
const TOOLS: &str = "xtask/src/release/wheel-requirements.txt";

/// Copies Python itself into the empty root directory.
const COPY_PYTHON: &str = "xtask/src/release/bare_python.py";

/// Auditwheel's name for the oldest supported glibc, 2.17, and the tag in the file name.
const OLDEST: &str = "manylinux2014";
const TAG: &str = "manylinux_2_17_";

const TONE_HZ: f64 = 43.3;

/// Builds the wheel, checks that it contains the images and works with an old glibc, and tries it
/// in an empty root directory if possible.
pub fn make() -> Result<Made> {
    if OS != "linux" {
        return Ok(Made::Missing(format!(
            "Python wheel: {OLDEST} is for Linux; on {OS} pip install ./host/python builds one"
        )));
    }
    let python = python::environment()?;
    if !python::install(&python, TOOLS)? {
        return Ok(Made::Missing(format!(
            "Python wheel: PyPI cannot be reached, and {TOOLS} is not installed"
        )));
    }
    let path = build(&python)?;
    let unpacked = target_dir().join("wheel/unpacked");
    let mut unpack = clean(&python);
    unpack.args(["-m", "zipfile", "-e"]).arg(&path);
    run(unpack.arg(&unpacked))?;
    check_embedded(&read(&unpacked.join("ridgetone/_ridgetone.abi3.so"))?).context("the wheel")?;
    let verdict = output_of(clean(&python).args(["-m", "auditwheel", "show"]).arg(&path))?;
    announce(&verdict);
    ensure!(
        verdict.contains(TAG),
        "auditwheel does not find it {TAG}..."
    );
    run_alone(&python, &path)?;
    let name = path.file_name().context("a wheel without a name")?;
    let name = name.to_string_lossy().into_owned();
    Ok(Made::File { name, path })
}

/// Builds the wheel with maturin. Zig links it for an old glibc.
fn build(python: &Path) -> Result<PathBuf> {
    announce("building the Python wheel: a few minutes the first time");
    let folder = target_dir().join("wheel");
    remove(&folder)?;
    create(&folder)?;
    let beside = python.parent().context("no folder of the interpreter")?;
    let path = env::var_os("PATH").unwrap_or_default();
    let path = env::join_paths(
        [beside.to_owned()]
            .into_iter()
            .chain(env::split_paths(&path)),
    )?;
    let mut maturin = clean(python);
    maturin.args(["-m", "maturin", "build", "--quiet", "--release", "--zig"]);
    maturin
        .args(["--compatibility", OLDEST, "--out"])
        .arg(&folder);
    maturin
        .arg("--manifest-path")
        .arg(root().join("host/python/Cargo.toml"));
    maturin.env("RIDGETONE_IMAGES", images()).env("PATH", path);
    run(&mut maturin)?;
    let made = folder.read_dir()?.flatten().map(|entry| entry.path());
    let mut wheels = made.filter(|path| path.extension().is_some_and(|end| end == "whl"));
    let wheel = wheels.next().context("maturin made no wheel")?;
    ensure!(wheels.next().is_none(), "maturin made more than one wheel");
    Ok(wheel)
}

/// Fits a known tone and emulates a board in a root directory that contains only Python, NumPy and
/// the wheel.
fn run_alone(python: &Path, wheel: &Path) -> Result<()> {
    let Some(root) = EmptyRoot::create()? else {
        return Ok(());
    };
    announce("`import ridgetone` in an empty root directory");
    let packages = root.folder().join("packages");
    let mut pip = clean(python);
    pip.args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
    ]);
    run(pip.arg("--target").arg(&packages).arg(wheel))?;
    let mut copy = clean(python);
    run(copy.arg(COPY_PYTHON).arg(root.folder()).arg(&packages))?;
    let boards = EMBEDDED.map(|board| board.image().name);
    let program = format!(
        "import numpy, ridgetone
t_s = numpy.arange(2000) / 1000
fit = ridgetone.fit(numpy.sin(2 * numpy.pi * {TONE_HZ} * t_s), rate_hz=1000)
assert fit.status == 'good' and abs(fit.frequency_hz - {TONE_HZ}) < 0.001, fit
for board in {boards:?}:
    with ridgetone.live('emulated', once=True, pace=0, elf=board) as events:
        assert any(event.type == 'estimate' for event in events), board"
    );
    let mut trial = root.command("/python");
    trial.env("PYTHONPATH", "/packages");
    output_of(trial.args(["-c", &program]))?;
    root.remove()
}
