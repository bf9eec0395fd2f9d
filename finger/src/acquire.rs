//! Everything between DRDY's interrupt and the queue, and the watch over the chip.
//!
//! **A conversion** ([`Acquisition::edge`]) is read twice: the chip gives the same data again, with NEW cleared
//! (SBAS297G, read by command), so a bit that falls over on the bus shows. Then a third read decides, by whole records.
//! What no two reads agree on is dropped. Between two reads the next conversion may end: the second and third then agree
//! on that one, and the first, read only once, is dropped. What is dropped leaves a gap in the ids, which
//! [`crate::frame`] counts. A garbled bit that two reads agree on is not seen.
//!
//! **The watch** ([`Acquisition::watch`]) reads the registers back and sets the chip up anew if they are not what was
//! written, if no conversion comes, or if it did not answer before: at once the first time, then after pauses that
//! double. Nothing here waits for longer than a reset takes.

mod resolve;
mod unseen;

use crate::faults::diagnostics::Diagnostics;
use crate::frame::TimedConversion;
use crate::scan::SLOTS;
use ads1258::{Ads1258, Channel, Conversion, Register};
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;
use heapless::spsc::Producer;
use resolve::{Resolved, settle};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::settings::SCAN;
use unseen::Unseen;

/// NEW in the status byte (SBAS297G).
const NEW: u8 = 0x80;
/// NEW and CHID.
const NEW_AND_ID: u8 = 0x9f;

/// NEW and CHID of the conversion that follows one with this CHID; the scan's first behind ids that it has not.
const NEXT: [u8; 32] = {
    let first = match Channel::from_id(SCAN.channel_mask().trailing_zeros() as u8) {
        Some(first) => first,
        None => panic!("the scan is empty"),
    };
    let mut next = [NEW | first.id(); 32];
    let mut id = 0;
    while id < next.len() {
        if let Some(channel) = Channel::from_id(id as u8) {
            next[id] = NEW | SCAN.next_channel(channel).id();
        }
        id += 1;
    }
    next
};
/// NEW and CHID of the scan's first conversion: behind the last possible id it begins anew.
const FIRST: u8 = NEXT[31];

/// NEW and CHID of the conversion that follows one of this status.
#[inline(always)]
fn follows(status: u8) -> u8 {
    NEXT[status as usize % NEXT.len()]
}

/// Edges of DRDY that give nothing that was expected, less those that do: from this many on DRDY is muted. At the
/// scan's 5064 conversions a second as many edges more take 50 ms or longer; at a microsecond each, a few milliseconds.
const STORM_EDGES: u16 = 256;
/// Such edges from one demand for a check to the next, while checks find fault.
const ODD_EDGES: u8 = 8;
/// Without a conversion for so long, the chip is silent, microseconds: 500 conversions of the scan.
const SILENT_US: u32 = 100_000;
/// Without a conversion for so long, a check need not wait for the next one, microseconds.
const QUIET_US: u32 = 10_000;
/// From the first restart to the next, if the trouble stays, microseconds; then twice as long each time.
const PAUSE_LEAST_US: u32 = 125_000;
/// Longest pause: a try holds the other interrupts up for 0.1 ms, so that more patience would save nothing and cost
/// time without a chip that is well again.
const PAUSE_MOST_US: u32 = 4_000_000;
/// What goes well for so long after a restart, and for longer than the pause, is well, microseconds.
const WELL_US: u32 = 1_000_000;

/// What is to happen to DRDY's interrupt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Drdy {
    /// It goes on.
    Listen,
    /// It goes on, and [`Acquisition::watch`] is to be called at once.
    Watch,
    /// It is to be muted until [`Acquisition::watch`] has been called: a storm.
    Mute,
}

/// The chip, its pins, and what is known of how it does.
#[derive(Debug)]
pub struct Acquisition<SPI, START, RESET> {
    adc: Ads1258<SPI>,
    start: START,
    reset: RESET,
    /// NEW and CHID of the conversion that comes next.
    next: u8,
    /// The latest conversion; none since the chip was set up.
    latest: Option<Conversion>,
    /// Board time of the latest conversion, or of the latest restart.
    latest_us: u32,
    /// The latest conversion was read before its edge was served: that edge finds nothing new.
    early: bool,
    /// Unexpected edges less others; see [`STORM_EDGES`].
    unrest: u16,
    /// Unexpected edges since the latest check that found nothing.
    odd: u8,
    muted: bool,
    unseen: Unseen,
    /// Whether the chip was set up.
    answers: bool,
    /// Board time of the latest restart, and the pause before the next.
    restarted_us: u32,
    pause_us: u32,
}

