//! Assembles conversions into frames, by the chip's own channel ids.
//!
//! Each conversion carries the id of its channel, so channels need not be counted. A gap in the
//! order of ids is a loss; if whole scans may be missing, the time stamps show how many. Time
//! stamps wrap after 71.6 minutes, so of a longer gap only the remainder is seen.
//!
//! Conversions are buffered until there are as many as a scan has slots. A flawless scan takes the
//! fast path; all others take the slow path, conversion by conversion.

mod service_delay;

use crate::converter::{Scanned, Tag};
use crate::frame::{Frame, Readings, TimedConversion};
use crate::samples::{Copied, SampleQueue};
use crate::scan::{OWN, Order, SLOTS_MAX, Scan, own_of};
use ridgetone_proto::division::divide;
use ridgetone_proto::plan::{Plan, Sampling};
use ridgetone_proto::scan::TAXELS;
use service_delay::ServiceDelay;

/// Maximum deviation of a conversion from its expected time, microseconds: it allows for a late
/// interrupt, and is 1 % of the default scan. For fast scans the maximum is three eighths of a
/// conversion instead.
const JITTER_US: u32 = 50;
/// Flags of a flawless conversion: NEW and no other.
const FLAWLESS: u8 = Tag::NEW;

#[derive(Clone, Copy, Debug)]
struct Times {
    jitter_us: u32,
    /// Time from the last conversion of a scan to the first of the next, microseconds.
    step_us: u32,
    /// Time from the first to the last conversion of a scan, microseconds.
    span_us: u32,
    /// Time between conversions above which whole scans may be missing: half a scan, microseconds.
    gap_us: u32,
}

impl Times {
    const fn new(scan: &Scan) -> Self {
        let tolerance_us = scan.edge_ns() * 3 / 8000;
        Self {
            jitter_us: if tolerance_us < JITTER_US {
                tolerance_us
            } else {
                JITTER_US
            },
            step_us: (scan.frame_ns() - scan.span_ns()) / 1000,
            span_us: scan.span_us(),
            gap_us: scan.frame_ns() / 2000,
        }
    }
}

/// Flaws of the conversions on the slow path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flaws {
    /// Missing conversions, by ids and by time.
    pub lost: u32,
    /// Conversions without NEW.
    pub repeated: u32,
    /// Conversions with an id outside the scan, or too early or too late for the gap before them.
    pub channel: u32,
    /// Conversions with SUPPLY set.
    pub supply: u32,
    /// Conversions with the next id, but too early or too late, which shifts all later ones.
    pub clock: u32,
    /// Conversions with OVF set, or with a code at either end of the scale.
    pub overload: u32,
}

/// A conversion that came too early or too late. Only the next one shows whether the chip is off or
/// only this time stamp.
#[derive(Clone, Copy, Debug)]
struct OffTime {
    /// Delay after the expected time, microseconds.
    late_us: i32,
    /// True if conversions were missing before it.
    has_gap: bool,
}

/// Next entry of the queue of conversions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// A scan's worth of conversions, in the buffer.
    Scan,
    /// A mark: conversions of another plan follow.
    Mark(u32),
    Nothing,
}

