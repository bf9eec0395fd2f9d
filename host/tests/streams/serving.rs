//! `serve`, as a process.
#![allow(dead_code, reason = "every test file uses a part of it")]

use crate::common;
use crate::serial_board::SerialBoard;
use rustix::process::{Pid, Signal, kill_process};
use std::io::Read;
use std::process::{Child, Stdio};

pub struct Serving(Option<Child>);

impl Serving {
    /// Fingers f0, f1 and so on at these boards.
    pub fn start(boards: &[&SerialBoard], arguments: &[&str]) -> Self {
        Self::start_with(boards, arguments, &[])
    }

    /// Starts it with environment variables.
    pub fn start_with(
        boards: &[&SerialBoard],
        arguments: &[&str],
        variables: &[(&str, &str)],
    ) -> Self {
        let sources: Vec<&str> = boards.iter().map(|board| board.name.as_str()).collect();
        Self::of(&sources, arguments, variables)
    }

    /// Fingers f0, f1 and so on from these sources.
    pub fn of(sources: &[&str], arguments: &[&str], variables: &[(&str, &str)]) -> Self {
        let fingers = sources
            .iter()
            .enumerate()
            .map(|(number, source)| format!("--finger=f{number}={source}"));
        let mut command = common::ridgetone();
        command
            .arg("serve")
            .args(fingers)
            .args(arguments)
            .envs(variables.iter().copied());
        let child = command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn();
        Self(Some(child.expect("the command runs")))
    }

    pub fn id(&self) -> u32 {
        self.0.as_ref().expect("a child").id()
    }

    /// Interrupts it as Ctrl-C does; gives what it reported. It must end well.
    pub fn interrupt(mut self) -> String {
        let mut child = self.0.take().expect("a child");
        kill_process(
            Pid::from_raw(child.id() as i32).expect("a process"),
            Signal::INT,
        )
        .expect("interrupted");
        let mut report = String::new();
        child
            .stderr
            .take()
            .expect("a pipe")
            .read_to_string(&mut report)
            .expect("UTF-8");
        assert!(child.wait().expect("ended").success(), "{report}");
        report
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
