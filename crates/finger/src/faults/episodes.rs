//! Fault episodes: a fault is reported when it begins and when it ends.

use crate::assembler::{Assembler, Flaws};
use crate::faults::diagnostics::Diagnostics;
use crate::ring::reached;
use crate::scan::{FRAME_NS, Scan};
use crate::touch::block::BLOCK_FRAMES;
use ads1258::reading::CODES_PER_SUPPLY_VOLT;
use core::ops::RangeInclusive;
use ridgetone_proto::fault::{Fault, FaultKind, FaultSet, KINDS};

/// Time without the fault after which an episode is over, microseconds.
const OVER_US: u32 = 1_000_000;
/// Maximum number of messages per [`MESSAGES_US`], microseconds; the next interval reports the
/// rest. If all kinds begin and end as often as possible, every [`OVER_US`], there are 26 messages
/// a second.
const MESSAGES_MAX: u8 = 4;
const MESSAGES_US: u32 = 125_000;
/// Number of frames between checks for the end of an episode.
const CHECK_FRAMES: u32 = 16;

/// Time without a conversion in which a slide may have ended unseen, nanoseconds: a block of motion
/// detection, 4 frames at 241 Hz.
const SILENT_NS: u32 = BLOCK_FRAMES * FRAME_NS as u32;

/// Inverse of the clock error that may go unnoticed: 2 %, or one conversion in 50.
const CLOCK_DIVISOR: u32 = 50;
/// Range of gap lengths (in conversions) in which the number of whole scans is uncertain.
const UNSURE_CONVERSIONS: u32 = 10_000;

/// Allowed codes of the analogue supply (SBAS297G, recommended operating conditions: 4.75 to 5.25
/// V).
const SUPPLY: RangeInclusive<i32> = codes(4.75, 5.25);
/// Maximum relative deviation of the reference from the setting.
const REFERENCE_TOLERANCE: f32 = 0.02;

/// Converts a range of volts to codes of the chip's supply and reference readings.
const fn codes(min_v: f32, max_v: f32) -> RangeInclusive<i32> {
    (min_v * CODES_PER_SUPPLY_VOLT as f32) as i32..=(max_v * CODES_PER_SUPPLY_VOLT as f32) as i32
}

#[derive(Clone, Debug)]
pub struct FaultEpisodes {
    reference: RangeInclusive<i32>,
    /// Kinds of faults with an ongoing episode.
    lasting: FaultSet,
    /// Faults whose beginning has been reported.
    reported: FaultSet,
    /// Device time at which each kind's episode began, microseconds.
    from_us: [u64; KINDS],
    /// Device time (low 32 bits) since which messages are counted, and their number.
    since_us: u32,
    messages: u8,
    /// True during an episode, and initially. The next check for its end is at frame `check_at`.
    is_active: bool,
    check_at: u32,
}

impl FaultEpisodes {
    /// Starts without faults. `vref_v` is the reference voltage in the settings.
    pub const fn new(vref_v: f32) -> Self {
        Self {
            reference: reference_codes(vref_v),
            lasting: FaultSet::NONE,
            reported: FaultSet::NONE,
            from_us: [0; KINDS],
            since_us: 0,
            messages: 0,
            is_active: true,
            check_at: 0,
        }
    }

    /// Sets the reference, volts.
    pub const fn set_reference(&mut self, vref_v: f32) {
        self.reference = reference_codes(vref_v);
    }

    /// Adds a fault to `diagnostics` if the chip reads its supply or its reference out of range.
    #[inline(always)]
    pub fn check_supply(&self, assembler: &Assembler, diagnostics: &Diagnostics) {
        let [_offset, supply, _temperature, _gain, reference] = assembler.own;
        if supply.is_some_and(|code| !SUPPLY.contains(&code)) {
            diagnostics.fault(FaultKind::Supply, assembler.board_us);
        }
        if reference.is_some_and(|code| !self.reference.contains(&code)) {
            diagnostics.fault(FaultKind::Reference, assembler.board_us);
        }
    }

