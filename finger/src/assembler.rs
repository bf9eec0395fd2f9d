//! Conversions in, frames out, by the chip's own channel ids.
//!
//! The chip says with each conversion which channel it is, so channels are not counted. A gap in their order is a loss.
//! When the gap spans whole scans, the time stamps say how many. Time stamps wrap after 71.6 minutes: of a longer gap
//! only the remainder is seen.
//!
//! Conversions are buffered until there are as many as a scan has slots. A scan without a flaw takes the fast path, all
//! others take the slow path, conversion by conversion.

use crate::frame::{Frame, Readings, TimedConversion};
use crate::scan::{CONVERSION_NS, FRAME_NS, ID_OF, IDS, OWN, SLOT_OF, SLOTS};
use ads1258::Conversion;
use heapless::Vec;
use ridgetone_proto::scan::{INPUTS, SCANNED};

/// A gap in time above which whole scans may be missing: half a scan, microseconds.
const GAP_US: u32 = (FRAME_NS / 2000) as u32;
/// How far from its time a conversion may be, microseconds: an interrupt may be late by so much, and by default it is
/// 1 % of a scan.
const JITTER_US: u32 = 50;
/// Time from one conversion to the next, microseconds.
const STEP_US: u32 = (CONVERSION_NS / 1000) as u32;
/// Time from the first to the last conversion of a scan, microseconds.
const SPAN_US: u32 = (CONVERSION_NS * (SLOTS as u64 - 1) / 1000) as u32;
/// NEW and no other flag (SBAS297G, status byte): a conversion without a flaw.
const FLAWLESS: u8 = 0x80;
/// Channel id of a scan's last slot.
const LAST_ID: u8 = ID_OF[SLOTS as usize - 1];

/// Flaws of the conversions on the slow path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flaws {
    /// Conversions that are missing, by the ids and by the time.
    pub lost: u32,
    /// Conversions without NEW.
    pub repeated: u32,
    /// Ids that are not of the scan, or that follow too early or too late for the gap before them.
    pub channel: u32,
    /// SUPPLY was set.
    pub supply: u32,
    /// The next id followed, but too early or too late: later conversions are not at their expected times.
    pub clock: u32,
    /// OVF was set, or the code is at the end of the scale.
    pub overload: u32,
}

/// A conversion that was too late, or too early. Only the next one shows whether the chip is late or just this time stamp.
#[derive(Clone, Copy, Debug)]
struct OffTime {
    /// By how much it was too late, microseconds.
    late_us: i32,
    /// Conversions were missing before it.
    has_gap: bool,
}

/// Puts frames together.
#[derive(Clone, Debug)]
pub struct Assembler {
    /// The reference, volts.
    pub vref_v: f32,
    buffer: Vec<TimedConversion, { SLOTS as usize }>,
    /// Slot of the latest conversion that was taken.
    pub latest_slot: Option<u32>,
    /// Set if that conversion was off its time.
    off_time: Option<OffTime>,
    /// Board time of that conversion, microseconds, wrapping.
    pub board_us: u32,
    /// Device time of that conversion, microseconds since the first.
    pub now_us: u64,
    /// The latest frame.
    pub frame: Frame,
    /// Whether `frame` holds conversions and was not given yet.
    is_open: bool,
    /// The latest codes of the internal readings: offset, supply, temperature, gain, reference.
    pub own: [Option<i32>; OWN],
    /// Frames given so far. It wraps, as their numbers do, after 206 days.
    pub frames: u32,
    /// Conversions that are missing.
    pub lost: u32,
    /// Conversions with OVF or SUPPLY, without NEW, or of a channel outside the scan.
    pub doubtful: u32,
    /// Flaws since the detector took this.
    pub flaws: Flaws,
}

impl Assembler {
    /// An assembler that has seen nothing. `vref_v` is the reference, volts.
    pub const fn new(vref_v: f32) -> Self {
        Self {
            vref_v,
            buffer: Vec::new(),
            latest_slot: None,
            off_time: None,
            board_us: 0,
            now_us: 0,
            frame: Frame::EMPTY,
            is_open: false,
            own: [None; OWN],
            frames: 0,
            lost: 0,
            doubtful: 0,
            flaws: Flaws { lost: 0, repeated: 0, channel: 0, supply: 0, clock: 0, overload: 0 },
        }
    }