/// Puts frames together.
#[derive(Clone, Debug)]
pub struct Assembler {
    /// Reference, volts.
    pub vref_v: f32,
    scan: Scan,
    order: Order,
    times: Times,
    /// Tags of a flawless scan's conversions, in scan order: NEW and CHID.
    flawless: [u8; SLOTS_MAX],
    /// Converted taxels, in scan order.
    taxels: [u8; TAXELS],
    /// True if the scan was interrupted for health readings, so that the time until the next
    /// conversion shows no loss.
    has_paused: bool,
    /// Conversions of the scan under way, and their number.
    buffer: [TimedConversion; SLOTS_MAX],
    buffered: usize,
    /// The lowest byte is not zero if one of them is not flawless.
    off: u32,
    /// Slot of the latest conversion that was taken.
    pub latest_slot: Option<u32>,
    /// Set if the latest conversion came too early or too late.
    off_time: Option<OffTime>,
    lateness: ServiceDelay,
    /// Board time of the latest conversion, microseconds, wrapping.
    pub board_us: u32,
    /// Device time of the latest conversion, microseconds since the first.
    pub now_us: u64,
    /// Latest frame.
    pub frame: Frame,
    /// True if `frame` holds conversions and has not been passed on.
    is_open: bool,
    /// Latest codes of the internal readings: offset, supply, temperature, gain, reference.
    pub own: [Option<i32>; OWN],
    /// Number of frames passed on. It wraps, as frame numbers do, after 206 days.
    pub frames: u32,
    /// Number of missing conversions.
    pub lost: u32,
    /// Number of conversions with OVF or SUPPLY, without NEW, or of a channel outside the scan.
    pub doubtful: u32,
    /// Flaws since the detector last took them.
    pub flaws: Flaws,
}

impl Assembler {
    /// Creates an assembler. `vref_v` is the reference in volts; the plan has passed
    /// [`Plan::validate`].
    pub const fn new(vref_v: f32, plan: &Plan) -> Self {
        let scan = Scan::new(plan);
        let order = Order::new(plan, Scanned::Inputs);
        let (flawless, taxels) = table(order, &scan);
        Self {
            vref_v,
            scan,
            order,
            times: Times::new(&scan),
            flawless,
            taxels,
            has_paused: false,
            buffer: [TimedConversion::NONE; SLOTS_MAX],
            buffered: 0,
            off: 0,
            latest_slot: None,
            off_time: None,
            lateness: ServiceDelay::NONE,
            board_us: 0,
            now_us: 0,
            frame: Frame::EMPTY,
            is_open: false,
            own: [None; OWN],
            frames: 0,
            lost: 0,
            doubtful: 0,
            flaws: Flaws {
                lost: 0,
                repeated: 0,
                channel: 0,
                supply: 0,
                clock: 0,
                overload: 0,
            },
        }
    }

    /// Switches to the scan of a different plan, from the next conversion on. Frame numbers and
    /// times continue.
    pub fn change(&mut self, plan: &Plan) {
        self.scan = Scan::new(plan);
        self.order = Order::new(plan, Scanned::Inputs);
        self.times = Times::new(&self.scan);
        (self.flawless, self.taxels) = table(self.order, &self.scan);
        (self.buffered, self.off) = (0, 0);
        (self.has_paused, self.is_open, self.off_time) = (true, false, None);
        self.latest_slot = self.latest_slot.map(|_| self.scan.slots - 1);
    }

    /// Scan of the present plan.
    pub const fn scan(&self) -> &Scan {
        &self.scan
    }

    /// Internal readings of the chip.
    pub fn readings(&self) -> Readings {
        Readings::new(self.own, self.vref_v)
    }

    /// Buffers one conversion. Returns true if the buffer now holds a scan's worth, for
    /// [`Self::try_fast_path`] or else [`Self::slow_path`].
    #[inline(always)]
    pub fn buffer(&mut self, timed: &TimedConversion) -> bool {
        // The buffer is never full here.
        let statuses = self.flawless.iter();
        if let Some((to, status)) = self.buffer.iter_mut().zip(statuses).nth(self.buffered) {
            *to = *timed;
            self.off |= timed.bits ^ *status as u32;
            self.buffered += 1;
        }
        self.buffered >= self.scan.slots as usize
    }

