//! Conversions in, 16-channel frames out, by the chip's own channel id.
//!
//! Channels are never counted: the chip says which one each conversion is. A gap in their order is
//! a loss, and when it spans whole scans the time stamps say how many. They wrap after 71.6 minutes: of
//! a gap longer than that only the rest beyond whole wraps is seen.
//!
//! Conversions wait until their scan is over. Most scans are whole and without a flaw: that is seen at one
//! glance, and their conversions take a few instructions each. Those of any other scan take the long way,
//! one by one.

use crate::settings::{SCAN, TAXELS};
use ads1258::{Channel, Conversion, Status, reading};

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
    /// Number of the scan since the first conversion, counting those that were lost.
    pub number: u32,
    /// Device time of its first slot, microseconds since the first conversion.
    pub t_us: u64,
    /// One code per slot; see [`Self::taxels`].
    codes: Codes,
    /// Bit k: taxel k was converted and read.
    pub present: u16,
    /// Bit k: its conversion carried neither OVF nor SUPPLY, and is not at the end of the scale.
    pub good: u16,
}

impl Frame {
    /// The codes of the taxels; of those that are not present anything.
    pub fn taxels(&self) -> &[i32; TAXELS] {
        // Always there.
        self.codes.first_chunk().unwrap_or(&[0; TAXELS])
    }
}

/// Places for what a scan has one of for every slot. A few more than slots: what is masked to so many stays
/// within without a check.
const PLACES: usize = SLOTS.next_power_of_two() as usize;

/// The codes of a scan.
type Codes = [i32; PLACES];

/// The chip's own readings, as of the latest scan that had them; zero before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Readings {
    /// Analogue supply, volts (datasheet: code / 786432).
    pub supply_v: f32,
    /// Reference, volts (datasheet: code / 786432).
    pub reference_v: f32,
    /// Chip temperature, degrees Celsius.
    pub temperature_c: f32,
    /// Offset, volts, ideally 0.
    pub offset_v: f32,
    /// Gain, ideally 1.
    pub gain: f32,
}

/// Lower end of the scale, where the chip clips as it does at the upper one (datasheet: 800000h and 7FFFFFh).
const CODE_LEAST: i32 = -0x80_0000;

/// Slots of one scan.
pub const SLOTS: u32 = SCAN.slots() as u32;

/// A conversion's period at the nominal clock, nanoseconds.
pub const CONVERSION_NS: u64 = SCAN.conversion_ticks() as u64 * 1_000_000_000 / SCAN.clock_hz as u64;

/// A gap in time above which whole scans may be missing: half a scan, microseconds.
const GAP_US: u32 = (CONVERSION_NS * SLOTS as u64 / 2000) as u32;

/// The scan begins with the taxels in their order: taxel k is slot k.
const _: () = assert!(SCAN.channel_mask() & 0x00ff_ffff == 0x00ff_ff00);

/// Ids that a status byte can name.
const IDS: usize = 32;

/// Slot of every channel id, in the order of the scan.
const SLOT_OF: [Option<u8>; IDS] = {
    let mut slots = [None; IDS];
    let mask = SCAN.channel_mask();
    let (mut id, mut slot) = (0, 0);
    while id < IDS {
        if mask & 1 << id != 0 {
            slots[id] = Some(slot);
            slot += 1;
        }
        id += 1;
    }
    slots
};

/// Id of every slot.
const ID_OF: [u8; SLOTS as usize] = {
    let mut ids = [0; SLOTS as usize];
    let mut id = 0;
    while id < IDS {
        if let Some(slot) = SLOT_OF[id] {
            ids[slot as usize] = id as u8;
        }
        id += 1;
    }
    ids
};

/// Status of a conversion without a flaw, but for its id (datasheet: NEW and no other flag).
const FLAWLESS: u32 = 0x80;
/// Status of a scan's last conversion, if it has no flaw.
const LAST: u32 = FLAWLESS | ID_OF[SLOTS as usize - 1] as u32;
/// Time from the first to the last conversion of a scan, at most, for none in between to be later than
/// [`GAP_US`]: the nominal one and half of that.
const SPAN_US: u32 = (CONVERSION_NS * (SLOTS as u64 - 1) / 1000) as u32 + GAP_US / 2;

