//! Conversions in, 16-channel frames out, by the chip's own channel id.
//!
//! Channels are never counted: the chip says which one each conversion is. A gap in their order is
//! a loss, and when it spans whole scans the time stamps say how many. They wrap after 71.6 minutes: of
//! a gap longer than that only the rest beyond whole wraps is seen.

use crate::settings::{SCAN, TAXELS};
use ads1258::{Channel, reading};

/// One conversion with the time of its DRDY edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimedConversion {
    /// Time of the falling edge of DRDY on the board's microsecond counter, wrapping.
    pub t_us: u32,
    /// Status byte and 24-bit code as read.
    pub conversion: ads1258::Conversion,
}

/// One scan of the taxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Number of the scan since the first conversion, counting those that were lost.
    pub number: u32,
    /// Device time of its first slot, microseconds since the first conversion.
    pub t_us: u64,
    /// One code per taxel, zero where `present` says that there is none.
    pub codes: [i32; TAXELS],
    /// Bit k: taxel k was converted and read.
    pub present: u16,
    /// Bit k: its conversion carried neither OVF nor SUPPLY, and is not at the end of the scale.
    pub good: u16,
}

/// The chip's own readings, as of the latest scan that had them.
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

/// Ends of the scale, where the chip clips (datasheet: 800000h and 7FFFFFh).
const CODE_LEAST: i32 = -0x80_0000;
/// See [`CODE_LEAST`].
const CODE_GREATEST: i32 = 0x7f_ffff;

/// Slots of one scan.
pub const SLOTS: u32 = SCAN.slots() as u32;

/// A conversion's period at the nominal clock, nanoseconds.
pub const CONVERSION_NS: u64 = SCAN.conversion_ticks() as u64 * 1_000_000_000 / SCAN.clock_hz as u64;

/// A gap in time above which whole scans may be missing: half a scan, microseconds.
const GAP_US: u32 = (CONVERSION_NS * SLOTS as u64 / 2000) as u32;

/// Slot of every channel id, in the order of the scan.
const SLOT_OF: [Option<u8>; 32] = {
    let mut slots = [None; 32];
    let mask = SCAN.channel_mask();
    let (mut id, mut slot) = (0, 0);
    while id < 32 {
        if mask & 1 << id != 0 {
            slots[id] = Some(slot);
            slot += 1;
        }
        id += 1;
    }
    slots
};

