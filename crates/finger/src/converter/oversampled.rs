//! Averages the scans of a free-running 12-bit converter into frames: the arithmetic for a
//! processor's own converter, without registers.
//!
//! The converter samples its inputs one after another, and fills a buffer of two halves again and
//! again. Each half is added up while the other one fills; the sums of several halves make a frame.

use core::sync::atomic::Ordering::Relaxed;
use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU16, AtomicU32};

/// Periods of the converter's clock per sample: 56 to charge the capacitor, and 12 for the bits.
///
/// At 21 MHz the datasheets' equation 1 (DS8626 and DS10693, ADC characteristics, with 6 kilohm and
/// 7 pF inside) then allows a source of 33 kilohm: a potentiometer of 100 kilohm, a bridge, any
/// amplifier. With 144 periods it would be 94 kilohm, beyond the table's 50 kilohm, but a frame
/// would hold only 40 scans instead of 93, and less of the noise would average out.
pub const SAMPLE_TICKS: u32 = 56 + 12;

/// Maximum number of inputs: a 64-pin processor has no more next to a serial line.
pub const INPUTS: usize = 14;
/// Samples per half of the buffer: three scans of fourteen inputs. The ring leaves no RAM for more.
pub const HALF: usize = 42;
/// The buffer that the converter fills.
pub type Buffer = [AtomicU16; 2 * HALF];
/// Maximum number of scans per frame, because the number is the lowest byte of a plan's bits.
pub const SCANS_MAX: u8 = u8::MAX;
/// Minimum duration of a half, microseconds: a half must be added up before the other one is full,
/// and interrupts of the same or a higher priority take up to 60 us.
const HALF_MIN_US: u32 = 90;
/// Code of one step of the converter: 780000h is `vref_v`, which is 4096 steps.
const STEP: u32 = 0x78_0000 / 4096;
/// Bits by which a step is scaled up to fill 32 bits, before it is divided by the samples of a
/// frame.
const SHIFT: u32 = STEP.leading_zeros();
const READING_MAX: u32 = 4095;

/// Averaging of scans into frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Averaging {
    /// Inputs per scan.
    channels: u8,
    scans: u8,
    /// Scans per half of the buffer; a frame is a whole number of halves.
    half_scans: u8,
    clock_mhz: u8,
}

impl Averaging {
    /// Creates the averaging of this many scans per frame. `None` if no half of the buffer fits.
    pub const fn new(channels: u32, scans: u32, clock_mhz: u8) -> Option<Self> {
        if clock_mhz == 0
            || channels == 0
            || channels > INPUTS as u32
            || scans == 0
            || scans > SCANS_MAX as u32
        {
            return None;
        }
        // The longest half causes the fewest interrupts.
        let mut half_scans = HALF as u32 / channels;
        while half_scans > 1 && !scans.is_multiple_of(half_scans) {
            half_scans -= 1;
        }
        if half_scans * channels * SAMPLE_TICKS < HALF_MIN_US * clock_mhz as u32 {
            return None;
        }
        Some(Self {
            channels: channels as u8,
            scans: scans as u8,
            half_scans: half_scans as u8,
            clock_mhz,
        })
    }

    /// Samples per half of the buffer.
    pub const fn half(&self) -> usize {
        self.channels as usize * self.half_scans as usize
    }

    /// Periods of the converter's clock per frame.
    pub const fn frame_ticks(&self) -> u32 {
        self.channels as u32 * self.scans as u32 * SAMPLE_TICKS
    }

    /// Time from the middle of the first input's samples to the end of the frame's last sample,
    /// microseconds.
    pub const fn middle_us(&self) -> u32 {
        let scan_ticks = self.channels as u32 * SAMPLE_TICKS;
        self.us(self.frame_ticks() + scan_ticks - 2 * SAMPLE_TICKS) / 2
    }

    /// Duration of a frame divided by the number of inputs, microseconds, rounded down, at least 1.
    pub const fn input_us(&self) -> u32 {
        let input_us = self.us(self.scans as u32 * SAMPLE_TICKS);
        if input_us > 1 { input_us } else { 1 }
    }

