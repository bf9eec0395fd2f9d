//! What is wrong, told when it begins and when it is over.

use super::Detector;
use crate::faults::diagnostics::Diagnostics;
use crate::frame::{Assembler, Flaws, SLOTS};
use crate::ring::reached;
use crate::touch::motion::BLOCK_FRAMES;
use ads1258::reading::CODES_PER_SUPPLY_VOLT;
use ridgetone_proto::fault::{Fault, FaultKind, FaultSet, KINDS};
use ridgetone_proto::telemetry::Event;

/// A bout is over when its kind was not seen for so long, microseconds.
const OVER_US: u32 = 1_000_000;
/// Most messages in a stretch of [`STRETCH_US`], whatever happens, microseconds: what begins beyond that is told with the
/// next. Kinds that all begin and end every [`OVER_US`], which is as often as they can, make 26 a second.
const MOST: u8 = 4;
const STRETCH_US: u32 = 125_000;
/// While a bout lasts its end is looked for once in so many frames.
const LOOK_FRAMES: u32 = 16;

/// So many conversions without one that came are a silence, in which a slide may have ended unseen: as many frames as the
/// comparisons that tell a motion are made of.
const SILENT_CONVERSIONS: u32 = BLOCK_FRAMES * SLOTS;

/// A clock may be off by this share of its rate, 2 %, while nobody sees it. Of so many conversions lost that is half a
/// scan: which number of whole scans went by is then open, and as many more as it may have been are told as lost. In a
/// gap of more than two seconds the chip was set up anew, or the board was off: it is counted by the time alone.
const CLOCK_SHARE: u32 = 50;
const UNSURE_CONVERSIONS: Range = Range { least: (CLOCK_SHARE * SLOTS / 2) as i32, more: 10_000 };

/// Codes or numbers from the least on, and how many more of them there are.
#[derive(Clone, Copy, Debug)]
struct Range {
    least: i32,
    more: u32,
}

impl Range {
    /// From one voltage to another, volts, as the chip reads its supply and reference.
    const fn of_volts(least_v: f32, most_v: f32) -> Self {
        let least = (least_v * CODES_PER_SUPPLY_VOLT as f32) as i32;
        Self { least, more: (most_v * CODES_PER_SUPPLY_VOLT as f32) as u32 - least as u32 }
    }

    /// About a reference that is set, volts.
    const fn of_reference(vref_v: f32) -> Self {
        Self::of_volts(vref_v * (1.0 - REFERENCE_SHARE), vref_v * (1.0 + REFERENCE_SHARE))
    }

    const fn has(&self, code: i32) -> bool {
        code.wrapping_sub(self.least) as u32 <= self.more
    }
}

/// Analogue supply (SBAS297G, recommended operating conditions: 4.75 to 5.25 V).
const SUPPLY: Range = Range::of_volts(4.75, 5.25);
/// How far the reference may be from what is set.
const REFERENCE_SHARE: f32 = 0.02;

/// The bouts.
#[derive(Clone, Debug)]
pub(super) struct FaultEpisodes {
    reference: Range,
    /// Kinds whose bout lasts, and those of them of which that was told.
    lasting: FaultSet,
    told: FaultSet,
    /// Device time at which each began, microseconds.
    from_us: [u64; KINDS],
    /// Device time since which messages are counted, low 32 bits, and how many there were.
    since_us: u32,
    messages: u8,
    /// Whether there is something to look for at frame `look_at`: ends, while a bout lasts; and the first frame.
    looks: bool,
    look_at: u32,
}

/// Adds to the tally what the assembler found since this was done last.
#[inline(never)]
pub(super) fn note(assembler: &mut Assembler, diagnostics: &Diagnostics) {
    let board_us = assembler.board_us();
    note_zero(assembler, diagnostics);
    let Flaws { lost, repeated, channel, supply, clock, overload } = core::mem::take(&mut assembler.flaws);
    if UNSURE_CONVERSIONS.has(lost as i32) {
        diagnostics.unseen(lost / CLOCK_SHARE + SLOTS / 2 + 1);
    }
    for (kind, times) in [
        (FaultKind::Lost, lost),
        (FaultKind::Repeated, repeated),
        (FaultKind::Channel, channel),
        (FaultKind::Supply, supply),
        (FaultKind::Clock, clock),
        (FaultKind::Silent, (lost >= SILENT_CONVERSIONS) as u32),
    ] {
        diagnostics.faults.add(kind, times, board_us);
    }
    diagnostics.overload(overload, board_us);
}