/// Puts frames together.
#[derive(Clone, Debug)]
pub struct Assembler {
    vref_v: f32,
    /// Times and status bytes of the conversions that wait for their scan's last one. Their codes wait in
    /// the frame, where those of a scan that is whole belong.
    times_us: [u32; PLACES],
    statuses: [u32; PLACES],
    /// How many they are.
    count: usize,
    /// Slot of the latest conversion that was dealt with; none before the first.
    latest: Option<u32>,
    /// Its raw time.
    latest_us: u32,
    /// Its device time.
    t_us: u64,
    frame: Frame,
    /// The latest codes of the chip's own readings, at their slots.
    own: Codes,
    /// Bit k: slot k has been read at least once.
    read: u32,
    /// Whether `frame` holds anything that was not given yet.
    open: bool,
    /// Frames given so far.
    pub frames: u32,
    /// Conversions that never came.
    pub lost: u32,
    /// Conversions that came but with OVF, SUPPLY, without NEW, or of a channel outside the scan.
    pub doubtful: u32,
}

impl Assembler {
    /// An assembler that has seen nothing. `vref_v` is the reference, volts.
    pub const fn new(vref_v: f32) -> Self {
        Self {
            vref_v,
            times_us: [0; PLACES],
            statuses: [0; PLACES],
            count: 0,
            latest: None,
            latest_us: 0,
            t_us: 0,
            frame: Frame { number: 0, t_us: 0, codes: [0; PLACES], present: 0, good: 0 },
            own: [0; PLACES],
            read: 0,
            open: false,
            frames: 0,
            lost: 0,
            doubtful: 0,
        }
    }

    /// Device time of the latest conversion, microseconds since the first.
    pub const fn now_us(&self) -> u64 {
        self.t_us
    }

    /// The chip's own readings.
    pub fn readings(&self) -> Readings {
        let code = |channel: Channel| {
            let slot = SLOT_OF[channel.id() as usize % IDS]?;
            let code = self.own.get(slot as usize).copied()?;
            (self.read & 1 << slot != 0).then_some(code)
        };
        Readings {
            supply_v: code(Channel::Vcc).map_or(0.0, reading::supply_v),
            reference_v: code(Channel::Ref).map_or(0.0, reading::reference_v),
            temperature_c: code(Channel::Temp).map_or(0.0, |code| reading::temperature_c(code, self.vref_v)),
            offset_v: code(Channel::Offset).map_or(0.0, |code| reading::offset_v(code, self.vref_v)),
            gain: code(Channel::Gain).map_or(0.0, reading::gain),
        }
    }

    /// Takes one conversion; `done` is called with every frame that is over.
    pub fn push(&mut self, timed: &TimedConversion, mut done: impl FnMut(&Self, &Frame)) {
        if !self.wait(timed) {
            return;
        }
        if self.whole() {
            done(self, self.frame());
        } else {
            self.deal_one_by_one(&mut done);
        }
    }

    /// Puts a conversion to those that wait. True if they are to be dealt with.
    #[inline(always)]
    pub fn wait(&mut self, timed: &TimedConversion) -> bool {
        let TimedConversion { t_us, conversion: Conversion { status, code } } = *timed;
        let at = self.count % PLACES;
        self.times_us[at] = t_us;
        self.statuses[at] = status.0 as u32;
        self.frame.codes[at] = code;
        self.count = at + 1;
        status.0 as u32 == LAST || self.count == SLOTS as usize
    }

    /// The latest frame.
    pub const fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Takes what waits as a frame, if it is a whole scan without a flaw that follows the one before it. False,
    /// with nothing done, if it is not.
    #[inline(always)]
    pub fn whole(&mut self) -> bool {
        let (begin_us, end_us) = (self.times_us[0], self.times_us[SLOTS as usize - 1]);
        let (passed_us, scans) = match self.latest {
            Some(_) => (begin_us.wrapping_sub(self.latest_us), 1),
            None => (0, 0),
        };
        if self.count != SLOTS as usize
            || self.latest.is_some_and(|latest| latest != SLOTS - 1)
            || passed_us > GAP_US
            || end_us.wrapping_sub(begin_us) > SPAN_US
        {
            return false;
        }
        let (mut odd, mut ends) = (0, 0);
        for (status, id) in self.statuses.iter().zip(ID_OF) {
            odd |= status ^ (FLAWLESS | id as u32);
        }
        for code in self.frame.taxels() {
            ends |= beyond(*code);
        }
        if odd != 0 || ends >= -CODE_LEAST {
            return false;
        }
        for slot in TAXELS..SLOTS as usize {
            self.own[slot] = self.frame.codes[slot];
        }
        self.read = u32::MAX;
        self.latest = Some(SLOTS - 1);
        self.frame.number = self.frame.number.wrapping_add(scans);
        self.frame.t_us = self.t_us.wrapping_add(passed_us as u64);
        (self.frame.present, self.frame.good) = (u16::MAX, u16::MAX);
        self.t_us = self.frame.t_us.wrapping_add(end_us.wrapping_sub(begin_us) as u64);
        self.latest_us = end_us;
        self.count = 0;
        self.frames = self.frames.saturating_add(1);
        true
    }