impl<SPI, START, RESET> Acquisition<SPI, START, RESET> {
    /// Takes the driver and the pins START and RESET. Nothing is transferred.
    pub const fn new(adc: Ads1258<SPI>, start: START, reset: RESET) -> Self {
        Self {
            adc,
            start,
            reset,
            next: FIRST,
            latest: None,
            latest_us: 0,
            early: false,
            unrest: 0,
            odd: 0,
            muted: false,
            unseen: Unseen::new(),
            answers: false,
            restarted_us: 0,
            pause_us: 0,
        }
    }
}

impl<SPI: SpiDevice, START: OutputPin, RESET: OutputPin> Acquisition<SPI, START, RESET> {
    /// Resets the chip, writes its registers, reads them back and starts the scan. False if it does not answer as it
    /// should; then [`Self::watch`] tries again. Takes [`ads1258::RESET_LOW_US`] and 25 bytes on the bus.
    pub fn set_up(&mut self, wait: &mut impl DelayNs) -> bool {
        (self.next, self.latest, self.early) = (FIRST, None, false);
        self.answers = self.adc.stop(&mut self.start).is_ok()
            && self.adc.reset_by_pin(&mut self.reset, wait).is_ok()
            && self.adc.configure(&SCAN).is_ok()
            && self.adc.start(&mut self.start).is_ok();
        self.answers
    }

    /// DRDY has fallen and is low: reads the conversion, stamps it with the board time of its edge, microseconds, and
    /// queues it. `edge_us` is asked after the reads. Counts what goes wrong.
    #[inline]
    pub fn edge(
        &mut self,
        edge_us: impl FnOnce() -> u32,
        samples: &mut Producer<'_, TimedConversion>,
        diagnostics: &Diagnostics,
    ) -> Drdy {
        let (first, again) = (self.adc.read().ok(), self.adc.read().ok());
        let t_us = edge_us();
        if let (Some(conversion), Some(again)) = (first, again)
            && conversion.code == again.code
            && conversion.status.0 ^ again.status.0 == NEW
            && conversion.status.0 & NEW_AND_ID == self.next
        {
            self.unrest = self.unrest.saturating_sub(1);
            self.queue(conversion, t_us, samples, diagnostics);
            return Drdy::Listen;
        }
        self.unexpected(first, again, t_us, samples, diagnostics)
    }

    /// DRDY has fallen, but is high again. Counted for a storm, and as [`FaultKind::Repeated`].
    #[inline(never)]
    pub fn nothing(&mut self, edge_us: u32, diagnostics: &Diagnostics) -> Drdy {
        if core::mem::take(&mut self.early) {
            return Drdy::Listen;
        }
        diagnostics.fault(FaultKind::Repeated, edge_us);
        self.stir(edge_us, diagnostics)
    }

    /// Whether no conversion is likely to come soon, so that [`Self::watch`] need not wait for one. Right after a
    /// conversion is the best time for it: the next edge is furthest away.
    pub fn is_quiet(&self, now_us: u32) -> bool {
        self.muted || !self.answers || now_us.wrapping_sub(self.latest_us) > QUIET_US
    }

    /// Checks registers and silence, and restarts the chip if need be. Twice a second at least; when [`Drdy::Watch`] or a
    /// window that is due asks for it. `now_us` is board time. DRDY's interrupt is to be unmuted after it.
    #[inline(never)]
    pub fn watch(&mut self, now_us: u32, diagnostics: &Diagnostics, wait: &mut impl DelayNs) {
        if core::mem::take(&mut self.muted) {
            // Nothing could come meanwhile.
            self.unseen.passed(now_us.wrapping_sub(self.latest_us));
            (self.unrest, self.latest_us) = (0, now_us);
        }
        let trouble = if !self.answers {
            FaultKind::NoAnswer
        } else if self.adc.verify().is_err() && self.adc.verify().is_err() {
            // Read while START is high they have come back wrong: hence a second look.
            FaultKind::Registers
        } else if now_us.wrapping_sub(self.latest_us) > SILENT_US {
            FaultKind::Silent
        } else {
            self.odd = 0;
            self.unseen.is_sound();
            if self.pause_us > 0 && now_us.wrapping_sub(self.restarted_us) > self.pause_us.max(WELL_US) {
                self.pause_us = 0;
            }
            return;
        };
        if now_us.wrapping_sub(self.restarted_us) < self.pause_us {
            diagnostics.fault(trouble, now_us);
            return;
        }
        diagnostics.chip_restarted();
        self.pause_us = (2 * self.pause_us).clamp(PAUSE_LEAST_US, PAUSE_MOST_US);
        let since_us = now_us.wrapping_sub(self.latest_us);
        (self.restarted_us, self.latest_us) = (now_us, now_us);
        match trouble {
            // It has not run since.
            FaultKind::NoAnswer => {}
            FaultKind::Registers => {
                let config0 = self.adc.read_register(Register::Config0).ok();
                diagnostics.unseen(self.unseen.at_most(since_us, config0));
            }
            _ => diagnostics.unseen(Unseen::of_clock(since_us)),
        }
        self.unseen.is_sound();
        let answers = self.set_up(wait);
        // What was wrong before is over, if it answers now: it is told all the same, for it was not told while the
        // board was not looking.
        diagnostics.fault(if answers { trouble } else { FaultKind::NoAnswer }, now_us);
    }

