//! Prints the URL of a page, and opens the page in the browser on request.

use super::server::Server;
use crate::note;
use crate::output;
use anyhow::Result;
use std::process::{Command, Stdio};

pub fn announce(server: &Server, open: bool) -> Result<()> {
    let url = format!("http://{}/", server.address);
    output::line(&url)?;
    if open && let Err(error) = browse(&url) {
        note!("no browser was opened ({error}): open {url} yourself");
    }
    Ok(())
}

fn browse(url: &str) -> std::io::Result<()> {
    let (program, arguments): (&str, &[&str]) = match std::env::consts::OS {
        "windows" => ("rundll32", &["url.dll,FileProtocolHandler"]),
        "macos" => ("open", &[]),
        _ => ("xdg-open", &[]),
    };
    let mut command = Command::new(program);
    command
        .args(arguments)
        .arg(url)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command
        .spawn()
        .map(drop)
        .map_err(|error| std::io::Error::new(error.kind(), format!("{program}: {error}")))
}
