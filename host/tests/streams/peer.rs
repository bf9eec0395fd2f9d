//! A receiver by another author: a package for Python, in the environment that `cargo xtask
//! streams` makes. It prints what it receives as lines of JSON.

use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// The variable with the path of the environment's interpreter.
const PYTHON: &str = "RIDGETONE_PEERS";

/// Time without a line after which the test fails.
const SILENCE: Duration = Duration::from_secs(30);

pub struct Peer {
    child: Child,
    lines: Receiver<Value>,
}

impl Peer {
    /// Starts a script of `peers/`, and waits until it receives.
    pub fn start(script: &str, arguments: &[&str]) -> Self {
        let python = std::env::var_os(PYTHON)
            .unwrap_or_else(|| panic!("{PYTHON} is not set: run `cargo xtask streams`"));
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("tests/streams/peers")
            .join(script);
        let mut command = Command::new(python);
        let child = command
            .arg(path)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn();
        let mut child = child.expect("Python runs");
        let printed = BufReader::new(child.stdout.take().expect("a pipe")).lines();
        let (to_test, lines) = channel();
        std::thread::spawn(move || {
            for line in printed.map_while(Result::ok) {
                let value =
                    serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line}"));
                if to_test.send(value).is_err() {
                    return;
                }
            }
        });
        let peer = Self { child, lines };
        assert_eq!(peer.next()["ready"], true);
        peer
    }

    /// The next line.
    pub fn next(&self) -> Value {
        self.lines
            .recv_timeout(SILENCE)
            .expect("a line of the peer")
    }

    /// Lines until `count` of them have `field`; at most a minute.
    pub fn until(&self, field: &str, count: usize) -> Vec<Value> {
        let (begun, mut found) = (Instant::now(), Vec::new());
        while found
            .iter()
            .filter(|line: &&Value| line.get(field).is_some())
            .count()
            < count
        {
            assert!(
                begun.elapsed() < Duration::from_secs(60),
                "{} lines, not {count} with {field}",
                found.len()
            );
            found.push(self.next());
        }
        found
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
