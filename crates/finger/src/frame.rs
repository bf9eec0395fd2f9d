//! Conversions with their times, scans, and the times of scans.

use crate::converter::{Sample, Tag};
use crate::ring::Ring;
use crate::scan::{OWN, Scan, taxels};
use ads1258::reading;
use ridgetone_proto::division::divide;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::scan::TAXELS;
use ridgetone_proto::telemetry::Raw;
use ridgetone_tone::Values;

/// One conversion with the time of its DRDY edge, in two words, because every conversion is copied
/// into the queue to the detector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimedConversion {
    /// Time of the falling edge of DRDY on the board's microsecond counter, wrapping.
    pub t_us: u32,
    /// The code in the upper three bytes, the tag in the lowest.
    pub(crate) bits: u32,
}

/// Tag of a mark in the queue. No conversion has it, because all have NEW set.
const MARK: u8 = 0x1f;

impl TimedConversion {
    /// All zeros: no conversion.
    pub(crate) const NONE: Self = Self { t_us: 0, bits: 0 };

    /// A sample of any converter as read, and the time of its edge, microseconds.
    #[inline(always)]
    pub fn new(t_us: u32, sample: impl Into<Sample>) -> Self {
        Self::of_sample(t_us, sample.into())
    }

    const fn of_sample(t_us: u32, sample: Sample) -> Self {
        Self {
            t_us,
            bits: (sample.code as u32) << 8 | sample.tag.0 as u32,
        }
    }

    /// Creates a mark: the conversions after it are of this plan.
    pub const fn of_plan(plan: &Plan, t_us: u32) -> Self {
        Self {
            t_us,
            bits: plan.mark() << 8 | MARK as u32,
        }
    }

    /// [`Plan::mark`] of the plan, if this is a mark.
    #[inline(always)]
    pub const fn as_mark(&self) -> Option<u32> {
        if self.bits as u8 == MARK {
            Some(self.bits >> 8)
        } else {
            None
        }
    }

    /// Channel and flags as read.
    #[inline(always)]
    pub const fn tag(&self) -> Tag {
        Tag(self.bits as u8)
    }

    /// 24-bit code as read.
    #[inline(always)]
    pub const fn code(&self) -> i32 {
        self.bits as i32 >> 8
    }

    /// Returns the conversion with a different tag.
    pub const fn with_tag(self, tag: Tag) -> Self {
        let code = self.code();
        Self::of_sample(self.t_us, Sample { tag, code })
    }

    /// Returns the conversion with a different code.
    pub const fn with_code(self, code: i32) -> Self {
        let tag = self.tag();
        Self::of_sample(self.t_us, Sample { tag, code })
    }
}

/// Conversions of one scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Number of the scan since the first conversion, including lost scans.
    pub number: u32,
    /// Device time of the scan's first slot, microseconds since the first conversion.
    pub t_us: u64,
    /// Codes of the taxels; any value for a taxel that is not present.
    pub codes: [i32; TAXELS],
    /// Bit k: taxel k was converted and read.
    pub present: u16,
    /// Bit k: the conversion of taxel k carried neither OVF nor SUPPLY, and its code is not at
    /// either end of the scale.
    pub good: u16,
}

impl Frame {
    /// Frame before the first scan.
    pub const EMPTY: Self = Self {
        number: 0,
        t_us: 0,
        codes: [0; TAXELS],
        present: 0,
        good: 0,
    };

    /// Writes the good codes, minus their references, to their places in `values`.
    pub fn put(&self, reference: &Values, values: &mut Values) {
        // Exact, because codes have 24 bits.
        let value = |c: usize| self.codes[c] as f32 - reference[c];
        if self.good == u16::MAX {
            (0..TAXELS).for_each(|c| values[c] = value(c));
            return;
        }
        taxels(self.good).for_each(|c| values[c] = value(c));
    }
}

impl From<Raw> for Frame {
    fn from(raw: Raw) -> Self {
        Self {
            number: raw.number,
            t_us: raw.t_us,
            codes: raw.codes,
            present: raw.present,
            good: raw.good,
        }
    }
}

/// Readings of all channels at one time, of any converter.
#[derive(Clone, Copy, Debug)]
pub struct PlainFrame<'a> {
    /// Device time, microseconds.
    pub t_us: u64,
    /// Readings, volts or any other unit. Readings that are NaN or outside plus or minus `vref_v`
    /// of the settings are left out; others are rounded to 24 bits of that range.
    pub readings: &'a [f32],
}

