//! An ADS131M08 in virtual time: eight inputs sampled at once, frames of ten 24-bit words, a status
//! word first, a CRC last (SBAS950B).
//!
//! Left out: other word lengths, CRC on DIN, global chop, phase and gain settings, the filter's
//! settling, the time-out of a frame, DRDY as a pulse. The datasheet does not say what a second
//! read of the same data gives: here the same words with their DRDY bits clear.

use crate::scene::Scene;
use core::convert::Infallible;
use embedded_hal::delay::DelayNs;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Channels.
pub const CHANNELS: usize = 8;
/// Words of a frame: response, channels, CRC.
const WORDS: usize = CHANNELS + 2;
/// Bytes of a word after reset.
const WORD_BYTES: usize = 3;
/// Full scale at gain 1, volts.
const FULL_SCALE_V: f64 = 1.2;

/// Registers with their values after a reset: ID, STATUS, MODE, CLOCK.
const RESET: [u16; 4] = [0x2800, 0x0500, 0x0510, 0xff0e];
const STATUS: usize = 1;
const MODE: usize = 2;
const CLOCK: usize = 3;
/// RESET in STATUS and MODE.
const HAS_RESET: u16 = 1 << 10;

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ads131m08Fault {
    /// One bit of each of so many frames is wrong on DOUT.
    Damaged(u32),
    /// The supply dropped for a moment: registers as after a reset.
    BrownOut,
    /// Unplugged, or plugged in again: DOUT floats high, DRDY stays high.
    Absent(bool),
}

/// A handle to the chip and to its virtual clock. Clones share both.
#[derive(Clone)]
pub struct Ads131m08(Arc<Mutex<Chip>>);

struct Chip {
    scene: Box<dyn Scene>,
    clkin_hz: f64,
    now_ns: u64,
    registers: [u16; RESET.len()],
    is_converting: bool,
    /// When the conversions under way began, and how many ended since.
    since_ns: u64,
    ended: u64,
    /// The latest two conversions that were not read, and the one that was read last.
    fifo: VecDeque<[i32; CHANNELS]>,
    read: [i32; CHANNELS],
    /// The answer to the latest command. None: STATUS.
    response: Option<u16>,
    damaged: u32,
    is_absent: bool,
}

impl Ads131m08 {
    /// A chip after power-up, which converts, before `scene` at a clock on CLKIN, hertz.
    pub fn new(scene: impl Scene + 'static, clkin_hz: f64) -> Self {
        Self(Arc::new(Mutex::new(Chip {
            scene: Box::new(scene),
            clkin_hz,
            now_ns: 0,
            registers: RESET,
            is_converting: true,
            since_ns: 0,
            ended: 0,
            fifo: VecDeque::new(),
            read: [0; CHANNELS],
            response: None,
            damaged: 0,
            is_absent: false,
        })))
    }

    fn lock(&self) -> MutexGuard<'_, Chip> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Virtual time, nanoseconds.
    pub fn now_ns(&self) -> u64 {
        self.lock().now_ns
    }

    /// Lets nanoseconds pass.
    pub fn advance_ns(&self, ns: u64) {
        let mut chip = self.lock();
        let until_ns = chip.now_ns + ns;
        chip.advance_to(until_ns);
    }

    /// When DRDY falls next, nanoseconds. None while nothing is converted, or the scene is over.
    pub fn next_drdy_fall_ns(&self) -> Option<u64> {
        let chip = self.lock();
        let next_ns = chip.conversion_ns(chip.ended + 1);
        let is_coming = chip.is_converting && !chip.is_absent;
        (is_coming && (next_ns as f64) < chip.scene.end_s() * 1e9).then_some(next_ns)
    }

    /// Whether DRDY is low: data were not read.
    pub fn drdy_is_low(&self) -> bool {
        let chip = self.lock();
        !chip.is_absent && !chip.fifo.is_empty()
    }

    /// Begins a fault.
    pub fn begin_fault(&self, fault: Ads131m08Fault) {
        let mut chip = self.lock();
        match fault {
            Ads131m08Fault::Damaged(frames) => chip.damaged = frames,
            Ads131m08Fault::BrownOut => chip.reset(),
            Ads131m08Fault::Absent(is_absent) => chip.is_absent = is_absent,
        }
    }
}

impl Chip {
    fn reset(&mut self) {
        self.registers = RESET;
        self.restart(true);
    }

    /// Begins conversions anew, or stops.
    fn restart(&mut self, is_converting: bool) {
        (self.is_converting, self.since_ns, self.ended) = (is_converting, self.now_ns, 0);
        self.fifo.clear();
    }

    /// When a conversion ends, counted from 1: f_MOD is half of CLKIN, OSR 128 to 16,384.
    fn conversion_ns(&self, number: u64) -> u64 {
        let osr = 128u32 << (self.registers[CLOCK] >> 2 & 7);
        let period_s = f64::from(osr) * 2.0 / self.clkin_hz;
        self.since_ns + (number as f64 * period_s * 1e9).round() as u64
    }

    fn enables(&self) -> u16 {
        self.registers[CLOCK] >> 8
    }

    fn advance_to(&mut self, until_ns: u64) {
        while self.is_converting && self.conversion_ns(self.ended + 1) <= until_ns {
            self.ended += 1;
            let t_s = self.conversion_ns(self.ended) as f64 * 1e-9;
            let enables = self.enables();
            let codes = core::array::from_fn(|channel| {
                if enables >> channel & 1 == 0 {
                    return 0;
                }
                let share = self.scene.volts(channel as u8, t_s) / FULL_SCALE_V;
                (share * 8_388_608.0)
                    .round()
                    .clamp(-8_388_608.0, 8_388_607.0) as i32
            });
            if self.fifo.len() == 2 {
                self.fifo.pop_front();
            }
            self.fifo.push_back(codes);
        }
        self.now_ns = until_ns;
    }