    /// The chip's internal readings.
    pub fn readings(&self) -> Readings {
        Readings::new(self.own, self.vref_v)
    }

    /// Buffers one conversion. True if there is now a scan's worth of them, for [`Self::try_fast_path`] or else
    /// [`Self::slow_path`].
    #[inline(always)]
    pub fn buffer(&mut self, timed: &TimedConversion) -> bool {
        // The buffer is never full here.
        let _ = self.buffer.push(*timed);
        self.buffer.is_full()
    }

    /// Takes one conversion and calls `done` with every frame that is over.
    pub fn push(&mut self, timed: &TimedConversion, mut done: impl FnMut(&Frame)) {
        if !self.buffer(timed) {
            return;
        }
        if self.try_fast_path() {
            done(&self.frame);
        } else {
            self.slow_path(&mut done);
        }
    }

    /// The signal has ended: takes what is still buffered.
    pub fn finish(&mut self, done: &mut impl FnMut(&Frame)) {
        for timed in core::mem::take(&mut self.buffer) {
            self.take(&timed, done);
        }
    }

    /// Makes a frame of the buffer if it is a scan without a flaw that follows the one before it, in time too. If it is not:
    /// false, and only codes that belong to no frame have changed.
    #[inline(never)]
    pub fn try_fast_path(&mut self) -> bool {
        let Some((buffer, _)) = self.buffer.split_first_chunk::<{ SLOTS as usize }>() else { return false };
        let [first, .., last] = buffer;
        let is_on_time = |passed_us: u32, expected_us| passed_us.wrapping_sub(expected_us - JITTER_US) <= 2 * JITTER_US;
        let span_us = last.t_us.wrapping_sub(first.t_us);
        let (number, passed_us) = match self.latest_slot {
            None => (0, 0),
            Some(slot) => {
                let passed_us = first.t_us.wrapping_sub(self.board_us);
                if slot != SLOTS - 1 || self.off_time.is_some() || !is_on_time(passed_us, STEP_US) {
                    return false;
                }
                (self.frame.number.wrapping_add(1), passed_us)
            }
        };
        let is_expected = |(timed, id): (&TimedConversion, &u8)| timed.conversion.status.0 == FLAWLESS | id;
        let (taxels, own) = buffer.split_at(INPUTS);
        if !is_on_time(span_us, SPAN_US) || !buffer.iter().zip(&ID_OF).all(is_expected) {
            return false;
        }
        // No frame is open here, so these codes are nobody's.
        for (code, timed) in self.frame.codes.iter_mut().zip(taxels) {
            *code = timed.conversion.code;
            if is_clipped(*code) {
                return false;
            }
        }
        self.board_us = last.t_us;
        self.latest_slot = Some(SLOTS - 1);
        for (code, timed) in self.own.iter_mut().zip(own) {
            *code = Some(timed.conversion.code);
        }
        self.frame.number = number;
        self.frame.t_us = self.now_us.wrapping_add(passed_us as u64);
        (self.frame.present, self.frame.good) = (SCANNED, SCANNED);
        self.now_us = self.frame.t_us.wrapping_add(span_us as u64);
        self.buffer.clear();
        self.frames = self.frames.wrapping_add(1);
        true
    }

    /// Takes the buffered conversions one by one. Those behind the last slot of a scan stay in the buffer, so that the
    /// next scan can take the fast path.
    #[inline(never)]
    pub fn slow_path(&mut self, done: &mut impl FnMut(&Frame)) {
        let buffer = core::mem::take(&mut self.buffer);
        let is_last = |timed: &TimedConversion| timed.conversion.status.chid() == LAST_ID;
        let taken = buffer.iter().rposition(is_last).map_or(buffer.len(), |last| last + 1);
        for (at, timed) in buffer.iter().enumerate() {
            if at < taken {
                self.take(timed, done);
            } else {
                let _ = self.buffer.push(*timed);
            }
        }
    }

