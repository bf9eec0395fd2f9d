//! A board's serial line, reopened after the board was unplugged.

use super::list::{Ports, Wanted, with_serial_number};
use super::system::BYTE_S;
use crate::feed::{FeedEvent, Source};
use anyhow::{Context, Result, anyhow};
use std::io::{self, ErrorKind, Read, Write};
use std::time::{Duration, Instant};

/// Interval between two searches for an unplugged board.
pub(super) const LOOK_EVERY: Duration = Duration::from_millis(200);

pub struct Link<P: Ports> {
    ports: P,
    /// Name of the board's current or last port.
    name: String,
    /// USB serial number of the board, if no other port has it.
    usb_serial: Option<String>,
    line: Option<P::SerialLine>,
    /// True if the connection has not been reported yet.
    is_new: bool,
    looked: Instant,
}

impl<P: Ports> Link<P> {
    /// Opens a board that is plugged in. If the board is unplugged later, the link waits for it.
    pub fn open(ports: P, wanted: Wanted) -> Result<Self> {
        let (name, usb_serial) = wanted.find(&ports)?;
        let line = ports.open(&name).map_err(|error| match error.kind() {
            ErrorKind::PermissionDenied => {
                anyhow!("{name}: {error}; on Linux join the group that owns it, mostly dialout")
            }
            _ => anyhow!("{name}: {error}"),
        })?;
        Ok(Self {
            ports,
            name,
            usb_serial,
            line: Some(line),
            is_new: true,
            looked: Instant::now(),
        })
    }

    fn read(&mut self, max: Duration) -> Option<FeedEvent<Vec<u8>>> {
        let mut bytes = [0; 4096];
        let line = self.line.as_mut()?;
        self.ports.wait_at_most(line, max);
        let error = match line.read(&mut bytes) {
            // The other end has hung up.
            Ok(0) => ErrorKind::UnexpectedEof.into(),
            Ok(length) => return Some(FeedEvent::Data(bytes[..length].to_vec())),
            Err(error) => error,
        };
        if matches!(
            error.kind(),
            ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
        ) {
            return None;
        }
        // Close the line at once: while it is open, Linux gives a returning device a new name.
        self.line = None;
        self.looked = Instant::now();
        Some(FeedEvent::Disconnected(
            self.name.clone(),
            error.to_string(),
        ))
    }

    /// Opens the board if it is back.
    fn look(&mut self) {
        self.looked = Instant::now();
        let name = match &self.usb_serial {
            None => Some(self.name.clone()),
            Some(number) => {
                let found = self.ports.list().unwrap_or_default();
                let mut fitting = with_serial_number(&found, number);
                let first = fitting.next();
                // If two ports have the number, it does not identify the board.
                first
                    .filter(|_| fitting.next().is_none())
                    .map(|one| one.name.clone())
            }
        };
        // A failure to open is not reported: the system may still be setting the port up.
        if let Some(name) = name
            && let Ok(line) = self.ports.open(&name)
        {
            (self.line, self.name, self.is_new) = (Some(line), name, true);
        }
    }
}

impl<P: Ports> Source for Link<P> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn next(&mut self, max: Duration) -> Result<Option<FeedEvent<Vec<u8>>>> {
        let begun = Instant::now();
        loop {
            if std::mem::take(&mut self.is_new) {
                return Ok(Some(FeedEvent::Connected(self.name.clone())));
            }
            let left = max.saturating_sub(begun.elapsed());
            if self.line.is_some() {
                if let Some(event) = self.read(left) {
                    return Ok(Some(event));
                }
            } else if self.looked.elapsed() >= LOOK_EVERY {
                self.look();
            } else {
                std::thread::sleep(left.min(LOOK_EVERY - self.looked.elapsed().min(LOOK_EVERY)));
            }
            if left.is_zero() && !self.is_new {
                return Ok(None);
            }
        }
    }

    fn byte_s(&self) -> f64 {
        BYTE_S
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let name = || self.name.clone();
        let line = self
            .line
            .as_mut()
            .ok_or(io::Error::from(ErrorKind::NotConnected))
            .with_context(name)?;
        line.write_all(bytes)
            .and_then(|()| line.flush())
            .with_context(name)
    }
}
