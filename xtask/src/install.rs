//! Installs missing programs, where allowed.

use crate::tools::{announce, clean, find, output_of};
use anyhow::{Result, bail};
use std::process::Command;

/// Installs Debian packages, as root or through sudo if that needs no password.
pub fn debian(packages: &[&str]) -> Result<()> {
    let list = packages.join(" ");
    let Some(apt) = find("apt-get") else {
        bail!(
            "this is not Debian or Ubuntu; install what its packages `{list}` hold by your system's own means"
        );
    };
    let is_root = output_of(Command::new("id").arg("-u")).is_ok_and(|id| id == "0");
    let sudo_works =
        || find("sudo").is_some() && output_of(Command::new("sudo").args(["-n", "true"])).is_ok();
    if !is_root && !sudo_works() {
        bail!("no right to install packages; run: sudo apt-get install {list}");
    }
    let apt_get = |arguments: &[&str]| {
        let mut command = if is_root { clean(&apt) } else { clean("sudo") };
        if !is_root {
            command.arg("-n").arg(&apt);
        }
        command
            .env("DEBIAN_FRONTEND", "noninteractive")
            .args(arguments);
        output_of(&mut command)
    };
    let install = [&["install", "--yes", "--no-install-recommends"], packages].concat();
    announce(format_args!(
        "installing {list} with apt-get, which may take a minute"
    ));
    if apt_get(&install).is_err() {
        // The package lists may be missing or old.
        announce("fetching apt's package lists");
        apt_get(&["update", "--quiet"])?;
        apt_get(&install)?;
    }
    Ok(())
}