    /// Moves conversions of the queue into the buffer, up to a scan's worth or a mark.
    #[inline(never)]
    pub fn fill(&mut self, samples: &SampleQueue) -> Next {
        if samples.is_empty() {
            return Next::Nothing;
        }
        let range = self.buffered..self.scan.slots as usize;
        let free = self.buffer.get_mut(range.clone()).unwrap_or_default();
        let statuses = self.flawless.get(range).unwrap_or_default();
        let Copied { count, off } = samples.copy(free, statuses);
        // A mark is not flawless.
        let suspects = if off as u8 == 0 { 0 } else { count };
        let mut suspects = free.iter().take(suspects).enumerate();
        let mark = suspects.find_map(|(at, timed)| Some((at, timed.as_mark()?)));
        let (taken, next) = match mark {
            Some((at, mark)) => (at, Next::Mark(mark)),
            None if count == free.len() => (count, Next::Scan),
            None => (count, Next::Nothing),
        };
        samples.release(taken + mark.is_some() as usize);
        self.buffered += taken;
        self.off |= off;
        next
    }

    /// Takes one conversion and calls `done` with every completed frame.
    #[cfg(any(test, feature = "internals"))]
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

    /// Ends the signal: takes the conversions that are still buffered.
    pub fn finish(&mut self, done: &mut impl FnMut(&Frame)) {
        let buffer = self.buffer;
        let buffered = core::mem::take(&mut self.buffered);
        self.off = 0;
        for timed in buffer.iter().take(buffered) {
            self.take(timed, done);
        }
    }

    /// Makes a frame of the buffer if it holds a flawless scan that follows the previous one at the
    /// expected time. Otherwise returns false, having changed only codes that belong to no frame.
    pub fn try_fast_path(&mut self) -> bool {
        let Self {
            scan, times, frame, ..
        } = self;
        if self.off as u8 != 0 {
            return false;
        }
        let buffer = self.buffer.get(..self.buffered).unwrap_or_default();
        let Times {
            jitter_us,
            step_us,
            span_us: expected_us,
            ..
        } = *times;
        let mut lateness = self.lateness;
        let (Some(first), Some(last), false) = (buffer.first(), buffer.last(), self.has_paused)
        else {
            return false;
        };
        let is_on_time = |passed_us: u32, expected_us: u32| {
            passed_us.wrapping_add(jitter_us).wrapping_sub(expected_us) <= 2 * jitter_us
        };
        let span_us = last.t_us.wrapping_sub(first.t_us);
        let last_us = last.t_us;
        let (number, passed_us) = match self.latest_slot {
            None => (0, 0),
            Some(slot) => {
                let passed_us = first.t_us.wrapping_sub(self.board_us);
                if slot != scan.slots - 1
                    || self.off_time.is_some()
                    || !is_on_time(passed_us, step_us)
                {
                    return false;
                }
                if scan.slots == 1 && lateness.steps(passed_us, scan.conversion_ns) > 1 {
                    return false;
                }
                (frame.number.wrapping_add(1), passed_us)
            }
        };
        if !is_on_time(span_us, expected_us) {
            return false;
        }
        let (taxels, own) = buffer.split_at((scan.channels as usize).min(buffer.len()));
        // No frame is open here, so these codes belong to none.
        let mut clipped = 0;
        if let Ok(taxels) = <&[TimedConversion; TAXELS]>::try_from(taxels) {
            for (place, timed) in frame.codes.iter_mut().zip(taxels) {
                *place = timed.code();
                clipped |= to_clip(timed.bits);
            }
        } else {
            for (taxel, timed) in self.taxels.iter().zip(taxels) {
                frame.codes[*taxel as usize % TAXELS] = timed.code();
                clipped |= to_clip(timed.bits);
            }
        }
        if clipped > CLIPPED {
            return false;
        }
        if let Ok(own) = <&[TimedConversion; OWN]>::try_from(own) {
            self.own = own.map(|timed| Some(timed.code()));
        }
        (self.board_us, self.lateness) = (last_us, lateness);
        self.latest_slot = Some(scan.slots - 1);
        frame.number = number;
        frame.t_us = self.now_us.wrapping_add(passed_us as u64);
        (frame.present, frame.good) = (scan.inputs, scan.inputs);
        self.now_us = frame.t_us.wrapping_add(span_us as u64);
        (self.buffered, self.off) = (0, 0);
        self.frames = self.frames.wrapping_add(1);
        true
    }