    /// One frame of CS.
    fn frame(&mut self, din: &[u8]) -> [u8; WORDS * WORD_BYTES] {
        let mut dout = [0xff; WORDS * WORD_BYTES];
        if self.is_absent {
            return dout;
        }
        let fresh = self.fifo.pop_front();
        let drdy = if fresh.is_some() { self.enables() } else { 0 };
        self.read = fresh.unwrap_or(self.read);
        let status = self.registers[STATUS] | drdy;
        let response = self.response.take().unwrap_or(status);
        let (words, _) = dout.as_chunks_mut::<WORD_BYTES>();
        words[0] = [(response >> 8) as u8, response as u8, 0];
        for (word, code) in words[1..].iter_mut().zip(self.read) {
            word.copy_from_slice(&code.to_be_bytes()[1..]);
        }
        let crc = crc16(words[..=CHANNELS].as_flattened());
        words[CHANNELS + 1] = [(crc >> 8) as u8, crc as u8, 0];
        if self.damaged > 0 {
            self.damaged -= 1;
            dout[4] ^= 0x10;
        }
        self.obey(din);
        dout
    }

    /// Takes the command of a frame, at its end.
    fn obey(&mut self, din: &[u8]) {
        let (words, _) = din.as_chunks::<WORD_BYTES>();
        let mut words = words
            .iter()
            .map(|word| u16::from_be_bytes([word[0], word[1]]));
        let command = words.next().unwrap_or(0);
        let (address, count) = (usize::from(command >> 7 & 0x3f), command & 0x7f);
        match command {
            0x0011 if din.len() >= WORDS * WORD_BYTES => {
                self.reset();
                self.response = Some(0xff28);
            }
            0x0022 => {
                self.restart(false);
                self.response = Some(command);
            }
            0x0033 => {
                self.restart(true);
                self.response = Some(command);
            }
            // One register: its value is the response. More are left out.
            _ if command >> 13 == 0b101 && count == 0 => {
                self.response = Some(self.registers.get(address).copied().unwrap_or(0));
            }
            _ if command >> 13 == 0b011 => {
                for (register, value) in (address..).zip(words.take(usize::from(count) + 1)) {
                    self.write(register, value);
                }
                self.response = Some(0b010 << 13 | command & 0x1fff);
            }
            _ => {}
        }
    }

    fn write(&mut self, register: usize, value: u16) {
        match register {
            MODE => {
                self.registers[STATUS] &= !HAS_RESET | value & HAS_RESET;
                self.registers[MODE] = value;
            }
            CLOCK => {
                self.registers[CLOCK] = value;
                self.restart(self.is_converting);
            }
            // ID and STATUS are read-only.
            _ => {}
        }
    }
}

/// CRC-16-CCITT, seed FFFFh.
fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xffff, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte) << 8, |crc: u16, _| {
            (crc << 1) ^ if crc & 0x8000 == 0 { 0 } else { 0x1021 }
        })
    })
}

impl ErrorType for Ads131m08 {
    type Error = Infallible;
}

/// A transaction is one frame of CS, one transfer in place; SPI takes no time.
impl SpiDevice for Ads131m08 {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        for operation in operations {
            match operation {
                Operation::TransferInPlace(bytes) => {
                    let dout = self.lock().frame(bytes);
                    let sent = bytes.iter_mut().zip(dout);
                    sent.for_each(|(byte, dout)| *byte = dout);
                }
                Operation::DelayNs(ns) => self.advance_ns(u64::from(*ns)),
                _ => unimplemented!("the chip's words are transfers in place"),
            }
        }
        Ok(())
    }
}

impl DelayNs for Ads131m08 {
    fn delay_ns(&mut self, ns: u32) {
        self.advance_ns(u64::from(ns));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Constant;

    #[test]
    fn the_crc_is_the_usual_one() {
        // The check value of CRC-16/CCITT-FALSE.
        assert_eq!(crc16(b"123456789"), 0x29b1);
    }

    #[test]
    fn a_frame_has_status_codes_and_crc() {
        let mut volts = [0.0; crate::scene::INPUTS];
        (volts[0], volts[1], volts[7]) = (0.6, -1.2, 2.0);
        let end_s = f64::INFINITY;
        let mut chip = Ads131m08::new(Constant { volts, end_s }, 8_192_000.0);
        // OSR 1024 after reset: 4 kHz.
        assert_eq!(chip.next_drdy_fall_ns(), Some(250_000));
        chip.advance_ns(250_000);
        assert!(chip.drdy_is_low());
        let mut frame = [0; 30];
        chip.transfer_in_place(&mut frame).unwrap();
        assert_eq!(frame[..9], [0x05, 0xff, 0, 0x40, 0, 0, 0x80, 0, 0]);
        assert_eq!(frame[24..27], [0x7f, 0xff, 0xff]);
        assert_eq!(crc16(&frame[..29 - 2]).to_be_bytes(), frame[27..29]);
        assert!(!chip.drdy_is_low());
        // Read again: no new data; the command is answered one frame later.
        let mut frame = [0; 30];
        frame[0] = 0xa0;
        chip.transfer_in_place(&mut frame).unwrap();
        assert_eq!(frame[..6], [0x05, 0x00, 0, 0x40, 0, 0]);
        chip.transfer_in_place(&mut frame).unwrap();
        assert_eq!(frame[..3], [0x28, 0x00, 0]);
    }
}
