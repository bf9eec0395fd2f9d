//! The SPI interface: command decoding, byte for byte.

use super::Ads1258;
use super::registers::{MUXDIF, MUXSG0, MUXSG1, REGISTERS, SPIRST, STAT, SYSRED};

/// State of the decoder within a frame.
#[derive(Clone, Copy, Debug, Default)]
enum State {
    /// After CS low or the time-out: a command or a direct read.
    #[default]
    FrameStart,
    /// After a finished command: another command may follow without toggling CS, but not a direct
    /// read.
    Command,
    /// Read by command: the result is latched at the command, so a DRDY edge does not change it.
    Data { bytes: [u8; 4], at: usize },
    /// Direct read: straight from the result register, which a DRDY edge replaces.
    Direct { at: usize },
    /// After a direct read, until CS goes high or the time-out: zeros.
    Spent,
    /// After a read by command without MUL, until CS goes high: not specified.
    Lost,
    /// Register read; it ends after address 09h.
    Read { address: u8, several: bool },
    /// Register write; it ends after address 09h.
    Write { address: u8, several: bool },
}

/// The decoder and the state of its time-out.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Interface {
    state: State,
    /// Start of the time-out: end of the latest byte, or the frame's first SCLK edge.
    idle_since_ns: Option<u64>,
}

impl Ads1258 {
    /// Transfers a CS frame at a single instant, in place: DIN bytes in, DOUT bytes out.
    pub fn transfer(&mut self, now_ns: u64, bytes: &mut [u8]) {
        self.select(now_ns);
        for byte in bytes {
            *byte = self.exchange(now_ns, now_ns, *byte);
        }
        self.deselect(now_ns);
    }

    /// Pulls CS low.
    pub fn select(&mut self, now_ns: u64) {
        self.advance_to(now_ns);
        self.interface = Interface::default();
    }

    /// Pulls CS high: the interface drops an unfinished command.
    pub fn deselect(&mut self, now_ns: u64) {
        self.select(now_ns);
    }

    /// Exchanges one byte within a frame: `din` in, DOUT out. The first SCLK edge is at
    /// `first_sclk_ns`, the last at `last_sclk_ns`; the byte acts at the first. The interface is
    /// reset if SCLK was idle for 4096 tCLK (SPIRST = 0) or 256 tCLK (SPIRST = 1) since the
    /// previous byte; or, with
    /// [`Options::timeout_from_frame_start`](super::Options::timeout_from_frame_start), if the
    /// frame began that long ago.
    pub fn exchange(&mut self, first_sclk_ns: u64, last_sclk_ns: u64, din: u8) -> u8 {
        self.advance_to(first_sclk_ns);
        let [din_errors, dout_errors] = self.faults.next();
        let din = din ^ din_errors;
        let dout = if self.faults.is_cut {
            0
        } else if self.reset_low || !self.is_powered(first_sclk_ns) {
            self.poison_byte()
        } else {
            self.time_out(first_sclk_ns);
            self.answer(din)
        };
        let is_first = self.interface.idle_since_ns.is_none();
        if is_first && self.options.timeout_from_frame_start {
            self.interface.idle_since_ns = Some(first_sclk_ns);
        } else if !self.options.timeout_from_frame_start {
            self.interface.idle_since_ns = Some(last_sclk_ns);
        }
        self.faults.on_dout(dout) ^ dout_errors
    }

    fn time_out(&mut self, now_ns: u64) {
        let limit_ns = self.clock.ns(if self.registers.bit(SPIRST) {
            256
        } else {
            4096
        });
        if self
            .interface
            .idle_since_ns
            .is_some_and(|since_ns| now_ns.saturating_sub(since_ns) >= limit_ns)
        {
            self.interface = Interface::default();
        }
    }

    fn answer(&mut self, din: u8) -> u8 {
        let (dout, next) = match self.interface.state {
            State::FrameStart => match din >> 5 {
                // C[2:0] = 000 and 111 select a direct read, not a command: its data come at once.
                0b000 | 0b111 => {
                    self.result_read_begins();
                    let at = if self.registers.bit(STAT) { 0 } else { 1 };
                    let dout = self.outcome.bytes()[at];
                    self.outcome.new = false;
                    (dout, State::Direct { at: at + 1 })
                }
                _ => self.command(din),
            },
            State::Command => self.command(din),
            State::Data { bytes, at } => (
                bytes[at],
                if at == 3 {
                    State::Command
                } else {
                    State::Data { bytes, at: at + 1 }
                },
            ),
            State::Direct { at } => (
                self.outcome.bytes()[at],
                if at == 3 {
                    State::Spent
                } else {
                    State::Direct { at: at + 1 }
                },
            ),
            State::Spent => (0, State::Spent),
            State::Lost => (self.poison_byte(), State::Lost),
            State::Read { address, several } => {
                let dout = self
                    .registers
                    .read(address)
                    .unwrap_or_else(|| self.poison_byte());
                (
                    dout,
                    State::Read {
                        address: address + 1,
                        several,
                    }
                    .or_end(address, several),
                )
            }
            State::Write { address, several } => {
                self.write_register(address, din);
                (
                    self.poison_byte(),
                    State::Write {
                        address: address + 1,
                        several,
                    }
                    .or_end(address, several),
                )
            }
        };
        self.interface.state = next;
        dout
    }

    fn command(&mut self, din: u8) -> (u8, State) {
        let (several, address) = (din & 0x10 != 0, din & 0x0F);
        let next = match din >> 5 {
            0b001 if several => {
                self.result_read_begins();
                let bytes = self.outcome.bytes();
                self.outcome.new = false;
                State::Data { bytes, at: 0 }
            }
            0b001 => {
                self.counters.odd_commands += 1;
                State::Lost
            }
            0b010 => State::Read { address, several },
            0b011 => State::Write { address, several },
            0b100 if !self.start && self.conversion.is_none() => {
                self.start_condition();
                State::Command
            }
            0b110 => {
                // The running conversion finishes with the settings it began with.
                self.registers.reset();
                self.last_chid = None;
                State::Command
            }
            _ => {
                self.counters.odd_commands += 1;
                State::Command
            }
        };
        (self.poison_byte(), next)
    }

    /// Raises DRDY at the first SCLK of a read and counts the result.
    fn result_read_begins(&mut self) {
        self.drdy_low = false;
        self.counters.read += u64::from(self.outcome.new);
    }

    fn write_register(&mut self, address: u8, value: u8) {
        if usize::from(address) >= REGISTERS {
            return;
        }
        self.counters.register_writes += 1;
        self.registers.write(address, value);
        // Writing the channel selection restarts the scan at its top, and starts a scan that had no
        // channel.
        if matches!(address, MUXDIF | MUXSG0 | MUXSG1 | SYSRED) {
            self.last_chid = None;
        }
        if self.start && self.conversion.is_none() {
            self.start_condition();
        }
    }
}

impl State {
    /// Stays in this state while more registers follow. The command ends after a single access, or
    /// after address 09h.
    fn or_end(self, address: u8, several: bool) -> Self {
        if several && usize::from(address) + 1 < REGISTERS {
            self
        } else {
            State::Command
        }
    }
}
