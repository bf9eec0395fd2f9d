//! Reads conversions at DRDY's interrupt and queues them. `acquire/watch.rs` supervises the chip.
//!
//! **A conversion** ([`Acquisition::edge`]) is read twice: the chip returns the same data again,
//! with NEW cleared (SBAS297G, read by command), so a bit error on the bus shows. If the reads
//! differ, a third read decides: two of the three must agree as a whole, or the conversion is
//! dropped. The next conversion may end between two reads: the second and third read then agree on
//! the next one, and the first, read only once, is dropped. A dropped conversion leaves a gap in
//! the ids, which [`crate::assembler`] counts. A bit error that two reads share is not detected. If
//! a plan is too fast for two reads ([`Plan::is_read_twice`]), a conversion is read once, and again
//! only if its id or status is not the expected one: bit errors in a code then go unnoticed.
//!
//! **The plan** ([`Acquisition::change`]) is written and read back while the scan is stopped. A
//! mark in the queue ([`TimedConversion::of_plan`]) separates its conversions from earlier ones. If
//! the plan's scan has no health readings ([`Acquisition::read_health`]), a separate scan reads
//! them at the start and between touches.
//!
//! **The watch** ([`Acquisition::watch`]) reads the registers back. It sets the chip up again if
//! they changed, if no conversions arrive, or if the chip did not answer before: at once the first
//! time, then after pauses that double. Nothing here waits longer than a reset takes.

mod resolve;
mod unseen;
mod watch;

use crate::converter::{Converter, Sample, Scanned, Tag};
use crate::faults::diagnostics::Diagnostics;
use crate::frame::TimedConversion;
use crate::samples::SampleQueue;
use crate::scan::{Order, Scan};
use embedded_hal::delay::DelayNs;
use resolve::{Reads, Resolved, resolve};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::plan::{HealthReadings, Plan};
use unseen::Unseen;

/// Excess of unexpected over expected edges of DRDY at which DRDY is muted. At the default scan's
/// 5064 conversions a second, 256 edges take at least 50 ms.
const STORM_EDGES: u16 = 256;
/// Number of unexpected edges between two requests for a check, while checks find faults.
const CHECK_EDGES: u8 = 8;
const fn edge_ns(plan: &Plan) -> u32 {
    Scan::new(plan).edge_ns()
}

/// Instruction to the caller, about the interrupt of DRDY.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Drdy {
    /// Keep listening.
    Listen,
    /// Keep listening. The conversion was the expected one, and its scan is not over: the queue
    /// need not be read yet.
    Midway,
    /// Keep listening, and call [`Acquisition::watch`] at once.
    Watch,
    /// The health readings are complete: call [`Acquisition::read_inputs`] at once.
    HealthRead,
    /// A storm: mute DRDY, then call [`Acquisition::watch`].
    Mute,
}

/// The converter (called "the chip" below) and its state.
#[derive(Debug)]
pub struct Acquisition<C> {
    converter: C,
    plan: Plan,
    order: Order,
    is_read_twice: bool,
    /// True if the scan under way reads the health readings.
    is_health: bool,
    /// True if the plan's mark is not in the queue yet.
    is_unannounced: bool,
    /// NEW and the id of the expected conversion.
    next: u8,
    /// Latest conversion since the chip was set up, if any.
    latest: Option<Sample>,
    /// Board time of the latest conversion, or of the latest restart.
    latest_us: u32,
    /// True if the latest conversion was read before its edge was served; the edge finds none.
    early: bool,
    /// Number of unexpected edges minus number of expected ones; see [`STORM_EDGES`].
    storm_count: u16,
    /// Number of unexpected edges since the latest check that found no fault.
    unexpected_edges: u8,
    /// Board time of the latest unexpected edge, or of the end of a storm.
    unexpected_us: u32,
    /// Number of times in a row that a different scan was put off.
    put_off: u16,
    muted: bool,
    unseen: Unseen,
    is_set_up: bool,
    /// Board time of the latest restart, and the pause before the next.
    restarted_us: u32,
    pause_us: u32,
}

impl<C: Converter> Acquisition<C> {
    /// Creates an acquisition without touching the converter. `plan` has passed [`Plan::validate`].
    pub const fn new(converter: C, plan: Plan) -> Self {
        let order = Order::new(&plan, Scanned::Inputs);
        Self {
            converter,
            plan,
            order,
            is_read_twice: plan.is_read_twice(),
            is_health: false,
            is_unannounced: false,
            next: order.first(),
            latest: None,
            latest_us: 0,
            early: false,
            storm_count: 0,
            unexpected_edges: 0,
            unexpected_us: 0,
            put_off: 0,
            muted: false,
            unseen: Unseen::new(edge_ns(&plan)),
            is_set_up: false,
            restarted_us: 0,
            pause_us: 0,
        }
    }

