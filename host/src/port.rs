//! A board on a serial line that may be unplugged: opened by name or by its USB serial number, and picked up again under
//! whatever name it comes back.

mod system;
#[cfg(all(test, target_os = "linux"))]
mod tests;

pub use system::{BAUD, System};

use crate::feed::{Said, Source};
use anyhow::{Context, Result};
use serde::Serialize;
use std::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::time::{Duration, Instant};

/// How often an unplugged board is looked for.
const LOOK_EVERY: Duration = Duration::from_millis(200);

/// A serial port of this computer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Found {
    /// What it is opened by, such as `/dev/ttyUSB0` or `COM3`.
    pub name: String,
    /// What its plug says, if it is one of USB.
    pub usb: Option<Usb>,
}

/// What a USB device says of itself.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Usb {
    /// Serial number, by which it is known again under another name. Many cheap adapters have none.
    pub serial_number: Option<String>,
    /// Name of the product.
    pub product: Option<String>,
    /// Number of the vendor.
    pub vendor_id: u16,
    /// The vendor's number of the product.
    pub product_id: u16,
}

impl Found {
    fn serial_number(&self) -> Option<&str> {
        self.usb.as_ref()?.serial_number.as_deref()
    }
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.name)?;
        let Some(usb) = &self.usb else { return Ok(()) };
        let product = usb.product.as_deref().unwrap_or("USB");
        write!(f, " ({product}, serial number {})", usb.serial_number.as_deref().unwrap_or("none"))
    }
}

/// The serial ports of a computer; tests have their own, to unplug.
pub trait Ports {
    /// An open port. A read waits a moment at most and fails with `TimedOut` if nothing came.
    type Line: Read + Write;

    /// Those that are plugged in.
    ///
    /// # Errors
    /// Those of the system.
    fn list(&self) -> io::Result<Vec<Found>>;

    /// Opens one.
    ///
    /// # Errors
    /// Those of the system: it is gone, in use, or not ours to open.
    fn open(&self, name: &str) -> io::Result<Self::Line>;
}

/// Which board is meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// The one at this port. If its USB serial number is the only one of its kind it is known by that from then on.
    Name(String),
    /// The one with this USB serial number.
    UsbSerial(String),
    /// The only one that is there.
    Only,
}

/// There is no such board, or it cannot be opened.
#[derive(Debug)]
pub enum PortError {
    /// The ports cannot be listed.
    List(io::Error),
    /// No port has this USB serial number; these are there.
    NotThere(String, Vec<Found>),
    /// More than one port has it: one has to be chosen by its name.
    Several(String, Vec<Found>),
    /// There is no port that it could be at.
    None,
    /// There is more than one port that it could be at.
    Which(Vec<Found>),
    /// It is there, but cannot be opened.
    Open(String, io::Error),
}

impl fmt::Display for PortError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = |found: &[Found]| match found {
            [] => "there is no serial port".to_owned(),
            found => format!("there are {}", found.iter().map(Found::to_string).collect::<Vec<_>>().join(", ")),
        };
        match self {
            Self::List(error) => write!(f, "the serial ports cannot be listed ({error}): name one with --port"),
            Self::NotThere(number, found) => {
                write!(f, "no serial port has the USB serial number {number}: {}", names(found))
            }
            Self::Several(number, found) => {
                write!(f, "more than one port has the USB serial number {number}, choose with --port: {}", names(found))
            }
            Self::None => write!(
                f,
                "there is no USB serial port: plug the board in, or use --emulated; --port NAME opens any other"
            ),
            Self::Which(found) => {
                write!(
                    f,
                    "there is more than one USB serial port, choose with --port or --usb-serial: {}",
                    names(found)
                )
            }
            Self::Open(name, error) if error.kind() == ErrorKind::PermissionDenied => {
                write!(f, "{name}: {error}; on Linux join the group that owns it, mostly dialout")
            }
            Self::Open(name, error) => write!(f, "{name}: {error}"),
        }
    }
}

impl std::error::Error for PortError {}

/// A board's line.
pub struct Link<P: Ports> {
    ports: P,
    /// Name of the port that it is at, or was.
    name: String,
    /// By which it is known again, if it has one that no other has.
    usb_serial: Option<String>,
    line: Option<P::Line>,
    /// That it is there was not said yet.
    is_new: bool,
    looked: Instant,
}