impl PlainFrame<'_> {
    /// Converts the readings to codes of a reference of `vref_v`.
    pub(crate) fn frame(&self, number: u32, inputs: u16, vref_v: f32) -> Frame {
        let mut frame = Frame {
            number,
            t_us: self.t_us,
            present: inputs,
            ..Frame::EMPTY
        };
        let per_volt = reading::CODES_PER_VREF as f32 / vref_v;
        for (taxel, (code, value)) in frame.codes.iter_mut().zip(self.readings).enumerate() {
            // This also excludes NaN.
            if value.abs() <= vref_v {
                *code = libm::roundf(value * per_volt) as i32;
                frame.good |= 1 << taxel;
            }
        }
        frame.good &= inputs;
        frame
    }
}

/// Internal readings of the chip, from the latest scan that had them; zero before.
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

impl Readings {
    /// Converts codes, in the order of the slots, to readings. `vref_v` is the reference in the
    /// settings, volts.
    pub fn new(
        [offset, supply, temperature, gain, reference]: [Option<i32>; OWN],
        vref_v: f32,
    ) -> Self {
        Self {
            supply_v: supply.map_or(0.0, reading::supply_v),
            reference_v: reference.map_or(0.0, reading::reference_v),
            temperature_c: temperature.map_or(0.0, |code| reading::temperature_c(code, vref_v)),
            offset_v: offset.map_or(0.0, |code| reading::offset_v(code, vref_v)),
            gain: gain.map_or(0.0, reading::gain),
        }
    }
}

/// Times of frames.
#[derive(Clone, Debug)]
pub(crate) struct FrameClock {
    /// Number of the latest frame, and the device time of its first slot, microseconds.
    pub latest: (u32, u64),
    /// Number and device time of the first complete frame, from which the rate is measured.
    pub rate_from: Option<(u32, u64)>,
    frame_ns: u32,
    /// Nominal time from a scan's first slot to its last, microseconds.
    span_us: u32,
}

impl FrameClock {
    pub const fn new(scan: &Scan) -> Self {
        Self {
            latest: (0, 0),
            rate_from: None,
            frame_ns: scan.frame_ns(),
            span_us: scan.span_us(),
        }
    }

    /// Continues with a different scan.
    pub fn change(&mut self, scan: &Scan) {
        (self.rate_from, self.frame_ns) = (None, scan.frame_ns());
        self.span_us = scan.span_us();
    }

    /// Time from `t_us` to the last conversion of the latest frame, microseconds: the delay of an
    /// event that is reported now.
    pub fn since_us(&self, t_us: u64) -> u32 {
        let passed_us = self
            .latest
            .1
            .wrapping_add(self.span_us as u64)
            .saturating_sub(t_us);
        u32::try_from(passed_us).unwrap_or(u32::MAX)
    }

    /// Frames per second by the board's clock; zero before the second frame.
    pub fn frame_rate_hz(&self) -> f32 {
        /// Frame numbers wrap after 2^32: 206 days at 241 Hz.
        const WRAP_FRAMES: f32 = 4_294_967_296.0;
        match self.rate_from {
            Some((frame, t_us)) if self.latest.1 > t_us => {
                let passed_us = (self.latest.1 - t_us) as f32;
                let beyond_wraps = self.latest.0.wrapping_sub(frame) as f32;
                // The time and the nominal rate show how often the numbers have wrapped.
                let nominal = passed_us * (1e3 / self.frame_ns as f32);
                let wraps = ((nominal - beyond_wraps) / WRAP_FRAMES + 0.5) as u32 as f32;
                (beyond_wraps + wraps * WRAP_FRAMES) * 1e6 / passed_us
            }
            _ => 0.0,
        }
    }

    /// Device time of a frame's first slot, microseconds. Extrapolated at the nominal rate for a
    /// frame outside the ring.
    pub fn time_us(&self, frame: u32, ring: &Ring) -> u64 {
        let (number, t_us) = self.latest;
        if let Some(low) = ring.t_us(frame) {
            return t_us.wrapping_sub((t_us as u32).wrapping_sub(low) as u64);
        }
        let back = number.wrapping_sub(frame) as i32;
        let away_us = divide(back.unsigned_abs() as u64 * self.frame_ns as u64, 1000).0;
        if back < 0 {
            t_us.wrapping_add(away_us)
        } else {
            t_us.saturating_sub(away_us)
        }
    }
}