    /// Plan of the scan.
    pub const fn plan(&self) -> Plan {
        self.plan
    }
}

impl<C: Converter> Acquisition<C> {
    /// Resets the chip, writes its registers, reads them back and starts the scan, first that of
    /// the health readings if the plan's scan has none. Returns false if the chip does not answer;
    /// [`Self::watch`] then tries again. On an ADS1258 this takes [`ads1258::RESET_LOW_US`] and 36
    /// bytes on the bus.
    pub fn set_up(&mut self, diagnostics: &Diagnostics, wait: &mut impl DelayNs) -> bool {
        self.is_health = self.has_health_scan();
        self.begin_scan(diagnostics, wait)
    }

    /// Switches to a different plan, which has passed [`Plan::validate`], as [`Self::set_up`] does.
    /// The caller then unmutes DRDY.
    pub fn change(
        &mut self,
        plan: Plan,
        now_us: u32,
        diagnostics: &Diagnostics,
        wait: &mut impl DelayNs,
    ) {
        (self.plan, self.is_unannounced) = (plan, true);
        self.is_read_twice = plan.is_read_twice();
        self.unseen = Unseen::new(edge_ns(&plan));
        self.latest_us = now_us;
        let _ = self.set_up(diagnostics, wait);
    }

    /// Interrupts the plan's scan for a scan of the health readings, if the plan's scan has none.
    /// Returns true if it did; the caller then unmutes DRDY.
    pub fn read_health(&mut self, diagnostics: &Diagnostics, wait: &mut impl DelayNs) -> bool {
        let is_due = self.is_health_due();
        if is_due {
            let _ = self.set_up(diagnostics, wait);
        }
        is_due
    }

    /// True if [`Self::read_health`] would interrupt the scan.
    #[inline]
    pub fn is_health_due(&self) -> bool {
        self.has_health_scan() && self.is_set_up && !self.is_health
    }

    /// True if the health readings have a separate scan.
    fn has_health_scan(&self) -> bool {
        self.plan.health == HealthReadings::BetweenTouches
    }

    /// Moves on to the next sample of the edge that was served. Returns false if there is none.
    #[inline(always)]
    pub fn go_on(&mut self) -> bool {
        self.converter.go_on()
    }

    /// Returns to the plan's scan after `Drdy::HealthRead`. The caller then unmutes DRDY.
    pub fn read_inputs(&mut self, diagnostics: &Diagnostics, wait: &mut impl DelayNs) {
        self.is_health = false;
        let _ = self.begin_scan(diagnostics, wait);
    }

    /// Begins a scan. Retries once immediately, because a single bit error on the bus does not
    /// justify a pause.
    fn begin_scan(&mut self, diagnostics: &Diagnostics, wait: &mut impl DelayNs) -> bool {
        self.try_scan(diagnostics, wait) || self.try_scan(diagnostics, wait)
    }

    fn try_scan(&mut self, diagnostics: &Diagnostics, wait: &mut impl DelayNs) -> bool {
        let scanned = if self.is_health {
            Scanned::Health
        } else {
            Scanned::Inputs
        };
        self.order = Order::new(&self.plan, scanned);
        (self.next, self.latest, self.early) = (self.order.first(), None, false);
        let is_configured =
            self.converter.stop() && self.converter.set_up(&self.plan, scanned, wait);
        // Read the registers even if the chip does not answer: the values show which wire is bad.
        // Read them before START, because ID may be wrong while START is high.
        let registers = self.converter.registers();
        self.is_set_up = is_configured && self.converter.start();
        if !(self.is_health && self.is_set_up) {
            diagnostics.converter.keep(registers, self.is_set_up);
        }
        self.is_set_up
    }

    /// Serves an edge after which DRDY is low: reads the conversion and queues it with the edge's
    /// board time, microseconds. `edge_us` is called after the reads.
    #[inline]
    pub fn edge(
        &mut self,
        edge_us: impl FnOnce() -> u32,
        samples: &SampleQueue,
        diagnostics: &Diagnostics,
    ) -> Drdy {
        let first = self.converter.read();
        let is_expected = first.filter(|first| first.tag.0 & Tag::NEW_AND_ID == self.next);
        if !self.is_read_twice
            && let Some(conversion) = is_expected
        {
            return self.expected(edge_us(), conversion, samples, diagnostics);
        }
        let again = self.converter.read();
        let t_us = edge_us();
        if let (Some(conversion), Some(again)) = (is_expected, again)
            && conversion.code == again.code
            && conversion.tag.0 ^ again.tag.0 == Tag::NEW
        {
            return self.expected(t_us, conversion, samples, diagnostics);
        }
        self.unexpected([first, again], t_us, samples, diagnostics)
    }

