//! The bridge between the emulated board and the simulated chip on the PC.
//!
//! On a board the firmware uses SPI and three pins. In the emulator the same transactions travel as
//! records through two FIFOs, each with its virtual time, so that the simulated chip advances
//! exactly as the real one would.
//!
//! A record is a fixed header and then `length` payload bytes. All numbers are little endian. Each
//! [`Request`] gets one [`Reply`] of the same payload length.

/// Longest payload of one record, in bytes: the longest SPI transaction of the driver fits.
pub const PAYLOAD_MAX: usize = 32;

/// Bytes of a [`Request`] header.
pub const REQUEST_BYTES: usize = 8;

/// Bytes of a [`Reply`] header.
pub const REPLY_BYTES: usize = 12;

/// No falling edge of DRDY follows, in [`Reply::next_drdy_us`].
pub const NEVER: u32 = u32::MAX;

/// What the emulated board does to the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Operation {
    /// Time passes; the reply has the state of DRDY.
    Poll = 0,
    /// One SPI transaction, CS low around the payload; the reply carries the bytes of DOUT.
    Transfer = 1,
    /// Drive START to `level`.
    Start = 2,
    /// Drive RESET to `level`.
    Reset = 3,
}

/// What the PC may make happen to the emulated board, for a test of how it recovers. The board
/// starts anew after each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Crash {
    /// A panic.
    Panic = 1,
    /// An undefined instruction: a HardFault.
    HardFault = 2,
    /// The stack overflows: a HardFault without a stack.
    StackOverflow = 3,
    /// Detection stands still until the watchdog resets the board.
    Hang = 4,
    /// A reset by software, without an error.
    Restart = 5,
}

impl Crash {
    /// Every one.
    pub const ALL: [Self; 5] = [
        Self::Panic,
        Self::HardFault,
        Self::StackOverflow,
        Self::Hang,
        Self::Restart,
    ];
}

/// From the emulated board to the PC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// What the board does.
    pub operation: Operation,
    /// Pin level for [`Operation::Start`] and [`Operation::Reset`].
    pub level: bool,
    /// Payload bytes that follow, at most [`PAYLOAD_MAX`].
    pub length: u8,
    /// Virtual time of the board's microsecond counter, wrapping.
    pub now_us: u32,
}

/// From the PC to the emulated board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reply {
    /// Level of DRDY after the operation: `true` without data (active low), and if the pin is
    /// stuck, which makes no edge.
    pub drdy_high: bool,
    /// The scene has ended: the firmware finishes, flushes its telemetry and stops the emulator.
    pub ended: bool,
    /// The telemetry line takes no more bytes: a cable that is blocked at its other end.
    pub line_blocked: bool,
    /// Payload bytes that follow: the request's own length.
    pub length: u8,
    /// What happens to the board now.
    pub crash: Option<Crash>,
    /// Board time of the latest falling edge of DRDY, microseconds, wrapping; zero before the
    /// first.
    pub drdy_us: u32,
    /// Microseconds from `now_us` to the next falling edge, or [`NEVER`].
    pub next_drdy_us: u32,
}

impl Request {
    /// The header's bytes.
    pub fn encode(&self) -> [u8; REQUEST_BYTES] {
        let mut bytes = [
            self.operation as u8,
            self.level as u8,
            self.length,
            0,
            0,
            0,
            0,
            0,
        ];
        bytes[4..].copy_from_slice(&self.now_us.to_le_bytes());
        bytes
    }

    /// Reads a header back; `None` if the operation is unknown or the payload too long.
    pub fn decode(b: &[u8; REQUEST_BYTES]) -> Option<Self> {
        let all = [
            Operation::Poll,
            Operation::Transfer,
            Operation::Start,
            Operation::Reset,
        ];
        let operation = *all.get(b[0] as usize)?;
        (b[2] as usize <= PAYLOAD_MAX).then_some(Self {
            operation,
            level: b[1] != 0,
            length: b[2],
            now_us: u32::from_le_bytes([b[4], b[5], b[6], b[7]]),
        })
    }
}

impl Reply {
    /// The header's bytes.
    pub fn encode(&self) -> [u8; REPLY_BYTES] {
        let mut bytes = [0; REPLY_BYTES];
        bytes[0] = self.drdy_high as u8 | (self.ended as u8) << 1 | (self.line_blocked as u8) << 2;
        bytes[1] = self.length;
        bytes[2] = self.crash.map_or(0, |crash| crash as u8);
        bytes[4..8].copy_from_slice(&self.drdy_us.to_le_bytes());
        bytes[8..].copy_from_slice(&self.next_drdy_us.to_le_bytes());
        bytes
    }

    /// Reads a header back; `None` if the payload is too long or the crash unknown.
    pub fn decode(b: &[u8; REPLY_BYTES]) -> Option<Self> {
        let crash = match b[2] {
            0 => None,
            number => Some(*Crash::ALL.iter().find(|crash| **crash as u8 == number)?),
        };
        (b[1] as usize <= PAYLOAD_MAX).then_some(Self {
            drdy_high: b[0] & 1 != 0,
            ended: b[0] & 2 != 0,
            line_blocked: b[0] & 4 != 0,
            length: b[1],
            crash,
            drdy_us: u32::from_le_bytes([b[4], b[5], b[6], b[7]]),
            next_drdy_us: u32::from_le_bytes([b[8], b[9], b[10], b[11]]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_survive_the_wire() {
        let request = Request {
            operation: Operation::Transfer,
            level: true,
            length: 5,
            now_us: 0xfedc_ba98,
        };
        assert_eq!(Request::decode(&request.encode()), Some(request));
        for crash in Crash::ALL.map(Some).into_iter().chain([None]) {
            let (drdy_high, ended, line_blocked) = (true, true, true);
            let (length, drdy_us, next_drdy_us) = (5, 7, NEVER);
            let reply = Reply {
                drdy_high,
                ended,
                line_blocked,
                length,
                crash,
                drdy_us,
                next_drdy_us,
            };
            assert_eq!(Reply::decode(&reply.encode()), Some(reply));
        }
    }

    #[test]
    fn damaged_headers_are_refused() {
        assert_eq!(Request::decode(&[9, 0, 0, 0, 0, 0, 0, 0]), None);
        assert_eq!(Request::decode(&[1, 0, 200, 0, 0, 0, 0, 0]), None);
        let mut reply = [0; REPLY_BYTES];
        reply[1] = 200;
        assert_eq!(Reply::decode(&reply), None);
        (reply[1], reply[2]) = (5, 6);
        assert_eq!(Reply::decode(&reply), None);
    }
}