    /// Takes the buffered conversions one by one. Conversions after the last slot of a scan stay in
    /// the buffer, so that the next scan can take the fast path.
    pub fn slow_path(&mut self, done: &mut impl FnMut(&Frame)) {
        let (all, buffered) = (self.buffer, core::mem::take(&mut self.buffered));
        self.off = 0;
        let buffer = all.get(..buffered).unwrap_or_default();
        let last_id = self.order.last_id();
        let is_last = |timed: &TimedConversion| timed.tag().id() == last_id;
        let taken = buffer
            .iter()
            .rposition(is_last)
            .map_or(buffer.len(), |last| last + 1);
        for (at, timed) in buffer.iter().enumerate() {
            if at < taken {
                self.take(timed, done);
            } else {
                self.buffer(timed);
            }
        }
    }

    /// Takes one conversion, flawless or not.
    fn take(&mut self, timed: &TimedConversion, done: &mut impl FnMut(&Frame)) {
        let (tag, code, t_us) = (timed.tag(), timed.code(), timed.t_us);
        let own = own_of(tag.id());
        let Some(slot) = self.order.slot_of(tag.id()).filter(|_| tag.is_new()) else {
            if let (Some(own), true, true) =
                (own, tag.is_new(), self.scan.slots == self.scan.channels)
            {
                // The plan's scan was interrupted for this health reading.
                if let Some(place) = self.own.get_mut(own) {
                    *place = Some(code);
                }
                self.flaws.supply += tag.is_supply_low() as u32;
                self.has_paused = true;
                return;
            }
            self.doubtful = self.doubtful.saturating_add(1);
            let flaw = if tag.is_new() {
                &mut self.flaws.channel
            } else {
                &mut self.flaws.repeated
            };
            *flaw = flaw.saturating_add(1);
            return;
        };
        let taxel = tag.id().wrapping_sub(Tag::FIRST_INPUT) as usize % TAXELS;
        let is_clean = !tag.is_overload() && !tag.is_supply_low();
        self.flaws.supply += tag.is_supply_low() as u32;
        self.flaws.overload += (tag.is_overload() || own.is_none() && is_clipped(code)) as u32;
        self.doubtful = self.doubtful.saturating_add(!is_clean as u32);

        let scans = self.advance(slot, t_us);
        if scans > 0 {
            self.give(done);
            self.frame.number = self.frame.number.wrapping_add(scans);
            self.frame.t_us = self
                .now_us
                .saturating_sub(divide(slot as u64 * self.scan.slot_ns() as u64, 1000).0);
            (self.frame.present, self.frame.good) = (0, 0);
        }
        self.is_open = true;
        match own.and_then(|own| self.own.get_mut(own)) {
            Some(own) => *own = Some(code),
            None => {
                self.frame.codes[taxel] = code;
                self.frame.present |= 1 << taxel;
                self.frame.good |= ((is_clean && !is_clipped(code)) as u16) << taxel;
            }
        }
        if slot == self.scan.slots - 1 {
            self.give(done);
        }
    }

