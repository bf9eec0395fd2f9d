//! Tests the messages of `view` to its pages, and its server. The page in a browser is tested in
//! `tests/page`.
#![cfg(target_os = "linux")]

#[path = "common/board_recordings.rs"]
mod board_recordings;
mod common;
#[path = "view/served.rs"]
mod served;
#[path = "view/served_runs.rs"]
mod served_runs;
#[path = "view/updates.rs"]
mod updates;

use board_recordings::{packets, recorded};
use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};

/// `ridgetone view`, at its default port or a free one.
struct View {
    child: Child,
    /// Address of the page, such as `http://127.0.0.1:34567/`.
    url: String,
}

impl View {
    fn start(arguments: &[&str]) -> Self {
        Self::with(arguments, &[])
    }

    /// Starts the command with additional environment variables.
    fn with(arguments: &[&str], environment: &[(&str, &str)]) -> Self {
        let mut child = common::ridgetone()
            .arg("view")
            .args(arguments)
            .envs(environment.iter().copied())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command runs");
        let stdout = child.stdout.take().expect("a pipe");
        let mut url = String::new();
        BufReader::new(stdout).read_line(&mut url).expect("a line");
        Self {
            child,
            url: url.trim().to_owned(),
        }
    }

    fn address(&self) -> &str {
        self.url.trim_start_matches("http://").trim_end_matches('/')
    }
}

impl Drop for View {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
