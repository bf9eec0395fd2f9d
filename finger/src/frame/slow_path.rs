//! The long way: each conversion of a scan with a loss or a flaw by itself.

use super::{
    Assembler, CODE_LEAST, CONVERSION_NS, Codes, FIRST, FIRST_NEXT, Frame, GAP_US, IDS, JITTER_US, LAST_ID, NONE_YET,
    PLACES, SLOT_OF, SLOTS, TimedConversion, beyond,
};
use ads1258::{Conversion, Status};
use ridgetone_proto::settings::TAXELS;

/// Added to the latest slot while its time is suspected: the scan that follows is not taken at one glance.
const SUSPECT: u32 = PLACES as u32;

impl Assembler {
    /// From now on every scan takes the long way, or only those with a flaw. Costs the others nothing: before the
    /// first slot's status is a place that is never written, but compared.
    pub const fn take_the_long_way(&mut self, always: bool) {
        self.statuses[FIRST - 1] = always as u8;
    }

    /// Deals with the conversions that wait, and with each by itself. What is behind a scan's last one goes on waiting,
    /// so that the next scan is whole again; unless the signal `is_over`.
    #[inline(never)]
    pub fn deal_one_by_one(&mut self, is_over: bool, done: &mut impl FnMut(&Self, &Frame)) {
        let codes = self.frame.codes;
        let waiting = self.waits();
        self.next = FIRST_NEXT;
        let mut dealt = if is_over { 0 } else { waiting };
        while dealt > 0 && self.waiting(dealt - 1, &codes).conversion.status.chid() != LAST_ID {
            dealt -= 1;
        }
        if dealt == 0 {
            dealt = waiting;
        }
        self.frame.codes = self.own;
        for at in 0..dealt {
            let timed = self.waiting(at, &codes);
            self.take(&timed, done);
        }
        self.own = self.frame.codes;
        for at in dealt..waiting {
            let timed = self.waiting(at, &codes);
            self.wait(&timed);
        }
    }

    /// One of the conversions that wait, with these codes.
    fn waiting(&self, at: usize, codes: &Codes) -> TimedConversion {
        let at = (FIRST + at) % PLACES;
        let conversion = Conversion { status: Status(self.statuses[at]), code: codes[at] };
        TimedConversion { t_us: self.times_us[at], conversion }
    }

    /// Takes any conversion.
    #[inline(never)]
    fn take(&mut self, timed: &TimedConversion, done: &mut impl FnMut(&Self, &Frame)) {
        let TimedConversion { t_us, conversion: Conversion { status, code } } = *timed;
        let Some(slot) = SLOT_OF[status.chid() as usize % IDS].filter(|_| status.is_new()) else {
            self.doubtful = self.doubtful.saturating_add(1);
            let flaw = if status.is_new() { &mut self.flaws.channel } else { &mut self.flaws.repeated };
            *flaw = flaw.saturating_add(1);
            return;
        };
        let clean = !status.is_overflow() && !status.is_supply_low();
        let clips = beyond(code) >= -CODE_LEAST;
        self.flaws.supply += status.is_supply_low() as u32;
        self.flaws.overload += (status.is_overflow() || clips && slot < TAXELS as u8) as u32;
        self.doubtful = self.doubtful.saturating_add(!clean as u32);

        let scans = self.advance(slot as u32, t_us);
        if scans > 0 {
            self.give(done);
            self.frame.number = self.frame.number.wrapping_add(scans);
            self.frame.t_us = self.t_us.saturating_sub((slot as u32 * CONVERSION_NS as u32 / 1000) as u64);
            (self.frame.present, self.frame.good) = (0, 0);
        }
        self.open = true;
        if let Some(place) = self.frame.codes.get_mut(FIRST + slot as usize) {
            *place = code;
        }
        let bit = 1u32 << slot;
        self.read |= bit;
        self.frame.present |= bit as u16;
        if clean && !clips {
            self.frame.good |= bit as u16;
        }
        if bit << 1 == 1 << SLOTS {
            self.give(done);
        }
    }

    /// Moves on to `slot` at raw time `t_us` and counts what was lost on the way. Returns how many
    /// scans later it is than the one under way.
    fn advance(&mut self, slot: u32, t_us: u32) -> u32 {
        let before = self.latest % PLACES as u32;
        if core::mem::replace(&mut self.latest, slot) == NONE_YET {
            self.latest_us = t_us;
            self.lost = slot;
            self.flaws.lost = slot;
            return 0;
        }
        let passed_us = t_us.wrapping_sub(self.latest_us);
        self.latest_us = t_us;
        self.t_us = self.t_us.wrapping_add(passed_us as u64);
        let (mut scans, mut gone) = ((slot <= before) as u32, 0);
        if passed_us > GAP_US {
            // As many whole scans more as bring the count of slots nearest to the time that passed.
            // In two parts that 32 bits hold: a division of 64 bits is a kilobyte of code on the chip.
            const NS: u32 = CONVERSION_NS as u32;
            let by_time = passed_us / NS * 1000 + passed_us % NS * 1000 / NS;
            let by_order = scans * SLOTS + slot - before;
            scans += (by_time.saturating_sub(by_order) + SLOTS / 2) / SLOTS;
            // A chip that was set up anew begins its scan anew: by order there may be fewer.
            gone = by_time;
        }
        let steps = scans.saturating_mul(SLOTS).saturating_add(slot).saturating_sub(before);
        let lost = steps.max(gone).saturating_sub(1);
        self.lost = self.lost.saturating_add(lost);
        self.flaws.lost = self.flaws.lost.saturating_add(lost);
        self.judge(passed_us, steps);
        scans
    }

    /// Whether so many steps of the scan fit the time that passed. A chip that stood still, or began its scan anew, goes
    /// on with conversions that are not where the fit takes them to be. A conversion whose time was only noted late
    /// is followed by one that is on time again.
    fn judge(&mut self, passed_us: u32, steps: u32) {
        const NS: u32 = CONVERSION_NS as u32;
        // In two parts that 32 bits hold.
        let due_us = (steps / 1000).wrapping_mul(NS).wrapping_add(steps % 1000 * NS / 1000);
        let (late_us, left_out) = self.suspected.take().unwrap_or((0, false));
        let off_us = (passed_us.wrapping_sub(due_us) as i32).saturating_add(late_us);
        let left_out = left_out || steps > 1;
        // 122 ppm, for what the two crystals may differ by over a long gap.
        if off_us.unsigned_abs() <= JITTER_US + (passed_us >> 13) {
            return;
        }
        if late_us == 0 {
            self.suspected = Some((off_us, left_out));
            self.latest |= SUSPECT;
        } else if left_out {
            self.flaws.channel = self.flaws.channel.saturating_add(1);
        } else {
            self.flaws.clock = self.flaws.clock.saturating_add(1);
        }
    }

    fn give(&mut self, done: &mut impl FnMut(&Self, &Frame)) {
        if core::mem::take(&mut self.open) {
            self.frames = self.frames.wrapping_add(1);
            done(self, &self.frame);
        }
    }
}
