//! The serial ports of a computer, and the choice of the one with the board.

use anyhow::{Context, Error, Result, anyhow, bail};
use serde::Serialize;
use std::fmt;
use std::io::{self, Read, Write};
use std::time::Duration;

/// A serial port of this computer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Found {
    /// Name of the port, such as `/dev/ttyUSB0` or `COM3`.
    pub name: String,
    pub usb: Option<Usb>,
}

/// Description of a USB device.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Usb {
    /// Serial number, which identifies the device even if its port has a new name. Many cheap
    /// adapters have none.
    pub serial_number: Option<String>,
    pub product: Option<String>,
    pub vendor_id: u16,
    pub product_id: u16,
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.name)?;
        let Some(usb) = &self.usb else { return Ok(()) };
        let product = usb.product.as_deref().unwrap_or("USB");
        write!(
            f,
            " ({product}, serial number {})",
            usb.serial_number.as_deref().unwrap_or("none")
        )
    }
}

/// The serial ports of a computer. Tests implement this with ports that they can unplug.
pub trait Ports {
    /// Open port. A read waits only briefly, and fails with `TimedOut` if no byte arrives.
    type SerialLine: Read + Write;

    fn list(&self) -> io::Result<Vec<Found>>;

    fn open(&self, name: &str) -> io::Result<Self::SerialLine>;

    /// Limits the wait of the next reads to `most`, if the port supports that.
    fn wait_at_most(&self, _line: &mut Self::SerialLine, _max: Duration) {}
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// The board at this port. Once opened, it is identified by its USB serial number, if unique.
    Name(String),
    UsbSerial(String),
    Only,
}

impl Wanted {
    /// Selects a board by its port's name or USB serial number; with neither, the only board.
    pub fn new(port: Option<String>, usb_serial: Option<String>) -> Self {
        port.map(Self::Name)
            .or(usb_serial.map(Self::UsbSerial))
            .unwrap_or(Self::Only)
    }

    /// Returns the name of the board's port, and its USB serial number if no other port has it.
    pub(super) fn find(self, ports: &impl Ports) -> Result<(String, Option<String>)> {
        let list = || ports.list().map_err(list_error);
        match self {
            // The port is opened even if it is not listed, or if ports cannot be listed.
            Self::Name(name) => {
                let usb_serial = serial_number_of(&name, &ports.list().unwrap_or_default());
                Ok((name, usb_serial))
            }
            Self::Only => {
                let found = list()?;
                let name = only(&found)?.name.clone();
                let usb_serial = serial_number_of(&name, &found);
                Ok((name, usb_serial))
            }
            Self::UsbSerial(number) => {
                let found = list()?;
                let fitting: Vec<_> = with_serial_number(&found, &number).collect();
                match fitting.as_slice() {
                    [one] => Ok((one.name.clone(), Some(number))),
                    [] => bail!(
                        "no serial port has the USB serial number {number}: {}",
                        names(found.iter())
                    ),
                    _ => bail!(
                        "more than one port has the USB serial number {number}, choose with --port: {}",
                        names(fitting.into_iter())
                    ),
                }
            }
        }
    }
}

pub fn list_error(error: io::Error) -> Error {
    anyhow!("the serial ports cannot be listed ({error}): name one with --port")
}

fn names<'a>(found: impl Iterator<Item = &'a Found>) -> String {
    match found.map(Found::to_string).collect::<Vec<_>>().as_slice() {
        [] => "there is no serial port".to_owned(),
        names => format!("there are {}", names.join(", ")),
    }
}

/// Returns the only USB port, which must be the board's. Fails if there are none or several.
pub(super) fn only(found: &[Found]) -> Result<&Found> {
    let mut usb = found.iter().filter(|port| port.usb.is_some());
    let first = usb
        .next()
        .context("there is no USB serial port: plug the board in, or use --emulated; --port NAME opens any other")?;
    if usb.next().is_some() {
        let names = names(found.iter().filter(|port| port.usb.is_some()));
        bail!(
            "there is more than one USB serial port, choose with --port or --usb-serial: {names}"
        );
    }
    Ok(first)
}

pub(super) fn with_serial_number<'a>(
    found: &'a [Found],
    number: &'a str,
) -> impl Iterator<Item = &'a Found> {
    found
        .iter()
        .filter(move |port| serial_number(port) == Some(number))
}

fn serial_number(port: &Found) -> Option<&str> {
    port.usb.as_ref()?.serial_number.as_deref()
}

/// Returns the USB serial number of the port with this name, if no other port has it.
fn serial_number_of(name: &str, found: &[Found]) -> Option<String> {
    // The name may be a link, such as one in /dev/serial/by-id.
    let path = std::fs::canonicalize(name).ok();
    let is_it = |port: &&Found| port.name == name || path.as_deref() == Some(port.name.as_ref());
    let number = serial_number(found.iter().find(is_it)?)?;
    (with_serial_number(found, number).count() == 1).then(|| number.to_owned())
}
