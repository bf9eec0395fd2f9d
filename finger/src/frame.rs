//! One conversion with its time, and one scan of them.

use ads1258::Conversion;
use ridgetone_proto::scan::{INPUTS, SCANNED, TAXELS};
use ridgetone_tone::Values;

/// One conversion with the time of its DRDY edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimedConversion {
    /// Time of the falling edge of DRDY on the board's microsecond counter, wrapping.
    pub t_us: u32,
    /// Status byte and 24-bit code as read.
    pub conversion: Conversion,
}

/// One scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Number of the scan since the first conversion, lost scans counted.
    pub number: u32,
    /// Device time of its first slot, microseconds since the first conversion.
    pub t_us: u64,
    /// The codes of the taxels; any value where a taxel is not present.
    pub codes: [i32; TAXELS],
    /// Bit k: taxel k was converted and read.
    pub present: u16,
    /// Bit k: its conversion carried neither OVF nor SUPPLY, and its code is not at the end of the scale.
    pub good: u16,
}

impl Frame {
    /// Before the first scan.
    pub const EMPTY: Self = Self { number: 0, t_us: 0, codes: [0; TAXELS], present: 0, good: 0 };

    /// Whether every taxel of the scan is present.
    pub const fn is_complete(&self) -> bool {
        self.present == SCANNED
    }

    /// Writes the good codes, less their references, to their places in `values`.
    // Not inlined: the caller is compiled for size.
    #[inline(never)]
    pub fn put(&self, reference: &Values, values: &mut Values) {
        for c in 0..INPUTS {
            if self.good & 1 << c != 0 {
                // Exact: codes have 24 bits.
                values[c] = self.codes[c] as f32 - reference[c];
            }
        }
    }
}

/// The chip's internal readings, as of the latest scan that had them; zero before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings {
    /// Analogue supply, volts.
    pub supply_v: f32,
    /// Reference, volts.
    pub reference_v: f32,
    /// Chip temperature, degrees Celsius.
    pub temperature_c: f32,
    /// Offset, volts, ideally 0.
    pub offset_v: f32,
    /// Gain, ideally 1.
    pub gain: f32,
}
