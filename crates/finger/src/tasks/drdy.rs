//! `drdy`: reads and queues a conversion, and checks the chip when that costs no conversion.

use super::shared::{Platform, Shared, Task};
use crate::acquire::{self, Acquisition};
use crate::converter::Converter;
use crate::samples::SampleQueue;
use core::sync::atomic::Ordering::Relaxed;
use embedded_hal::delay::DelayNs;

/// DRDY's pin and its interrupt.
pub trait DrdyPin {
    /// Clears the interrupt. Returns `None` if DRDY has not fallen since the last call, else true
    /// if DRDY is low, so that there is data to read.
    fn acknowledge(&mut self) -> Option<bool>;

    /// Board time (microseconds, wrapping) of the edge whose data was read after
    /// [`Self::acknowledge`].
    fn edge_us(&self) -> u32;

    /// Disables interrupts until [`Self::unmute`].
    fn mute(&mut self);

    /// Enables interrupts for edges from now on. Earlier edges are ignored.
    fn unmute(&mut self);
}

/// State that only this task uses.
pub struct Drdy<'a, C, PIN> {
    /// The chip and its state.
    pub acquisition: Acquisition<C>,
    /// DRDY's pin.
    pub pin: PIN,
    /// Queue to `detect`.
    pub samples: &'a SampleQueue,
    /// Number of the request for the plan in force.
    request: u32,
}

impl<'a, C: Converter, PIN> Drdy<'a, C, PIN> {
    /// The chip, DRDY, and the queue to `detect`.
    pub const fn new(acquisition: Acquisition<C>, pin: PIN, samples: &'a SampleQueue) -> Self {
        Self {
            acquisition,
            pin,
            samples,
            request: 1,
        }
    }
}

impl<C: Converter, PIN: DrdyPin> Drdy<'_, C, PIN> {
    /// Runs when DRDY has fallen, and when another task requests a check of the chip.
    #[inline(always)]
    pub fn run<P: Platform>(&mut self, shared: &Shared<P>, wait: &mut impl DelayNs) {
        let Self {
            acquisition,
            pin,
            samples,
            ..
        } = self;
        let Shared {
            platform,
            diagnostics,
            check,
            health,
            ..
        } = shared;
        let mut edge = pin.acknowledge();
        let (mut is_midway, mut has_checked) = (true, false);
        loop {
            let next = match edge {
                Some(true) => acquisition.edge(|| pin.edge_us(), samples, diagnostics),
                Some(false) => acquisition.nothing(pin.edge_us(), diagnostics),
                None => acquire::Drdy::Listen,
            };
            is_midway &= next == acquire::Drdy::Midway;
            match next {
                acquire::Drdy::Listen | acquire::Drdy::Midway => {}
                acquire::Drdy::Watch => check.store(true, Relaxed),
                // The moment is not safe, so the health readings are scanned once more.
                acquire::Drdy::HealthRead if !acquisition.can_begin(platform.now_us()) => {}
                acquire::Drdy::HealthRead => {
                    // Check first: the set-up would hide a changed register.
                    let _ = acquisition.watch(platform.now_us(), diagnostics, wait);
                    acquisition.read_inputs(diagnostics, wait);
                    pin.unmute();
                }
                acquire::Drdy::Mute => pin.mute(),
            }
            if edge == Some(true) && acquisition.go_on() {
                continue;
            }
            if has_checked {
                break;
            }
            // Clear it after an edge too: left set, it would let the next check begin at any moment.
            let is_urgent = shared.urgent.load(Relaxed);
            if is_urgent {
                shared.urgent.store(false, Relaxed);
            }
            // Right after a read the next conversion is furthest away.
            let may_check = edge.is_some() || is_urgent || acquisition.is_quiet(platform.now_us());
            if may_check && check.load(Relaxed) {
                check.store(false, Relaxed);
                if platform.has_ended() {
                    break;
                }
                let begins_anew = acquisition.watch(platform.now_us(), diagnostics, wait);
                if begins_anew || edge == Some(true) {
                    // Drop edges that came during the check: right after a conversion they cannot
                    // be the next one. On the register model an edge that is kept would show the
                    // same conversion again.
                    pin.unmute();
                    break;
                }
                // If the check followed an unexpected edge, or an estimate was waiting for it, a
                // conversion may have ended in the meantime: read it before the next one replaces
                // it. A storm's edges during the check are cleared.
                let was_silent = edge.is_none();
                edge = pin.acknowledge();
                if edge != Some(true) {
                    if was_silent {
                        // A storm may have muted DRDY: listen to it again.
                        pin.unmute();
                    }
                    break;
                }
                has_checked = true;
            } else {
                let is_requested = shared
                    .plan
                    .number()
                    .is_some_and(|number| number != self.request);
                let is_health_due = health.load(Relaxed) && acquisition.is_health_due();
                let is_due = is_health_due || is_requested;
                if may_check && is_due && acquisition.can_begin(platform.now_us()) {
                    self.begin_scan(shared, wait);
                }
                break;
            }
        }
        shared.liveness.acquired.bump();
        // `detect` has nothing to do before the scan is over.
        if !is_midway {
            P::pend(shared, Task::Detect);
        }
    }

    /// Begins the scan of a different plan, or that of the health readings.
    fn begin_scan<P: Platform>(&mut self, shared: &Shared<P>, wait: &mut impl DelayNs) {
        let Self {
            acquisition,
            pin,
            request,
            ..
        } = self;
        let diagnostics = &shared.diagnostics;
        let next = match shared.plan.number() {
            Some(number) if number != *request => {
                *request = number;
                shared.plan.plan()
            }
            _ => acquisition.plan(),
        };
        let is_health_due = shared.health.swap(false, Relaxed) && acquisition.is_health_due();
        if shared.platform.has_ended() {
            return;
        }
        if next != acquisition.plan() {
            acquisition.change(next, shared.platform.now_us(), diagnostics, wait);
            pin.unmute();
        } else if is_health_due {
            // Check first: the set-up would hide a changed register.
            let _ = acquisition.watch(shared.platform.now_us(), diagnostics, wait);
            let _ = acquisition.read_health(diagnostics, wait);
            pin.unmute();
        }
    }
}

#[cfg(test)]
mod tests;