impl<P: Ports> Link<P> {
    /// Opens a board that is there. What is unplugged later is waited for.
    ///
    /// # Errors
    /// It is not there, or cannot be opened.
    pub fn open(ports: P, wanted: Wanted) -> Result<Self, PortError> {
        let (name, usb_serial) = match wanted {
            // A port may have a name that no list has, and no list may be had: it is opened all the same.
            Wanted::Name(name) => {
                let usb_serial = serial_number_of(&name, &ports.list().unwrap_or_default());
                (name, usb_serial)
            }
            Wanted::Only => {
                let found = ports.list().map_err(PortError::List)?;
                let name = only(&found)?.name.clone();
                let usb_serial = serial_number_of(&name, &found);
                (name, usb_serial)
            }
            Wanted::UsbSerial(number) => {
                let found = ports.list().map_err(PortError::List)?;
                let fitting: Vec<Found> = with_serial_number(&found, &number).cloned().collect();
                match fitting.as_slice() {
                    [] => return Err(PortError::NotThere(number, found)),
                    [one] => (one.name.clone(), Some(number)),
                    _ => return Err(PortError::Several(number, fitting)),
                }
            }
        };
        let line = ports.open(&name).map_err(|error| PortError::Open(name.clone(), error))?;
        Ok(Self { ports, name, usb_serial, line: Some(line), is_new: true, looked: Instant::now() })
    }

    fn read(&mut self) -> Option<Said> {
        let line = self.line.as_mut()?;
        let mut bytes = [0; 4096];
        let error = match line.read(&mut bytes) {
            // The other end has hung up.
            Ok(0) => ErrorKind::UnexpectedEof.into(),
            Ok(length) => return Some(Said::Bytes(bytes[..length].to_vec())),
            Err(error) => error,
        };
        if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted) {
            return None;
        }
        // Closed at once: as long as it is open Linux gives the device another name when it comes back.
        self.line = None;
        self.looked = Instant::now();
        Some(Said::Went(self.name.clone(), error.to_string()))
    }

    /// Looks whether the board has come back.
    fn look(&mut self) {
        self.looked = Instant::now();
        let name = match &self.usb_serial {
            None => Some(self.name.clone()),
            Some(number) => {
                let found = self.ports.list().unwrap_or_default();
                let mut fitting = with_serial_number(&found, number);
                let first = fitting.next();
                // Of two with one number none is known to be the one.
                first.filter(|_| fitting.next().is_none()).map(|one| one.name.clone())
            }
        };
        // That it cannot be opened yet is nothing to tell: the system may still be setting it up.
        let Some((name, line)) = name.and_then(|name| Some((name.clone(), self.ports.open(&name).ok()?))) else {
            return;
        };
        (self.line, self.name, self.is_new) = (Some(line), name, true);
    }
}

impl<P: Ports> Source for Link<P> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn next(&mut self, most: Duration) -> Result<Option<Said>> {
        let begun = Instant::now();
        loop {
            if std::mem::take(&mut self.is_new) {
                return Ok(Some(Said::Came(self.name.clone())));
            }
            let left = most.saturating_sub(begun.elapsed());
            if self.line.is_some() {
                if let Some(said) = self.read() {
                    return Ok(Some(said));
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

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let name = || self.name.clone();
        let line = self.line.as_mut().ok_or(io::Error::from(ErrorKind::NotConnected)).with_context(name)?;
        line.write_all(bytes).and_then(|()| line.flush()).with_context(name)?;
        Ok(())
    }
}

/// The port that a board must be at: the only one of USB, or the only one at all.
///
/// # Errors
/// There is none, or more than one.
fn only(found: &[Found]) -> Result<&Found, PortError> {
    let usb: Vec<&Found> = found.iter().filter(|port| port.usb.is_some()).collect();
    match usb.as_slice() {
        [one] => Ok(one),
        [] => Err(PortError::None),
        several => Err(PortError::Which(several.iter().copied().cloned().collect())),
    }
}

fn with_serial_number<'a>(found: &'a [Found], number: &'a str) -> impl Iterator<Item = &'a Found> {
    found.iter().filter(move |port| port.serial_number() == Some(number))
}

/// USB serial number of the port with this name, if no other port has the same.
fn serial_number_of(name: &str, found: &[Found]) -> Option<String> {
    // The name may be a link, such as those in /dev/serial/by-id.
    let path = std::fs::canonicalize(name).ok();
    let is_it = |port: &&Found| port.name == name || path.as_deref() == Some(port.name.as_ref());
    let number = found.iter().find(is_it)?.serial_number()?;
    (with_serial_number(found, number).count() == 1).then(|| number.to_owned())
}