/// Tells the tally at which board time device time is zero.
fn note_zero(assembler: &Assembler, diagnostics: &Diagnostics) {
    diagnostics.faults.set_zero(assembler.board_us().wrapping_sub(assembler.now_us() as u32));
}

impl FaultEpisodes {
    /// None. `vref_v` is the reference that is set, volts.
    pub const fn new(vref_v: f32) -> Self {
        Self {
            reference: Range::of_reference(vref_v),
            lasting: FaultSet::NONE,
            told: FaultSet::NONE,
            from_us: [0; KINDS],
            since_us: 0,
            messages: 0,
            looks: true,
            look_at: 0,
        }
    }

    /// From now on the reference that is set has so many volts.
    pub const fn set_reference(&mut self, vref_v: f32) {
        self.reference = Range::of_reference(vref_v);
    }

    /// Tells what begins and what is over; `now_us` is now, in device time and in board time.
    #[inline(never)]
    pub fn tell(&mut self, now_us: (u64, u32), diagnostics: &Diagnostics, emit: &mut dyn FnMut(Event)) {
        let (device_us, board_us) = now_us;
        if (device_us as u32).wrapping_sub(self.since_us) >= STRETCH_US {
            (self.since_us, self.messages) = (device_us as u32, 0);
        }
        let fresh = diagnostics.faults.take_fresh();
        self.looks = !fresh.and(self.lasting).is_none();
        for kind in fresh.and(self.lasting).iter() {
            // Seen by a task that came between, or before the first conversion: now is near enough.
            let age_us = |seen_us: u32| (board_us.wrapping_sub(seen_us) as i32).max(0) as u32;
            let first_us = device_us.saturating_sub(age_us(diagnostics.faults.first_us(kind)) as u64);
            let age_us = age_us(diagnostics.faults.seen_us(kind));
            let seen_us = device_us.saturating_sub(age_us as u64);
            let Some(from_us) = self.from_us.get_mut(kind as usize) else { continue };
            if !self.lasting.has(kind) {
                self.lasting = self.lasting.with(kind);
                *from_us = first_us;
            }
            let is_over = age_us >= OVER_US && !fresh.has(kind);
            if (!is_over && self.told.has(kind)) || self.messages >= MOST {
                continue;
            }
            let until_us = is_over.then_some(seen_us);
            let fault = Fault { kind, from_us: *from_us, until_us, count: diagnostics.faults.count(kind) };
            if is_over {
                (self.lasting, self.told) = (self.lasting.without(kind), self.told.without(kind));
            } else {
                self.told = self.told.with(kind);
            }
            self.messages += 1;
            emit(Event::Fault(fault));
        }
    }
}

impl Detector {
    /// Looks at the chip's own readings of its supply and its reference.
    #[inline(always)]
    pub(super) fn check_supply(&mut self, diagnostics: &Diagnostics) {
        let [supply, reference] = self.assembler.supply_and_reference();
        if !SUPPLY.has(supply) || !self.episodes.reference.has(reference) {
            self.starve(diagnostics);
        }
    }

    #[inline(never)]
    fn starve(&mut self, diagnostics: &Diagnostics) {
        let Self { assembler, episodes, .. } = self;
        let ([supply, reference], board_us) = (assembler.supply_and_reference(), assembler.board_us());
        diagnostics.faults.add(FaultKind::Supply, !SUPPLY.has(supply) as u32, board_us);
        diagnostics.faults.add(FaultKind::Reference, !episodes.reference.has(reference) as u32, board_us);
    }

    /// Looks for changes of faults; in a frame that has nothing else to do.
    #[inline(always)]
    pub(super) fn guard(&mut self, diagnostics: &Diagnostics, emit: &mut dyn FnMut(Event)) {
        let Self { episodes, rest, .. } = self;
        let looks = episodes.looks && reached(rest.scheduler.latest.0, episodes.look_at);
        if looks || diagnostics.faults.has_fresh() {
            self.alarm(diagnostics, emit);
        }
    }

    #[inline(never)]
    fn alarm(&mut self, diagnostics: &Diagnostics, emit: &mut dyn FnMut(Event)) {
        let Self { assembler, episodes, rest, .. } = self;
        episodes.look_at = rest.scheduler.latest.0.wrapping_add(LOOK_FRAMES);
        episodes.tell((assembler.now_us(), assembler.board_us()), diagnostics, emit);
        note_zero(assembler, diagnostics);
    }
}