    #[inline(always)]
    fn queue(
        &mut self,
        conversion: Conversion,
        t_us: u32,
        samples: &mut Producer<'_, TimedConversion>,
        diagnostics: &Diagnostics,
    ) {
        self.early = false;
        if self.latest.is_some() {
            self.unseen.passed(t_us.wrapping_sub(self.latest_us));
        }
        self.latest = Some(conversion);
        self.latest_us = t_us;
        self.next = follows(conversion.status.0);
        if samples.enqueue(TimedConversion { t_us, conversion }).is_err() {
            diagnostics.overrun(1);
        }
    }

    /// Conversions of the scan between the one that is due and this one, less whole scans: converted, and gone before they
    /// were read. None for one that is not of the scan.
    fn skipped(&self, conversion: Conversion) -> u32 {
        let (mut status, mut skipped) = (self.next, 0);
        while status & NEW_AND_ID != conversion.status.0 & NEW_AND_ID {
            (status, skipped) = (follows(status), skipped + 1);
            if skipped >= SLOTS {
                return 0;
            }
        }
        skipped
    }

    /// Whatever is not the next conversion, read twice alike.
    #[inline(never)]
    fn unexpected(
        &mut self,
        first: Option<Conversion>,
        again: Option<Conversion>,
        t_us: u32,
        samples: &mut Producer<'_, TimedConversion>,
        diagnostics: &Diagnostics,
    ) -> Drdy {
        let adc = &mut self.adc;
        match settle(self.latest, self.next, first, again, || adc.read().ok()) {
            Resolved::Found(conversion) => {
                diagnostics.overrun(self.skipped(conversion));
                self.queue(conversion, t_us, samples, diagnostics);
                // New, and heard: a processor that is too slow for the scan makes no storm.
                return self.ask();
            }
            Resolved::Mended(conversion) => {
                diagnostics.fault(FaultKind::Bus, t_us);
                diagnostics.overrun(self.skipped(conversion));
                self.queue(conversion, t_us, samples, diagnostics);
            }
            Resolved::Later(conversion) => {
                // The one before it, read once only, is among them.
                diagnostics.overrun(self.skipped(conversion));
                self.queue(conversion, t_us, samples, diagnostics);
                self.early = true;
                return Drdy::Listen;
            }
            Resolved::Garbled => {
                diagnostics.fault(FaultKind::Bus, t_us);
                diagnostics.overrun(1);
                self.next = follows(self.next);
            }
            Resolved::Dead => diagnostics.fault(FaultKind::BusDead, t_us),
            Resolved::Repeated if core::mem::take(&mut self.early) => return Drdy::Listen,
            Resolved::Repeated => diagnostics.fault(FaultKind::Repeated, t_us),
            Resolved::RepeatedGarbled => {
                diagnostics.fault(FaultKind::Bus, t_us);
                diagnostics.fault(FaultKind::Repeated, t_us);
            }
        }
        self.stir(t_us, diagnostics)
    }

    /// Counts an unexpected edge.
    fn stir(&mut self, t_us: u32, diagnostics: &Diagnostics) -> Drdy {
        self.unrest = self.unrest.saturating_add(1);
        if self.unrest >= STORM_EDGES {
            diagnostics.fault(FaultKind::Storm, t_us);
            self.muted = true;
            return Drdy::Mute;
        }
        self.ask()
    }

    /// Asks for a check at the first of [`ODD_EDGES`] unexpected edges.
    fn ask(&mut self) -> Drdy {
        let asks = self.odd.is_multiple_of(ODD_EDGES);
        self.odd = self.odd.wrapping_add(1);
        if asks { Drdy::Watch } else { Drdy::Listen }
    }
}

#[cfg(test)]
mod tests;