    /// Deals with the conversions that wait, and with each by itself.
    #[inline(never)]
    pub fn deal_one_by_one(&mut self, done: &mut impl FnMut(&Self, &Frame)) {
        let (codes, count) = (self.frame.codes, core::mem::take(&mut self.count));
        self.frame.codes = self.own;
        for ((code, status), t_us) in codes.into_iter().zip(self.statuses).zip(self.times_us).take(count) {
            let conversion = Conversion { status: Status(status as u8), code };
            self.take(&TimedConversion { t_us, conversion }, done);
        }
        self.own = self.frame.codes;
    }

    /// Takes any conversion.
    fn take(&mut self, timed: &TimedConversion, done: &mut impl FnMut(&Self, &Frame)) {
        let TimedConversion { t_us, conversion: Conversion { status, code } } = *timed;
        let Some(slot) = SLOT_OF[status.chid() as usize % IDS].filter(|_| status.is_new()) else {
            self.doubtful = self.doubtful.saturating_add(1);
            return;
        };
        let clean = !status.is_overflow() && !status.is_supply_low();
        self.doubtful = self.doubtful.saturating_add(!clean as u32);

        let scans = self.advance(slot as u32, t_us);
        if scans > 0 {
            self.give(done);
            self.frame.number = self.frame.number.wrapping_add(scans);
            self.frame.t_us = self.t_us.saturating_sub((slot as u32 * CONVERSION_NS as u32 / 1000) as u64);
            (self.frame.present, self.frame.good) = (0, 0);
        }
        self.open = true;
        if let Some(place) = self.frame.codes.get_mut(slot as usize) {
            *place = code;
        }
        let bit = 1u32 << slot;
        self.read |= bit;
        self.frame.present |= bit as u16;
        if clean && beyond(code) < -CODE_LEAST {
            self.frame.good |= bit as u16;
        }
        if bit << 1 == 1 << SLOTS {
            self.give(done);
        }
    }

    /// Moves on to `slot` at raw time `t_us` and counts what was lost on the way. Returns how many
    /// scans later it is than the one under way.
    fn advance(&mut self, slot: u32, t_us: u32) -> u32 {
        let Some(before) = self.latest.replace(slot) else {
            self.latest_us = t_us;
            self.lost = slot;
            return 0;
        };
        let passed_us = t_us.wrapping_sub(self.latest_us);
        self.latest_us = t_us;
        self.t_us = self.t_us.wrapping_add(passed_us as u64);
        let mut scans = (slot <= before) as u32;
        if passed_us > GAP_US {
            // As many whole scans more as bring the count of slots nearest to the time that passed.
            // In two parts that 32 bits hold: a division of 64 bits is a kilobyte of code on the chip.
            const NS: u32 = CONVERSION_NS as u32;
            let by_time = passed_us / NS * 1000 + passed_us % NS * 1000 / NS;
            let by_order = scans * SLOTS + slot - before;
            scans += (by_time.saturating_sub(by_order) + SLOTS / 2) / SLOTS;
        }
        let steps = scans.saturating_mul(SLOTS).saturating_add(slot).saturating_sub(before);
        self.lost = self.lost.saturating_add(steps.saturating_sub(1));
        scans
    }

    fn give(&mut self, done: &mut impl FnMut(&Self, &Frame)) {
        if core::mem::take(&mut self.open) {
            self.frames = self.frames.saturating_add(1);
            done(self, &self.frame);
        }
    }
}

