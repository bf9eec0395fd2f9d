//! The serial ports of this computer.

use super::list::{Found, Ports, Usb};
use super::users::in_words;
use serialport::{SerialPort, SerialPortType};
use std::io;
use std::time::Duration;

/// Speed of the telemetry line, bits per second (the firmware's is in `src/board/serial_line.rs`);
/// 8 data bits, no parity, 1 stop bit.
pub const BAUD: u32 = 921_600;

/// Duration of a byte on the telemetry line, including start and stop bit, seconds.
pub const BYTE_S: f64 = 10.0 / BAUD as f64;

/// Maximum time that a read waits.
const READ_WAIT: Duration = Duration::from_millis(100);

/// Directory in which Linux lists its terminals.
#[cfg(target_os = "linux")]
pub(super) const TERMINALS: &str = "/sys/class/tty";

/// Serial ports of this computer, opened at 921600 baud.
#[derive(Clone, Copy, Debug, Default)]
pub struct System;

impl Ports for System {
    type SerialLine = Box<dyn SerialPort>;

    fn list(&self) -> io::Result<Vec<Found>> {
        // Without this directory, as in some containers, the library panics.
        #[cfg(target_os = "linux")]
        std::fs::read_dir(TERMINALS)
            .map_err(|error| io::Error::new(error.kind(), format!("{TERMINALS}: {error}")))?;
        let ports = serialport::available_ports()?;
        let mut found: Vec<Found> = ports
            .into_iter()
            .map(|port| Found {
                name: port.port_name,
                usb: match port.port_type {
                    SerialPortType::UsbPort(usb) => Some(Usb {
                        serial_number: usb.serial_number,
                        product: usb.product,
                        vendor_id: usb.vid,
                        product_id: usb.pid,
                    }),
                    _ => None,
                },
            })
            .collect();
        found.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(found)
    }

    fn open(&self, name: &str) -> io::Result<Self::SerialLine> {
        let port = serialport::new(name, BAUD).timeout(READ_WAIT).open();
        port.map_err(|error| in_words(name, error))
    }

    fn wait_at_most(&self, line: &mut Self::SerialLine, max: Duration) {
        // This should not fail; if it does, reads wait as long as before.
        let _ = line.set_timeout(max.min(READ_WAIT));
    }
}