    /// Converts periods of the converter's clock to whole microseconds.
    const fn us(&self, ticks: u32) -> u32 {
        match ticks.checked_div(self.clock_mhz as u32) {
            Some(us) => us,
            None => 0,
        }
    }
}

/// The half of the buffer that is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filled {
    /// The first.
    First,
    /// The second.
    Second,
    /// Both: service was late, and the converter is overwriting samples that were not added.
    Overwritten,
}

/// Sums of the frame under way, or of the latest frame until the next begins. The interrupt that
/// adds and the task that reads have the same priority, so neither interrupts the other, and the
/// atomics are plain loads and stores.
#[derive(Debug)]
pub struct Oversampler {
    /// Inputs per scan, scans per half of the buffer, scans per frame.
    channels: AtomicU8,
    half_scans: AtomicU8,
    scans: AtomicU8,
    clock_mhz: AtomicU8,
    /// Number of scans taken in the frame under way.
    taken: AtomicU8,
    /// Sum of each input over the frame; its code, once the frame is complete.
    sums: [AtomicU32; INPUTS],
    /// Last sample of each input in the previous frame.
    before: [AtomicU16; INPUTS],
    /// True if the previous frame ended right before this one, so that `before` is valid.
    follows: AtomicBool,
    /// True if part of the frame under way is missing.
    is_torn: AtomicBool,
    /// Bit k: the code of the k-th input is at an end of the scale.
    overloaded: AtomicU16,
    /// Time at which the latest half was full, microseconds.
    half_us: AtomicU32,
}

impl Default for Oversampler {
    fn default() -> Self {
        Self::new()
    }
}

impl Oversampler {
    /// Creates an oversampler; [`Self::begin`] sets the averaging.
    pub const fn new() -> Self {
        Self {
            channels: AtomicU8::new(1),
            half_scans: AtomicU8::new(1),
            scans: AtomicU8::new(1),
            clock_mhz: AtomicU8::new(1),
            taken: AtomicU8::new(0),
            sums: [const { AtomicU32::new(0) }; INPUTS],
            before: [const { AtomicU16::new(0) }; INPUTS],
            follows: AtomicBool::new(false),
            is_torn: AtomicBool::new(false),
            overloaded: AtomicU16::new(0),
            half_us: AtomicU32::new(0),
        }
    }

    /// Starts with the next half as the first of a frame.
    pub fn begin(&self, averaging: &Averaging) {
        let Averaging {
            channels,
            scans,
            half_scans,
            clock_mhz,
        } = *averaging;
        self.channels.store(channels, Relaxed);
        self.half_scans.store(half_scans, Relaxed);
        self.scans.store(scans, Relaxed);
        self.clock_mhz.store(clock_mhz, Relaxed);
        self.taken.store(0, Relaxed);
        self.is_torn.store(false, Relaxed);
        self.follows.store(false, Relaxed);
    }

    fn averaging(&self) -> Averaging {
        Averaging {
            channels: self.channels.load(Relaxed),
            scans: self.scans.load(Relaxed),
            half_scans: self.half_scans.load(Relaxed),
            clock_mhz: self.clock_mhz.load(Relaxed),
        }
    }

    /// Adds the half that was filled at `now_us`. Returns true if a frame is complete; its codes
    /// stay valid until the next call.
    pub fn take(&self, buffer: &Buffer, filled: Filled, now_us: u32) -> bool {
        let averaging = self.averaging();
        let since_us = now_us.wrapping_sub(self.half_us.swap(now_us, Relaxed));
        let half = averaging.half();
        let places = match filled {
            Filled::First => buffer.get(..half),
            Filled::Second => buffer.get(half..2 * half),
            Filled::Overwritten => {
                self.skip(&averaging, since_us);
                return false;
            }
        };
        let places = places.unwrap_or(&[]);
        let begun = self.taken.load(Relaxed);
        self.add(&averaging, places, begun == 0);
        let taken = u32::from(begun) + u32::from(averaging.half_scans);
        if taken < u32::from(averaging.scans) {
            self.taken.store(taken as u8, Relaxed);
            return false;
        }
        self.taken.store(0, Relaxed);
        let is_whole = !self.is_torn.swap(false, Relaxed);
        self.finish(&averaging, places, is_whole);
        is_whole
    }