/// How far a code is from zero, and one more; what is beyond the scale or at its end has the sign bit of a
/// 24-bit number or a higher one.
const fn beyond(code: i32) -> i32 {
    // A negative code's complement is as far from the lower end as it is from the upper one.
    (code ^ code >> 31) + 1
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::vec::Vec;

    /// The scan's channel ids as the datasheet orders them.
    const IDS: [u8; 21] = [8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 26, 27, 28, 29];

    fn conversion(count: u32, flags: u8) -> TimedConversion {
        let slot = count as usize % 21;
        let t_us = (count as u64 * 3106 * 1_000_000 / 15_728_640) as u32;
        let code = if slot < 16 { count as i32 } else { [3, 3_932_160, 1_677_722, 7_864_320, 3_221_225][slot - 16] };
        TimedConversion { t_us, conversion: Conversion { status: Status(flags | IDS[slot]), code } }
    }

    fn run(counts: impl Iterator<Item = u32>, start_us: u32) -> (Assembler, Vec<Frame>) {
        let mut assembler = Assembler::new(4.096);
        let mut frames = Vec::new();
        for count in counts {
            let mut timed = conversion(count, 0x80);
            timed.t_us = timed.t_us.wrapping_add(start_us);
            assembler.push(&timed, |_, frame| frames.push(*frame));
        }
        (assembler, frames)
    }

    #[test]
    fn whole_scans_become_frames_and_readings() {
        let (assembler, frames) = run(0..63, u32::MAX - 3000);
        assert_eq!(frames.len(), 3);
        for (n, frame) in frames.iter().enumerate() {
            assert_eq!((frame.number, frame.present, frame.good), (n as u32, 0xffff, 0xffff));
            assert_eq!(frame.taxels()[5], n as i32 * 21 + 5);
            // Frame period by the datasheet's formula: 21 x 3106 / 15.72864 MHz.
            assert!((frame.t_us as f64 - n as f64 * 4146.957).abs() < 2.0, "{}", frame.t_us);
        }
        assert_eq!((assembler.lost, assembler.doubtful), (0, 0));
        let r = assembler.readings();
        assert_eq!((r.supply_v, r.gain), (5.0, 1.0));
        assert!((r.reference_v - 4.096).abs() < 1e-5);
        // 1677722 codes of 4.096 V / 7864320 are 873.8 mV: (873813 - 168000) / 394 + 25 degrees.
        assert!((r.temperature_c - 1816.4).abs() < 1.0, "{}", r.temperature_c);
    }

    #[test]
    fn a_lost_conversion_leaves_its_taxel_out() {
        let (assembler, frames) = run((0..63).filter(|c| *c != 21 + 7), 0);
        assert_eq!(frames.len(), 3);
        assert_eq!(frames[1].present, !(1 << 7));
        assert_eq!(assembler.lost, 1);
    }

    #[test]
    fn a_loss_across_the_scans_border_ends_the_frame() {
        let (assembler, frames) = run((0..63).filter(|c| !(18..24).contains(c)), 0);
        assert_eq!(frames.iter().map(|f| f.number).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(frames[1].present, !0b111);
        assert_eq!(assembler.lost, 6);
    }

    #[test]
    fn whole_scans_lost_are_counted_by_time() {
        for gap in [21, 42, 210, 21 * 241, 5, 30] {
            let (assembler, frames) = run((0..5000 + 21 * 300).filter(|c| !(500..500 + gap).contains(c)), 0);
            assert_eq!(assembler.lost, gap, "{gap}");
            assert_eq!(frames.last().unwrap().number, (5000 + 21 * 300) / 21 - 1, "{gap}");
        }
    }

    #[test]
    fn flags_and_strangers_are_told() {
        let mut assembler = Assembler::new(4.096);
        let mut frames = Vec::new();
        for count in 0..21 {
            let flags = match count {
                3 => 0xc0,
                4 => 0xa0,
                5 => 0x00,
                _ => 0x80,
            };
            assembler.push(&conversion(count, flags), |_, frame| frames.push(*frame));
        }
        let stranger = Conversion { status: Status(0x80 | 0x19), code: 1 };
        assembler.push(&TimedConversion { t_us: 4200, conversion: stranger }, |_, frame| frames.push(*frame));
        assembler.deal_one_by_one(&mut |_: &Assembler, frame: &Frame| frames.push(*frame));
        assert_eq!(frames.len(), 1);
        assert_eq!(frames[0].good, !0b11_1000);
        assert_eq!(frames[0].present, !0b10_0000);
        assert_eq!(assembler.doubtful, 4);
        assert_eq!(assembler.lost, 1);
    }

    #[test]
    fn the_ends_of_the_scale_are_not_good() {
        let mut assembler = Assembler::new(4.096);
        let mut good = 0;
        for count in 0..21 {
            let mut timed = conversion(count, 0x80);
            timed.conversion.code = [0x7f_ffff, -0x80_0000, 0x7f_fffe, -0x7f_ffff][count.min(3) as usize];
            assembler.push(&timed, |_, frame| good = frame.good);
        }
        assert_eq!(good, !0b11);
    }
}