    /// Calls [`Self::report`] if there may be something to report at the frame `latest`.
    #[inline(always)]
    pub fn check(
        &mut self,
        latest: u32,
        assembler: &Assembler,
        diagnostics: &Diagnostics,
        report: &mut dyn FnMut(Fault),
    ) {
        if self.is_active && reached(latest, self.check_at) || diagnostics.faults.has_fresh() {
            self.check_at = latest.wrapping_add(CHECK_FRAMES);
            self.report(assembler.now_us, assembler.board_us, diagnostics, report);
            set_zero(assembler, diagnostics);
        }
    }

    /// Reports episodes that begin or end. `device_us` and `board_us` are the present time.
    pub fn report(
        &mut self,
        device_us: u64,
        board_us: u32,
        diagnostics: &Diagnostics,
        report: &mut dyn FnMut(Fault),
    ) {
        let faults = &diagnostics.faults;
        if (device_us as u32).wrapping_sub(self.since_us) >= MESSAGES_US {
            (self.since_us, self.messages) = (device_us as u32, 0);
        }
        let fresh = faults.take_fresh();
        let kinds = fresh.and(self.lasting);
        self.is_active = !kinds.is_none();
        for kind in kinds.iter() {
            // Clamp to now and to zero: a fault from a higher-priority task may be later than now,
            // and one from before the first conversion earlier than zero.
            let age_us = |seen_us: u32| (board_us.wrapping_sub(seen_us) as i32).max(0) as u32;
            let device_us = |seen_us| device_us.saturating_sub(age_us(seen_us) as u64);
            let seen_us = faults.seen_us(kind);
            let Some(from_us) = self.from_us.get_mut(kind as usize) else {
                continue;
            };
            if !self.lasting.has(kind) {
                self.lasting = self.lasting.with(kind);
                *from_us = device_us(faults.first_us(kind));
            }
            let goes_on = fresh.has(kind) || faults.standing().has(kind);
            let is_over = age_us(seen_us) >= OVER_US && !goes_on;
            if (!is_over && self.reported.has(kind)) || self.messages >= MESSAGES_MAX {
                continue;
            }
            if is_over {
                (self.lasting, self.reported) =
                    (self.lasting.without(kind), self.reported.without(kind));
            } else {
                self.reported = self.reported.with(kind);
            }
            self.messages += 1;
            let until_us = is_over.then(|| device_us(seen_us));
            report(Fault {
                kind,
                from_us: *from_us,
                until_us,
                count: faults.count(kind),
            });
        }
    }
}

/// Range of codes around the reference in the settings.
const fn reference_codes(vref_v: f32) -> RangeInclusive<i32> {
    codes(
        vref_v * (1.0 - REFERENCE_TOLERANCE),
        vref_v * (1.0 + REFERENCE_TOLERANCE),
    )
}

/// Adds the assembler's new flaws to `diagnostics`.
pub fn add_flaws(assembler: &mut Assembler, diagnostics: &Diagnostics) {
    let board_us = assembler.board_us;
    set_zero(assembler, diagnostics);
    let Flaws {
        lost,
        repeated,
        channel,
        supply,
        clock,
        overload,
    } = core::mem::take(&mut assembler.flaws);
    let Scan {
        slots,
        conversion_ns,
        ..
    } = *assembler.scan();
    // In a gap of this many conversions the clock's error is half a scan or more, so the number of
    // whole scans in it is uncertain: report the maximum loss. Longer gaps are counted by time
    // alone, because the chip was set up again, or the board was off.
    let unsure = CLOCK_DIVISOR * slots.max(2) / 2;
    if (unsure..=unsure + UNSURE_CONVERSIONS).contains(&lost) {
        diagnostics.unseen.add(lost / CLOCK_DIVISOR + slots / 2 + 1);
    }
    for (kind, times) in [
        (FaultKind::Lost, lost),
        (FaultKind::Repeated, repeated),
        (FaultKind::Channel, channel),
        (FaultKind::Supply, supply),
        (FaultKind::Clock, clock),
        (
            FaultKind::Silent,
            (lost >= SILENT_NS / conversion_ns.max(1)) as u32,
        ),
    ] {
        diagnostics.faults.add(kind, times, board_us);
    }
    diagnostics.overload(overload, board_us);
}

fn set_zero(assembler: &Assembler, diagnostics: &Diagnostics) {
    diagnostics
        .faults
        .set_zero(assembler.board_us.wrapping_sub(assembler.now_us as u32));
}
