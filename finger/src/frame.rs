//! Conversions in, 16-channel frames out, by the chip's own channel id.
//!
//! Channels are never counted: the chip says which one each conversion is. A gap in their order is
//! a loss, and when it spans whole scans the time stamps say how many. They wrap after 71.6 minutes: of
//! a gap longer than that only the rest beyond whole wraps is seen.
//!
//! Conversions wait until there are as many as a scan has. Most scans are whole and without a flaw: that is seen at one
//! glance, and their conversions take a few instructions each. Those of any other scan take the long way,
//! one by one.

mod fast_path;
mod slow_path;

use ads1258::{Channel, Conversion, reading};
use ridgetone_proto::settings::{SCAN, TAXELS};
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
    /// Number of the scan since the first conversion, counting those that were lost.
    pub number: u32,
    /// Device time of its first slot, microseconds since the first conversion.
    pub t_us: u64,
    /// One code per slot, from [`FIRST`] on; see [`Self::taxels`].
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
        self.codes.split_at(FIRST).1.first_chunk().unwrap_or(&[0; TAXELS])
    }

    /// Puts the codes of the taxels that can be trusted, less their references, in their places in `values`.
    // Not in the caller, which is compiled for size.
    #[inline(never)]
    pub fn put(&self, reference: &Values, values: &mut Values) {
        let codes = self.taxels();
        // Exact: codes have 24 bits.
        let value = |c: usize| codes[c] as f32 - reference[c];
        if self.good == u16::MAX {
            for c in 0..TAXELS {
                values[c] = value(c);
            }
        } else {
            for c in (0..TAXELS).filter(|c| self.good & 1 << c != 0) {
                values[c] = value(c);
            }
        }
    }
}

/// Places for what a scan has one of for every slot. A few more than slots: what is masked to so many stays
/// within without a check.
const PLACES: usize = SLOTS.next_power_of_two() as usize;

/// Place of the first slot: the last slot's is the last one.
const FIRST: usize = PLACES - SLOTS as usize;

/// The number of the next place is kept in so many of the highest bits: it needs no mask, and becomes zero behind the last
/// place, which the addition itself tells. Both count, for every conversion.
const PLACE_SHIFT: u32 = u32::BITS - PLACES.ilog2();

/// The first place, in those bits.
const FIRST_NEXT: u32 = (FIRST as u32) << PLACE_SHIFT;

/// The codes of a scan.
type Codes = [i32; PLACES];

/// The chip's own readings, as of the latest scan that had them; zero before.
#[derive(Clone, Copy, Debug, PartialEq)]
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

impl Readings {
    /// Before there are any.
    pub const NONE: Self = Self { supply_v: 0.0, reference_v: 0.0, temperature_c: 0.0, offset_v: 0.0, gain: 0.0 };
}

/// How many they are: every slot behind the taxels'.
pub const OWN: usize = SLOTS as usize - TAXELS;

/// Lower end of the scale, where the chip clips as it does at the upper one (datasheet: 800000h and 7FFFFFh).
const CODE_LEAST: i32 = -0x80_0000;

/// Slots of one scan.
pub const SLOTS: u32 = SCAN.slots() as u32;

/// A conversion's period at the nominal clock, nanoseconds.
pub const CONVERSION_NS: u64 = SCAN.conversion_ticks() as u64 * 1_000_000_000 / SCAN.clock_hz as u64;

/// A gap in time above which whole scans may be missing: half a scan, microseconds.
const GAP_US: u32 = (CONVERSION_NS * SLOTS as u64 / 2000) as u32;

/// The scan begins with the taxels in their order: taxel k is slot k. What follows are the chip's own readings.
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

/// Slot of a channel of the scan. In constants only: what is wrong is so when it is compiled.
#[allow(clippy::panic)]
const fn slot_of(channel: Channel) -> usize {
    match SLOT_OF[channel.id() as usize] {
        Some(slot) => slot as usize,
        None => panic!("the scan lacks a channel"),
    }
}

const SUPPLY: usize = slot_of(Channel::Vcc);
const REFERENCE: usize = slot_of(Channel::Ref);

/// Id of a scan's last slot.
const LAST_ID: u8 = ID_OF[SLOTS as usize - 1];

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

/// How far from its time a conversion may be, microseconds: what an interrupt may be late by, and 1 % of a scan.
const JITTER_US: u32 = 50;

/// What was wrong with conversions that were dealt with one by one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flaws {
    /// Conversions that never came, by the ids and by the time.
    pub lost: u32,
    /// Conversions without NEW.
    pub repeated: u32,
    /// Ids that are not of the scan, or that follow too soon or too late for what was left out.
    pub channel: u32,
    /// SUPPLY was set.
    pub supply: u32,
    /// The next id came, but too soon or too late: the conversions that follow are not where they should be.
    pub clock: u32,
    /// OVF was set, or the code is at the end of the scale.
    pub overload: u32,
}

/// What `latest` is before the first conversion.
const NONE_YET: u32 = u32::MAX;