    #[inline(always)]
    fn expected(
        &mut self,
        t_us: u32,
        conversion: Sample,
        samples: &SampleQueue,
        diagnostics: &Diagnostics,
    ) -> Drdy {
        self.storm_count = self.storm_count.saturating_sub(1);
        self.queue(t_us, conversion, samples, diagnostics);
        match conversion.tag.id() == self.order.last_id() {
            false => Drdy::Midway,
            true if self.is_health => Drdy::HealthRead,
            true => Drdy::Listen,
        }
    }

    /// Serves an edge after which DRDY is high again: counts it towards a storm, and as
    /// [`FaultKind::Repeated`].
    pub fn nothing(&mut self, edge_us: u32, diagnostics: &Diagnostics) -> Drdy {
        self.unexpected_us = edge_us;
        if core::mem::take(&mut self.early) {
            return Drdy::Listen;
        }
        diagnostics.fault(FaultKind::Repeated, edge_us);
        self.count_unexpected(edge_us, diagnostics)
    }

    #[inline(always)]
    fn queue(
        &mut self,
        t_us: u32,
        conversion: Sample,
        samples: &SampleQueue,
        diagnostics: &Diagnostics,
    ) {
        self.early = false;
        if self.latest.is_some() {
            self.unseen.passed(t_us.wrapping_sub(self.latest_us));
        }
        self.latest = Some(conversion);
        self.latest_us = t_us;
        self.next = self.order.next_status(conversion.tag.0);
        if self.is_unannounced {
            self.announce(t_us, samples);
        }
        if self.is_unannounced || !samples.enqueue(TimedConversion::new(t_us, conversion)) {
            self.count_lost(1, diagnostics);
        }
    }

    /// Counts conversions that were lost before they reached the queue, or because it is full. Gaps
    /// between frames also show losses from the plan's own scan, but not from the health scan.
    fn count_lost(&self, lost: u32, diagnostics: &Diagnostics) {
        let counter = if self.is_health {
            &diagnostics.unseen
        } else {
            &diagnostics.queue_overruns
        };
        counter.add(lost);
    }

    /// Puts the mark of a new plan into the queue, if there is room.
    fn announce(&mut self, t_us: u32, samples: &SampleQueue) {
        self.is_unannounced = !samples.enqueue(TimedConversion::of_plan(&self.plan, t_us));
    }

    /// Handles two reads of which at least one is not the expected conversion.
    fn unexpected(
        &mut self,
        reads: Reads,
        t_us: u32,
        samples: &SampleQueue,
        diagnostics: &Diagnostics,
    ) -> Drdy {
        self.unexpected_us = t_us;
        let converter = &mut self.converter;
        let resolved = resolve(self.latest, self.next, reads, || converter.read());
        if let Resolved::Found(conversion)
        | Resolved::Mended(conversion)
        | Resolved::Later(conversion) = resolved
        {
            // With `Later` this includes the expected conversion, which was read only once.
            self.count_lost(self.order.skipped(self.next, conversion.tag.0), diagnostics);
            self.queue(t_us, conversion, samples, diagnostics);
        }
        match resolved {
            // The conversion is new, so the edge was late and not part of a storm.
            Resolved::Found(_) => return self.request_check(),
            Resolved::Mended(_) => diagnostics.fault(FaultKind::Bus, t_us),
            Resolved::Later(_) => {
                self.early = true;
                return Drdy::Listen;
            }
            Resolved::Garbled => {
                diagnostics.fault(FaultKind::Bus, t_us);
                self.count_lost(1, diagnostics);
                self.next = self.order.next_status(self.next);
            }
            Resolved::Dead => diagnostics.fault(FaultKind::BusDead, t_us),
            Resolved::Repeated if core::mem::take(&mut self.early) => return Drdy::Listen,
            Resolved::Repeated => diagnostics.fault(FaultKind::Repeated, t_us),
            Resolved::RepeatedGarbled => {
                diagnostics.fault(FaultKind::Bus, t_us);
                diagnostics.fault(FaultKind::Repeated, t_us);
            }
        }
        self.count_unexpected(t_us, diagnostics)
    }

    fn count_unexpected(&mut self, t_us: u32, diagnostics: &Diagnostics) -> Drdy {
        self.storm_count = self.storm_count.saturating_add(1);
        if self.storm_count >= STORM_EDGES {
            diagnostics.fault(FaultKind::Storm, t_us);
            self.muted = true;
            return Drdy::Mute;
        }
        self.request_check()
    }

    /// Requests a check at the first of every [`CHECK_EDGES`] unexpected edges.
    fn request_check(&mut self) -> Drdy {
        let is_due = self.unexpected_edges.is_multiple_of(CHECK_EDGES);
        self.unexpected_edges = self.unexpected_edges.wrapping_add(1);
        if is_due { Drdy::Watch } else { Drdy::Listen }
    }
}

#[cfg(test)]
mod tests;
