//! `results`: runs the campaigns of `lab` in the Python package's environment.

use crate::python;
use crate::tools::{announce, clean, run};
use anyhow::{Result, ensure};

/// Topics: scripts in `lab`.
pub const TOPICS: [&str; 7] = [
    "trade", "choices", "noise", "touch", "real", "boards", "papers",
];

/// Runs the campaigns, all or one. With `is_short` each takes a twentieth of the windows and fails
/// if a requirement is missed by more than its statistical error. Without PyPI, runs none: fails,
/// or with `is_short` prints the reason.
pub fn measure(topic: Option<&str>, is_short: bool) -> Result<()> {
    let python = python::environment()?;
    if !python::install(&python, "lab/requirements.txt")? {
        ensure!(
            is_short,
            "PyPI cannot be reached, and lab/requirements.txt is not installed"
        );
        println!(
            "not run: the short campaigns of lab. PyPI cannot be reached, and lab/requirements.txt is not installed"
        );
        return Ok(());
    }
    let python = python::build()?;
    if is_short {
        announce("lab/tests");
        run(clean(&python).args(["-m", "pytest", "--quiet", "lab/tests"]))?;
    }
    for one in TOPICS
        .into_iter()
        .filter(|one| topic.is_none_or(|topic| topic == *one))
    {
        announce(format_args!("lab/{one}.py"));
        let mut campaign = clean(&python);
        campaign.arg(format!("lab/{one}.py"));
        // The package fits on all cores; NumPy's threads would only wait.
        campaign.env("OPENBLAS_NUM_THREADS", "1");
        campaign.args(is_short.then_some("--short"));
        run(&mut campaign)?;
    }
    Ok(())
}