    /// Takes any conversion.
    #[inline(never)]
    fn take(&mut self, timed: &TimedConversion, done: &mut impl FnMut(&Frame)) {
        let TimedConversion { t_us, conversion: Conversion { status, code } } = *timed;
        let Some(slot) = SLOT_OF[status.chid() as usize % IDS].filter(|_| status.is_new()) else {
            self.doubtful = self.doubtful.saturating_add(1);
            let flaw = if status.is_new() { &mut self.flaws.channel } else { &mut self.flaws.repeated };
            *flaw = flaw.saturating_add(1);
            return;
        };
        let slot = slot as usize;
        let is_clean = !status.is_overflow() && !status.is_supply_low();
        self.flaws.supply += status.is_supply_low() as u32;
        self.flaws.overload += (status.is_overflow() || slot < INPUTS && is_clipped(code)) as u32;
        self.doubtful = self.doubtful.saturating_add(!is_clean as u32);

        let scans = self.advance(slot as u32, t_us);
        if scans > 0 {
            self.give(done);
            self.frame.number = self.frame.number.wrapping_add(scans);
            self.frame.t_us = self.now_us.saturating_sub(slot as u64 * CONVERSION_NS / 1000);
            (self.frame.present, self.frame.good) = (0, 0);
        }
        self.is_open = true;
        if slot < INPUTS {
            self.frame.codes[slot] = code;
            self.frame.present |= 1 << slot;
            self.frame.good |= ((is_clean && !is_clipped(code)) as u16) << slot;
        } else if let Some(own) = self.own.get_mut(slot - INPUTS) {
            *own = Some(code);
        }
        if slot as u32 == SLOTS - 1 {
            self.give(done);
        }
    }

    /// Moves on to `slot` at board time `t_us` and counts what was lost before it. Returns how many scans later it is
    /// than the latest conversion.
    fn advance(&mut self, slot: u32, t_us: u32) -> u32 {
        let passed_us = t_us.wrapping_sub(self.board_us);
        self.board_us = t_us;
        let Some(before) = self.latest_slot.replace(slot) else {
            self.lost = slot;
            self.flaws.lost = slot;
            return 0;
        };
        self.now_us = self.now_us.wrapping_add(passed_us as u64);
        let (mut scans, mut lost_by_time) = ((slot <= before) as u32, 0);
        if passed_us > GAP_US {
            // As many whole scans more as bring the count of slots nearest to the time that passed.
            let by_time = (passed_us as u64 * 1000 / CONVERSION_NS) as u32;
            let by_order = scans * SLOTS + slot - before;
            scans += (by_time.saturating_sub(by_order) + SLOTS / 2) / SLOTS;
            // A chip that was set up again restarts its scan: by order there may be fewer.
            lost_by_time = by_time;
        }
        let steps = scans.saturating_mul(SLOTS).saturating_add(slot).saturating_sub(before);
        let lost = steps.max(lost_by_time).saturating_sub(1);
        self.lost = self.lost.saturating_add(lost);
        self.flaws.lost = self.flaws.lost.saturating_add(lost);
        self.check_time(passed_us, steps);
        scans
    }

    /// Whether so many steps of the scan fit the time that passed. After a chip stood still or restarted its scan, every
    /// later conversion is off the time that the fit assumes. After a single late time stamp the next one is on time.
    fn check_time(&mut self, passed_us: u32, steps: u32) {
        let expected_us = (steps as u64 * CONVERSION_NS / 1000) as u32;
        let before = self.off_time.take();
        let late_us =
            (passed_us.wrapping_sub(expected_us) as i32).saturating_add(before.map_or(0, |before| before.late_us));
        let has_gap = steps > 1 || before.is_some_and(|before| before.has_gap);
        // 122 ppm, for the difference of the two crystals over a long gap.
        if late_us.unsigned_abs() <= JITTER_US + (passed_us >> 13) {
            return;
        }
        if before.is_none() {
            self.off_time = Some(OffTime { late_us, has_gap });
        } else if has_gap {
            self.flaws.channel = self.flaws.channel.saturating_add(1);
        } else {
            self.flaws.clock = self.flaws.clock.saturating_add(1);
        }
    }

    fn give(&mut self, done: &mut impl FnMut(&Frame)) {
        if core::mem::take(&mut self.is_open) {
            self.frames = self.frames.wrapping_add(1);
            done(&self.frame);
        }
    }
}

/// Whether a code is at either end of the scale, where the chip clips (SBAS297G: 800000h and 7FFFFFh).
const fn is_clipped(code: i32) -> bool {
    code <= -0x80_0000 || code >= 0x7f_ffff
}

#[cfg(test)]
mod tests;