    /// Moves on to `slot` at board time `t_us` and counts the losses before it. Returns the number
    /// of scans from the latest conversion's to this one's.
    fn advance(&mut self, slot: u32, t_us: u32) -> u32 {
        let passed_us = t_us.wrapping_sub(self.board_us);
        self.board_us = t_us;
        let has_paused = core::mem::take(&mut self.has_paused);
        let Some(before) = self.latest_slot.replace(slot) else {
            self.lost = slot;
            self.flaws.lost = slot;
            return 0;
        };
        self.now_us = self.now_us.wrapping_add(passed_us as u64);
        let Scan {
            slots,
            conversion_ns,
            sampling,
            ..
        } = self.scan;
        if has_paused {
            self.lost = self.lost.saturating_add(slot);
            self.flaws.lost = self.flaws.lost.saturating_add(slot);
            // The scan restarts at its first slot, a fraction of a scan late: round to whole scans.
            (self.off_time, self.lateness) = (None, ServiceDelay::NONE);
            let frame_us = (self.scan.frame_ns() / 1000).max(1);
            return (passed_us.saturating_add(frame_us / 2) / frame_us).max(1);
        }
        let (mut scans, mut lost_by_time) = ((slot <= before) as u32, 0);
        if slots == 1 {
            scans = self.lateness.steps(passed_us, conversion_ns);
        } else if passed_us > self.times.gap_us {
            // Add the whole scans that bring the count of slots nearest to the time that passed.
            let by_time = divide(passed_us as u64 * 1000, conversion_ns).0 as u32;
            let by_order = match sampling {
                Sampling::InTurn => scans * slots + slot - before,
                Sampling::AtOnce => scans * slots,
            };
            scans += (by_time.saturating_sub(by_order) + slots / 2) / slots.max(1);
            if sampling == Sampling::InTurn {
                // A chip that was set up again restarts its scan, so the ids may show fewer losses
                // than the time.
                lost_by_time = by_time;
            }
        }
        let whole = scans.saturating_mul(slots);
        let steps = whole.saturating_add(slot).saturating_sub(before);
        let lost = steps.max(lost_by_time).saturating_sub(1);
        self.lost = self.lost.saturating_add(lost);
        self.flaws.lost = self.flaws.lost.saturating_add(lost);
        let timed_steps = match sampling {
            Sampling::InTurn => steps,
            Sampling::AtOnce => whole,
        };
        self.check_time(passed_us, timed_steps, steps > 1);
        scans
    }

    /// Checks that `steps` steps of the scan fit the time that passed. If the chip paused or
    /// restarted its scan, all later conversions deviate from the times that the fit assumes, which
    /// is a flaw. A single late time stamp is not: the next conversion is on time again.
    fn check_time(&mut self, passed_us: u32, steps: u32, has_gap: bool) {
        let expected_us = divide(steps as u64 * self.scan.conversion_ns as u64, 1000).0 as u32;
        let before = self.off_time.take();
        let late_us = (passed_us.wrapping_sub(expected_us) as i32)
            .saturating_add(before.map_or(0, |before| before.late_us));
        let has_gap = has_gap || before.is_some_and(|before| before.has_gap);
        // Allow 122 ppm for the difference of the two crystals over a long gap.
        if late_us.unsigned_abs() <= self.times.jitter_us + (passed_us >> 13) {
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

/// Tags of a flawless scan in its order, and its taxels.
const fn table(order: Order, scan: &Scan) -> ([u8; SLOTS_MAX], [u8; TAXELS]) {
    let (mut statuses, mut taxels, mut status, mut slot) =
        ([0; SLOTS_MAX], [0; TAXELS], order.first(), 0);
    while slot < scan.slots as usize && slot < SLOTS_MAX {
        statuses[slot] = status & !Tag::NEW | FLAWLESS;
        if slot < scan.channels as usize && slot < TAXELS {
            taxels[slot] = (status & !Tag::NEW) - Tag::FIRST_INPUT;
        }
        (status, slot) = (order.next_status(status), slot + 1);
    }
    (statuses, taxels)
}

/// True if a code is at either end of the scale, where the chip clips (SBAS297G: 800000h and
/// 7FFFFFh).
const fn is_clipped(code: i32) -> bool {
    to_clip((code as u32) << 8) > CLIPPED
}

/// See [`to_clip`].
const CLIPPED: u32 = 0x7fff_ffff;

/// Above [`CLIPPED`] if a conversion's code, in the upper three bytes, is clipped. The results of
/// several may be joined by `|`.
const fn to_clip(bits: u32) -> u32 {
    // Distance of a code from zero, or from minus one, plus one.
    (bits ^ (bits as i32 >> 31) as u32) + 0x100
}

#[cfg(test)]
mod tests;