    fn add(&self, averaging: &Averaging, half: &[AtomicU16], is_first: bool) {
        let channels = usize::from(averaging.channels);
        for (channel, sum) in self.sums.iter().enumerate().take(channels) {
            let samples = half.iter().skip(channel).step_by(channels.max(1));
            let added: u32 = samples.map(|one| u32::from(one.load(Relaxed))).sum();
            let before = if is_first { 0 } else { sum.load(Relaxed) };
            sum.store(before + added, Relaxed);
        }
    }

    /// Skips the halves that were not served, counted by time, so that later frames stay on their
    /// grid.
    fn skip(&self, averaging: &Averaging, since_us: u32) {
        let half_ticks = (averaging.half() as u32 * SAMPLE_TICKS).max(1);
        let ticks = since_us
            .saturating_mul(averaging.clock_mhz.into())
            .saturating_add(half_ticks / 2);
        let scans = (ticks / half_ticks).max(2) * u32::from(averaging.half_scans);
        let at = u32::from(self.taken.load(Relaxed)) + scans;
        let taken = at % u32::from(averaging.scans.max(1));
        self.taken.store(taken as u8, Relaxed);
        self.is_torn.store(taken > 0, Relaxed);
        self.follows.store(false, Relaxed);
    }

    /// Computes the codes of a frame that ends with this half of the buffer.
    ///
    /// Each scan samples input k by k samples later than input 0, so its value at the time of input
    /// 0 is interpolated linearly between two scans. In the sum over a frame the differences
    /// telescope to the frame's last sample less the previous frame's.
    fn finish(&self, averaging: &Averaging, half: &[AtomicU16], is_whole: bool) {
        let channels = usize::from(averaging.channels);
        let scans = u32::from(averaging.scans);
        let last = half
            .get(half.len().saturating_sub(channels)..)
            .unwrap_or(&[]);
        let factor = (STEP << SHIFT) / (u32::from(averaging.channels) * scans).max(1);
        let follows = self.follows.swap(is_whole, Relaxed);
        // Limits half a step, on average, from either end of the scale.
        let (low, high) = (scans / 2, scans * READING_MAX - scans / 2);
        let mut overloaded = 0;
        let rows = self.sums.iter().zip(&self.before).zip(last);
        for (channel, ((place, before), last)) in rows.enumerate().take(channels) {
            let (sum, last) = (place.load(Relaxed), last.load(Relaxed));
            let before = before.swap(last, Relaxed);
            let moved = if follows {
                i32::from(last) - i32::from(before)
            } else {
                0
            };
            // Not negative, because the sum includes the last sample.
            let aligned = (channels as u32 * sum).wrapping_add_signed(-(channel as i32) * moved);
            let scaled = u64::from(aligned) * u64::from(factor) + (1 << (SHIFT - 1));
            place.store((scaled >> SHIFT) as u32, Relaxed);
            overloaded |= u16::from(sum < low || sum > high) << channel;
        }
        self.overloaded.store(overloaded, Relaxed);
    }

    /// Code of the k-th input of the completed frame, and true if it is at an end of the scale.
    pub fn code(&self, channel: usize) -> Option<(i32, bool)> {
        let code = self.sums.get(channel)?.load(Relaxed) as i32;
        Some((code, self.overloaded.load(Relaxed) >> channel & 1 != 0))
    }

    /// Time of the completed frame, microseconds: the middle of its samples of the first input.
    pub fn frame_us(&self) -> u32 {
        let middle_us = self.averaging().middle_us();
        self.half_us.load(Relaxed).wrapping_sub(middle_us)
    }
}

#[cfg(test)]
mod tests;
