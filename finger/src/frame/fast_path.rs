//! The short way: a whole scan without a flaw, taken at one glance.

use super::{
    Assembler, CODE_LEAST, CONVERSION_NS, FIRST, FIRST_NEXT, ID_OF, JITTER_US, NONE_YET, PLACES, SLOTS, beyond,
};
use ridgetone_proto::settings::TAXELS;

/// Status of a conversion without a flaw, but for its id (datasheet: NEW and no other flag).
const FLAWLESS: u8 = 0x80;
/// Status bytes of a whole scan without a flaw. Four are compared at once; before the first slot's nothing is written.
const STATUSES: [u8; PLACES] = {
    let mut statuses = [0; PLACES];
    let mut slot = 0;
    while slot < SLOTS as usize {
        statuses[FIRST + slot] = FLAWLESS | ID_OF[slot];
        slot += 1;
    }
    statuses
};
/// Places before the fours that a scan reaches into.
const BEFORE: usize = FIRST / 4 * 4;
/// Time from one conversion to the next, at least, microseconds.
const STEP_LEAST_US: u32 = (CONVERSION_NS / 1000) as u32 - JITTER_US;
/// Time from the first to the last conversion of a scan, at least, microseconds.
const SPAN_LEAST_US: u32 = (CONVERSION_NS * (SLOTS as u64 - 1) / 1000) as u32 - JITTER_US;

impl Assembler {
    /// Takes what waits, as many as a scan has, as a frame, if it is a whole scan without a flaw that follows the one
    /// before it, in time too. False, with nothing done, if it is not.
    #[inline(never)]
    pub fn whole(&mut self) -> bool {
        let (begin_us, end_us) = (self.times_us[FIRST], self.times_us[PLACES - 1]);
        let (mut passed_us, span_us) = (begin_us.wrapping_sub(self.latest_us), end_us.wrapping_sub(begin_us));
        if self.latest != SLOTS - 1
            || passed_us.wrapping_sub(STEP_LEAST_US) > 2 * JITTER_US
            || span_us.wrapping_sub(SPAN_LEAST_US) > 2 * JITTER_US
        {
            if self.has_begun() || span_us.wrapping_sub(SPAN_LEAST_US) > 2 * JITTER_US {
                return false;
            }
            // The first one: its number becomes zero, and so does its time.
            (passed_us, self.frame.number, self.latest) = (0, u32::MAX, SLOTS - 1);
        }
        let (mut odd, mut ends) = (0, 0);
        let [read, expected] = [&self.statuses, &STATUSES].map(|statuses| statuses.split_at(BEFORE).1.as_chunks().0);
        for (statuses, whole) in read.iter().zip(expected) {
            odd |= u32::from_ne_bytes(*statuses) ^ u32::from_ne_bytes(*whole);
        }
        for code in self.frame.taxels() {
            ends |= beyond(*code);
        }
        if odd != 0 || ends >= -CODE_LEAST {
            // The first one after all was not: here, where nothing is in a hurry.
            if self.read == 0 {
                (self.frame.number, self.latest) = (0, NONE_YET);
            }
            return false;
        }
        // At once: words one by one would be twice the instructions.
        let own = FIRST + TAXELS..PLACES;
        self.own[own.clone()].copy_from_slice(&self.frame.codes[own]);
        self.read = u32::MAX;
        self.frame.number = self.frame.number.wrapping_add(1);
        self.frame.t_us = self.t_us.wrapping_add(passed_us as u64);
        (self.frame.present, self.frame.good) = (u16::MAX, u16::MAX);
        self.t_us = self.frame.t_us.wrapping_add(span_us as u64);
        self.latest_us = end_us;
        self.next = FIRST_NEXT;
        self.frames = self.frames.wrapping_add(1);
        true
    }
}
