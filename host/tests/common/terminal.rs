//! A pseudo-terminal, used as a board's line or as a user's screen.
#![allow(dead_code, reason = "every test file uses a part of it")]

use rustix::fs::{Mode, OFlags, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};
use std::fs::File;
use std::io::{Read, Write};
use std::num::NonZero;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(60);

/// The test's end of a pseudo-terminal, and everything read from it.
pub struct Terminal {
    end: File,
    /// Path at which the far end can be opened.
    pub name: String,
    received: Vec<u8>,
    screen: vt100::Parser,
}

impl Terminal {
    pub fn new(columns: u16, rows: u16) -> Self {
        let end = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)
            .expect("a terminal");
        grantpt(&end).expect("granted");
        unlockpt(&end).expect("unlocked");
        let size = Winsize {
            ws_col: columns,
            ws_row: rows,
            ws_xpixel: 0,
            ws_ypixel: 0,
        };
        tcsetwinsize(&end, size).expect("a size");
        let name = ptsname(&end, Vec::new())
            .expect("a name")
            .into_string()
            .expect("ASCII");
        let some = |size| NonZero::new(size).expect("a size");
        let screen = vt100::Parser::new(some(rows), some(columns), 0);
        Self {
            end: end.into(),
            name,
            received: Vec::new(),
            screen,
        }
    }

    /// Opens the far end, for a child process.
    pub fn other_end(&self) -> File {
        open(
            self.name.as_str(),
            OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC,
            Mode::empty(),
        )
        .expect("an end")
        .into()
    }

    pub fn into_file(self) -> File {
        self.end
    }

    pub fn send(&mut self, bytes: &[u8]) {
        self.end.write_all(bytes).expect("written");
    }

    pub fn read_until(&mut self, part: &str) {
        let begun = Instant::now();
        while !self.shows(part) {
            assert!(
                begun.elapsed() < PATIENCE,
                "{part:?} does not come:\n{}",
                self.screen.screen().contents()
            );
            self.read();
        }
    }

    pub fn shows(&self, part: &str) -> bool {
        self.screen.screen().contents().contains(part)
    }

    pub fn screen(&self) -> &vt100::Screen {
        self.screen.screen()
    }

    fn read(&mut self) -> bool {
        let mut bytes = [0; 65_536];
        match self.end.read(&mut bytes) {
            Ok(length) if length > 0 => {
                self.received.extend_from_slice(&bytes[..length]);
                self.screen.process(&bytes[..length]);
                true
            }
            // The far end is closed.
            _ => false,
        }
    }

    /// Reads to the end, and returns all bytes since the beginning.
    pub fn read_to_end(&mut self) -> String {
        while self.read() {}
        String::from_utf8_lossy(&self.received).into_owned()
    }
}