/// Puts frames together.
#[derive(Clone, Debug)]
pub struct Assembler {
    vref_v: f32,
    /// Slot and raw time of the latest conversion; none before the first.
    latest: Option<(u8, u32)>,
    t_us: u64,
    frame: Frame,
    /// Whether `frame` holds anything that was not given yet.
    open: bool,
    /// The chip's own readings.
    pub readings: Readings,
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
            latest: None,
            t_us: 0,
            frame: Frame { number: 0, t_us: 0, codes: [0; TAXELS], present: 0, good: 0 },
            open: false,
            readings: Readings { supply_v: 0.0, reference_v: 0.0, temperature_c: 0.0, offset_v: 0.0, gain: 0.0 },
            frames: 0,
            lost: 0,
            doubtful: 0,
        }
    }

    /// Device time of the latest conversion, microseconds since the first.
    pub const fn now_us(&self) -> u64 {
        self.t_us
    }

    /// Takes one conversion; `done` is called with a frame when its scan is over.
    pub fn push(&mut self, timed: &TimedConversion, mut done: impl FnMut(&Self, &Frame)) {
        let status = timed.conversion.status;
        let slot = SLOT_OF.get(status.chid() as usize).copied().flatten();
        let Some(slot) = slot.filter(|_| status.is_new()) else {
            self.doubtful = self.doubtful.saturating_add(1);
            return;
        };
        let clean = !status.is_overflow() && !status.is_supply_low();
        self.doubtful = self.doubtful.saturating_add(!clean as u32);

        let scans = self.advance(slot, timed.t_us);
        if scans > 0 {
            self.give(&mut done);
            let t_us = self.t_us.saturating_sub(slot as u64 * CONVERSION_NS / 1000);
            let number = self.frame.number.wrapping_add(scans);
            self.frame = Frame { number, t_us, codes: [0; TAXELS], present: 0, good: 0 };
        }
        self.open = true;
        match status.channel() {
            Some(Channel::Single(taxel)) => self.store(taxel, timed.conversion.code, clean),
            Some(channel) => self.read(channel, timed.conversion.code),
            None => {}
        }
        if slot as u32 + 1 == SLOTS {
            self.give(&mut done);
        }
    }

    /// Moves on to `slot` at raw time `t_us` and counts what was lost on the way. Returns how many
    /// scans later it is than the one under way.
    fn advance(&mut self, slot: u8, t_us: u32) -> u32 {
        let Some((before, t_before)) = self.latest.replace((slot, t_us)) else {
            self.lost = slot as u32;
            return 0;
        };
        let passed_us = t_us.wrapping_sub(t_before);
        self.t_us = self.t_us.wrapping_add(passed_us as u64);
        let mut scans = (slot <= before) as u32;
        if passed_us > GAP_US {
            // As many whole scans more as bring the count of slots nearest to the time that passed.
            let by_time = (passed_us as u64 * 1000 / CONVERSION_NS) as u32;
            let by_order = scans * SLOTS + slot as u32 - before as u32;
            scans += (by_time.saturating_sub(by_order) + SLOTS / 2) / SLOTS;
        }
        let steps = scans.saturating_mul(SLOTS).saturating_add(slot as u32).saturating_sub(before as u32);
        self.lost = self.lost.saturating_add(steps.saturating_sub(1));
        scans
    }

    fn store(&mut self, taxel: u8, code: i32, clean: bool) {
        if let Some(place) = self.frame.codes.get_mut(taxel as usize) {
            *place = code;
            self.frame.present |= 1 << taxel;
            let in_scale = code > CODE_LEAST && code < CODE_GREATEST;
            self.frame.good |= ((clean && in_scale) as u16) << taxel;
        }
    }

    fn read(&mut self, channel: Channel, code: i32) {
        let readings = &mut self.readings;
        match channel {
            Channel::Offset => readings.offset_v = reading::offset_v(code, self.vref_v),
            Channel::Vcc => readings.supply_v = reading::supply_v(code),
            Channel::Temp => readings.temperature_c = reading::temperature_c(code, self.vref_v),
            Channel::Gain => readings.gain = reading::gain(code),
            Channel::Ref => readings.reference_v = reading::reference_v(code),
            Channel::Single(_) | Channel::Differential(_) => {}
        }
    }

    fn give(&mut self, done: &mut impl FnMut(&Self, &Frame)) {
        if core::mem::take(&mut self.open) {
            self.frames = self.frames.saturating_add(1);
            done(self, &self.frame);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ads1258::{Conversion, Status};
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
            assert_eq!(frame.codes[5], n as i32 * 21 + 5);
            // Frame period by the datasheet's formula: 21 x 3106 / 15.72864 MHz.
            assert!((frame.t_us as f64 - n as f64 * 4146.957).abs() < 2.0, "{}", frame.t_us);
        }
        assert_eq!((assembler.lost, assembler.doubtful), (0, 0));
        let r = assembler.readings;
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
        assert_eq!(frames.len(), 1);
        assert_eq!(frames[0].good, !0b11_1000);
        assert_eq!(frames[0].present, !0b10_0000);
        assert_eq!(assembler.doubtful, 4);
        assert_eq!(assembler.lost, 1);
    }

    #[test]
    fn the_ends_of_the_scale_are_not_good() {
        let mut assembler = Assembler::new(4.096);
        for (count, code) in [(0, 0x7f_ffff), (1, -0x80_0000), (2, 0x7f_fffe)] {
            let mut timed = conversion(count, 0x80);
            timed.conversion.code = code;
            assembler.push(&timed, |_, _| ());
        }
        assert_eq!(assembler.frame.good, 0b100);
    }
}