/// Puts frames together.
#[derive(Clone, Debug)]
pub struct Assembler {
    vref_v: f32,
    /// Times and status bytes of the conversions that wait until there are a scan of them. Their codes wait in
    /// the frame, where those of a scan that is whole belong.
    times_us: [u32; PLACES],
    statuses: [u8; PLACES],
    /// The place of the next one, in the highest bits; [`PLACE_SHIFT`].
    next: u32,
    /// Slot of the latest conversion that was dealt with, or [`NONE_YET`]. With `suspected` it is made up so that no
    /// scan seems to follow it.
    latest: u32,
    /// The latest conversion came so much too late, microseconds, and whether others were left out before it. If the
    /// next is as late, the chip is; if not, only its time was noted late.
    suspected: Option<(i32, bool)>,
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
    /// Frames given so far; wraps, as their numbers do, after 206 days.
    pub frames: u32,
    /// Conversions that never came.
    pub lost: u32,
    /// Conversions that came but with OVF, SUPPLY, without NEW, or of a channel outside the scan.
    pub doubtful: u32,
    /// What was wrong since somebody took this.
    pub flaws: Flaws,
}

impl Assembler {
    /// An assembler that has seen nothing. `vref_v` is the reference, volts.
    pub const fn new(vref_v: f32) -> Self {
        let mut own = [0; PLACES];
        own[FIRST + SUPPLY] = 5 * reading::CODES_PER_SUPPLY_VOLT;
        own[FIRST + REFERENCE] = (vref_v * reading::CODES_PER_SUPPLY_VOLT as f32) as i32;
        Self {
            vref_v,
            times_us: [0; PLACES],
            statuses: [0; PLACES],
            next: FIRST_NEXT,
            latest: NONE_YET,
            suspected: None,
            latest_us: 0,
            t_us: 0,
            frame: Frame { number: 0, t_us: 0, codes: [0; PLACES], present: 0, good: 0 },
            own,
            read: 0,
            open: false,
            frames: 0,
            lost: 0,
            doubtful: 0,
            flaws: Flaws { lost: 0, repeated: 0, channel: 0, supply: 0, clock: 0, overload: 0 },
        }
    }

    /// From now on the reference has so many volts.
    pub const fn set_reference(&mut self, vref_v: f32) {
        self.vref_v = vref_v;
    }

    /// Device time of the latest conversion, microseconds since the first.
    pub const fn now_us(&self) -> u64 {
        self.t_us
    }

    /// Board time of the latest conversion that was dealt with.
    pub const fn board_us(&self) -> u32 {
        self.latest_us
    }

    /// Whether there has been a conversion.
    pub const fn has_begun(&self) -> bool {
        self.latest != NONE_YET
    }

    /// The latest codes of the chip's readings of its supply and its reference, in this order; before there are any, those
    /// of 5 V and of the reference that is set.
    #[inline(always)]
    pub const fn supply_and_reference(&self) -> [i32; 2] {
        [self.own[FIRST + SUPPLY], self.own[FIRST + REFERENCE]]
    }

    /// The chip's own readings.
    pub fn readings(&self) -> Readings {
        let mut readings = Readings::NONE;
        (0..OWN).for_each(|which| self.read(which, &mut readings));
        readings
    }

    /// Converts one of the [`OWN`] readings, in the order of the scan, if there has been one.
    #[inline(never)]
    pub fn read(&self, which: usize, readings: &mut Readings) {
        let slot = TAXELS + which;
        let (Some(code), Some(id)) = (self.own.get(FIRST + slot), ID_OF.get(slot)) else { return };
        if self.read & 1 << slot == 0 {
            return;
        }
        match Channel::from_id(*id) {
            Some(Channel::Vcc) => readings.supply_v = reading::supply_v(*code),
            Some(Channel::Ref) => readings.reference_v = reading::reference_v(*code),
            Some(Channel::Temp) => readings.temperature_c = reading::temperature_c(*code, self.vref_v),
            Some(Channel::Offset) => readings.offset_v = reading::offset_v(*code, self.vref_v),
            Some(Channel::Gain) => readings.gain = reading::gain(*code),
            _ => {}
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
            self.deal_one_by_one(false, &mut done);
        }
    }

    /// Puts a conversion to those that wait. True if they are to be dealt with.
    #[inline(always)]
    pub fn wait(&mut self, timed: &TimedConversion) -> bool {
        let TimedConversion { t_us, conversion: Conversion { status, code } } = *timed;
        let at = (self.next >> PLACE_SHIFT) as usize;
        self.times_us[at] = t_us;
        self.statuses[at] = status.0;
        self.frame.codes[at] = code;
        self.next = self.next.wrapping_add(1 << PLACE_SHIFT);
        self.next == 0
    }

    /// How many conversions wait.
    const fn waits(&self) -> usize {
        (self.next.wrapping_sub(FIRST_NEXT) >> PLACE_SHIFT) as usize
    }

    /// The latest frame.
    pub const fn frame(&self) -> &Frame {
        &self.frame
    }
}

/// How far a code is from zero, and one more; what is beyond the scale or at its end has the sign bit of a
/// 24-bit number or a higher one.
const fn beyond(code: i32) -> i32 {
    // A negative code's complement is as far from the lower end as it is from the upper one.
    (code ^ code >> 31) + 1
}

#[cfg(test)]
mod tests;
