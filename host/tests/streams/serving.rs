//! `serve` as a child process.

use crate::common;
use crate::serial_board::SerialBoard;
use rustix::process::{Pid, Signal, kill_process};
use std::io::Read;
use std::process::{Child, Stdio};

pub struct Serving(Child);

impl Serving {
    /// Starts `serve` with one finger, f0, at this board.
    pub fn start(board: &SerialBoard, arguments: &[&str]) -> Self {
        let child = common::ridgetone()
            .args(["serve", &format!("--finger=f0={}", board.name)])
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn();
        Self(child.expect("the command runs"))
    }

    /// Starts `serve` with one finger, f0, and publishes to a broker at this port.
    pub fn publish(board: &SerialBoard, port: u16) -> Self {
        Self::start(board, &["--mqtt", &format!("mqtt://127.0.0.1:{port}")])
    }

    /// Interrupts the command as Ctrl-C does, checks its exit status and returns its report.
    pub fn interrupt(mut self) -> String {
        let child = &mut self.0;
        let pid = Pid::from_raw(child.id() as i32).expect("a process");
        kill_process(pid, Signal::INT).expect("interrupted");
        let (mut report, mut stderr) = (String::new(), child.stderr.take().expect("a pipe"));
        stderr.read_to_string(&mut report).expect("UTF-8");
        assert!(child.wait().expect("ended").success(), "{report}");
        report
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
