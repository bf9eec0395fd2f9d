//! The simulated ADS1258 on SPI1 and the pins, with the datasheet's timing rules (SBAS297G).

use crate::findings::Rule;
use hal_mock::{Ads1258, Options, Scene};

/// First byte of a transfer that reads a result by command.
const READ_RESULT: u8 = 0x30;
/// Commands that write registers: C[2:0] is 011.
const WRITE: u8 = 0b011;
const NEW: u8 = 0x80;

/// A result that the image has read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// True time of the falling edge of DRDY, nanoseconds since power-up.
    pub edge_ns: u64,
    /// Microsecond counter at the interrupt's first read.
    pub t_us: u32,
    /// Status byte and code, most significant byte first.
    pub bytes: [u8; 4],
}

pub struct Adc {
    pub chip: Ads1258,
    cs_low: bool,
    start: bool,
    reset_high: bool,
    /// Time of the latest change of CS.
    cs_ns: u64,
    /// Bytes of the current transfer, sent and received.
    bytes: Vec<(u8, u8)>,
    /// Microsecond counter at the first read of the latest DRDY interrupt.
    pub t_us: u32,
    pub readings: Vec<Reading>,
    /// Number of results read only once before the next was ready.
    pub read_once: u64,
    /// Number of results that a read received unaltered; a result read only once counts only while
    /// it is the latest.
    pub arrived: u64,
    /// Number of reads of the latest result.
    reads: u32,
    /// DRDY edges of the latest result that arrived, and of the latest that was read.
    arrived_ns: Option<u64>,
    read_ns: Option<u64>,
    /// Time of the first rising START, nanoseconds.
    pub started_ns: Option<u64>,
}

impl Adc {
    pub fn new(scene: Box<dyn Scene>, options: Options) -> Self {
        Self {
            chip: Ads1258::new(scene, options),
            cs_low: false,
            start: false,
            reset_high: true,
            cs_ns: 0,
            bytes: Vec::new(),
            t_us: 0,
            readings: Vec::new(),
            read_once: 0,
            arrived: 0,
            reads: 0,
            arrived_ns: None,
            read_ns: None,
            started_ns: None,
        }
    }

    /// Clock of the chip, hertz; 0 without a clock.
    pub fn clock_hz(&self) -> u32 {
        self.chip.options().clock_hz
    }

    /// Period of the chip's clock; 0 without a clock, so that CS has no timing rules then.
    fn tclk_ns(&self) -> f64 {
        match self.clock_hz() {
            0 => 0.0,
            hz => 1e9 / f64::from(hz),
        }
    }

    /// Sets CS and checks its timing. `spi_is_busy` is true if SPI is busy now.
    pub fn set_cs(&mut self, low: bool, now_ns: u64, spi_is_busy: bool) -> Option<(Rule, String)> {
        if low == self.cs_low {
            return None;
        }
        self.cs_low = low;
        let since_ns = (now_ns - std::mem::replace(&mut self.cs_ns, now_ns)) as f64;
        if low {
            self.chip.select(now_ns);
            self.bytes.clear();
            let short = since_ns < 2.0 * self.tclk_ns();
            return short.then(|| {
                (
                    Rule::ChipSelect,
                    format!("CS was high for {since_ns} ns only"),
                )
            });
        }
        self.chip.deselect(now_ns);
        self.keep_reading();
        spi_is_busy.then(|| (Rule::ChipSelect, "CS rises while SPI is busy".into()))
    }

    fn keep_reading(&mut self) {
        let [(READ_RESULT, _), (_, a), (_, b), (_, c), (_, d), ..] = *self.bytes else {
            return;
        };
        let edge_ns = self.chip.latest_drdy_fall_ns();
        let is_new = a & NEW != 0;
        if is_new && self.reads == 1 {
            self.read_once += 1;
            // The firmware counts the result as lost, because no second read has confirmed it.
            let had_arrived = self.arrived_ns.is_some() && self.arrived_ns == self.read_ns;
            self.arrived -= u64::from(had_arrived && edge_ns != self.read_ns);
        }
        let code = i32::from_be_bytes([b, c, d, 0]) >> 8;
        let is_right = (a & !NEW, code) == self.chip.latest_results()[0];
        if is_right && edge_ns != self.arrived_ns {
            (self.arrived, self.arrived_ns) = (self.arrived + 1, edge_ns);
        }
        if !is_new {
            self.reads += 1;
            return;
        }
        (self.reads, self.read_ns) = (1, edge_ns);
        self.readings.push(Reading {
            edge_ns: edge_ns.unwrap_or(0),
            t_us: self.t_us,
            bytes: [a, b, c, d],
        });
    }

    pub fn set_start(&mut self, high: bool, now_ns: u64) {
        if high != self.start {
            self.start = high;
            self.chip.set_start(now_ns, high);
            if high {
                self.started_ns.get_or_insert(now_ns);
            }
        }
    }

    /// Sets RESET, active low.
    pub fn set_reset(&mut self, high: bool, now_ns: u64) {
        if high != self.reset_high {
            self.reset_high = high;
            self.chip.set_reset(now_ns, high);
        }
    }

    /// Exchanges a byte, given the times of its first and last SCLK edges.
    pub fn exchange(
        &mut self,
        out: u8,
        first_ns: u64,
        last_ns: u64,
    ) -> (u8, Option<(Rule, String)>) {
        if !self.cs_low {
            return (0xFF, None);
        }
        let since_ns = first_ns.saturating_sub(self.cs_ns) as f64;
        let broken = if self.bytes.is_empty() && since_ns < 2.5 * self.tclk_ns() {
            Some((Rule::ChipSelect, format!("SCLK {since_ns} ns after CS")))
        } else if self.bytes.is_empty() && self.start && out >> 5 == WRITE {
            Some((
                Rule::AdcWrite,
                format!("command {out:#04x} while START is high"),
            ))
        } else {
            None
        };
        let incoming = self.chip.exchange(first_ns, last_ns, out);
        self.bytes.push((out, incoming));
        (incoming, broken)
    }
}
