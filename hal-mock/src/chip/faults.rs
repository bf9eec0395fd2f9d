//! Faults to put into the chip, for tests of what notices them: one knob each. [`super::Fault`] turns them by a schedule.

use super::Ads1258;
use super::clock::Clock;

/// Faults in force.
#[derive(Clone, Debug, Default)]
pub(crate) struct Faults {
    pub(crate) stalled: bool,
    /// An input that is held at a voltage, whatever the scene says.
    pub(crate) held: Option<(u8, f64)>,
    bus: Bus,
    /// Flips of bytes still to come, by the count of bytes exchanged since construction.
    bit_errors: Vec<(u64, BitErrors)>,
    exchanged: u64,
}

/// Which way the SPI bus is broken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Bus {
    #[default]
    Whole,
    /// DOUT always reads as this; the chip hears what it is told.
    Stuck(u8),
    /// DOUT always reads as this, and the chip hears nothing.
    Cut(u8),
}

/// Bits of one byte that fall over on their way.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BitErrors {
    pub(crate) din: u8,
    pub(crate) dout: u8,
}

impl Faults {
    /// What falls over of the next byte.
    pub(crate) fn next(&mut self) -> BitErrors {
        let at = self.exchanged;
        self.exchanged += 1;
        if self.bit_errors.is_empty() {
            return BitErrors::default();
        }
        let of_it = self.bit_errors.iter().filter(|(byte, _)| *byte == at);
        let sum = of_it.fold(BitErrors::default(), |all, (_, one)| BitErrors {
            din: all.din ^ one.din,
            dout: all.dout ^ one.dout,
        });
        self.bit_errors.retain(|(byte, _)| *byte > at);
        sum
    }

    /// What arrives of a DOUT byte.
    pub(crate) fn on_dout(&self, dout: u8) -> u8 {
        match self.bus {
            Bus::Whole => dout,
            Bus::Stuck(byte) | Bus::Cut(byte) => byte,
        }
    }

    /// Whether the chip hears nothing.
    pub(crate) fn is_cut(&self) -> bool {
        matches!(self.bus, Bus::Cut(_))
    }
}

impl Ads1258 {
    /// Flips the bits of `mask` in a register, as the field reports of registers that "changed by themselves" have it.
    /// Read-only bits flip too; addresses above 09h do nothing.
    pub fn corrupt_register(&mut self, address: u8, mask: u8) {
        self.registers.flip(address, mask);
    }

    /// The chip resets itself, as a dip of its digital supply makes it: registers at their defaults, the running
    /// conversion gone, and, with START high, a new start condition.
    pub fn reset_itself(&mut self, now_ns: u64) {
        self.advance_to(now_ns);
        self.forget();
        if self.start {
            self.start_condition();
        }
    }

    /// Stops the converter: the running conversion never ends and none begins. Letting it go is a new start condition
    /// if START is high.
    pub fn set_stalled(&mut self, now_ns: u64, stalled: bool) {
        self.advance_to(now_ns);
        let was = std::mem::replace(&mut self.faults.stalled, stalled);
        if stalled {
            self.conversion = None;
        } else if was && self.start {
            self.start_condition();
        }
    }

    /// Flips the bits of `mask` in one DOUT byte, `bytes_ahead` of the next one exchanged (0: the next).
    pub fn flip_dout(&mut self, bytes_ahead: u64, mask: u8) {
        self.flip(bytes_ahead, BitErrors { dout: mask, din: 0 });
    }

    /// Flips the bits of `mask` in one DIN byte on its way to the chip, which does what it then understands: a read may
    /// become a write of registers. `bytes_ahead` as in [`flip_dout`](Self::flip_dout).
    pub fn flip_din(&mut self, bytes_ahead: u64, mask: u8) {
        self.flip(bytes_ahead, BitErrors { din: mask, dout: 0 });
    }

    fn flip(&mut self, bytes_ahead: u64, bit_errors: BitErrors) {
        self.faults.bit_errors.push((self.faults.exchanged + bytes_ahead, bit_errors));
    }

    /// DOUT stuck at a level, true for high; the chip still hears what it is told. `None`: whole again.
    pub fn set_dout_stuck(&mut self, level: Option<bool>) {
        self.faults.bus = level.map_or(Bus::Whole, |high| Bus::Stuck(all(high)));
    }

    /// SCLK, DIN or CS cut: the chip hears nothing, and DOUT floats to a level, true for high. `None`: whole again.
    pub fn set_bus_cut(&mut self, level: Option<bool>) {
        self.faults.bus = level.map_or(Bus::Whole, |high| Bus::Cut(all(high)));
    }

    /// Holds an input at a voltage, whatever the scene says; `None`: none.
    pub fn hold_input(&mut self, held: Option<(u8, f64)>) {
        self.faults.held = held;
    }

    /// Another error of the clock from now on, parts per million; positive is fast.
    pub fn set_clock_error_ppm(&mut self, now_ns: u64, error_ppm: f64) {
        self.advance_to(now_ns);
        self.conversion = self.conversion.take().map(|running| running.rebased(self.clock, self.now_ns));
        self.options.clock_error_ppm = error_ppm;
        self.clock = Clock::new(self.options.clock_hz, error_ppm);
    }
}

/// A byte of ones or of zeros.
fn all(high: bool) -> u8 {
    if high { 0xFF } else { 0x00 }
}
