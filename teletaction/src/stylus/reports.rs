//! The task `requests`: takes requests, and reports: positions, changes, health.

use super::gate::State;
use super::message::{Change, Event, Health, Hello, Mark, PROTOCOL};
use super::requests::Requests;
use super::sampler::{Look, Sampler};
use super::{REPORT_SAMPLES, SAMPLE_HZ};
use ridgetone_finger::tasks::Outbox;
use ridgetone_finger::tasks::RequestInbox;
use ridgetone_finger::tasks::{PACKETS, Platform, Shared};
use ridgetone_proto::VERSION;
use ridgetone_proto::boot::Boot;
use rtic_core::Mutex;

/// Seconds from one `health` to the next, and from one `hello` to the next.
const HEALTH_S: u32 = 1;
const HELLO_S: u32 = 10;

/// State owned by the task.
#[derive(Debug)]
pub struct Reports {
    requests: Requests,
    boot: Boot,
    /// Samples at the latest position, health and greeting.
    placed: u32,
    healthy: u32,
    greeted: Option<u32>,
    state: State,
    /// Samples at the latest run.
    seen: u32,
}

impl Reports {
    /// Nothing reported yet. `boot`: how this run began.
    pub const fn new(boot: Boot) -> Self {
        Self {
            requests: Requests::new(),
            boot,
            placed: 0,
            healthy: 0,
            greeted: None,
            state: State::Disabled,
            seen: 0,
        }
    }

    /// Runs when a request has arrived, and every [`REPORT_SAMPLES`] samples.
    pub fn run<P: Platform>(
        &mut self,
        sampler: &mut impl Mutex<T = Sampler>,
        inbox: &mut impl Mutex<T = RequestInbox>,
        outbox: &mut impl Mutex<T = Outbox<PACKETS, Mark<Event>>>,
        shared: &Shared<P>,
    ) {
        let is_asked = self.requests.step(sampler, inbox, outbox, shared);
        let look = sampler.lock(|sampler| sampler.look());
        let mut emit = |event| outbox.lock(|outbox| outbox.send(Mark(event), shared));
        let t_us = look.position.t_us;
        let since = |at: u32| look.samples.wrapping_sub(at);
        if is_asked
            || self
                .greeted
                .is_none_or(|at| since(at) >= HELLO_S * SAMPLE_HZ)
        {
            self.greeted = Some(look.samples);
            emit(Event::Hello(Hello {
                protocol: PROTOCOL,
                version: VERSION,
                sample_hz: SAMPLE_HZ,
                parameters: self.requests.parameters,
                boot: self.boot.clone(),
                t_us,
            }));
        }
        if self.state != look.state {
            self.state = look.state;
            emit(Event::State(Change {
                t_us,
                state: look.state,
            }));
        }
        // Half a run early, so that a run more or less of the timer's does not skip one.
        if since(self.placed) >= REPORT_SAMPLES / 2 {
            self.placed = look.samples;
            emit(Event::Position(look.position));
        }
        if since(self.healthy) >= HEALTH_S * SAMPLE_HZ {
            self.healthy = look.samples;
            emit(Event::Health(health(&look, shared)));
        }
        // The finger's policy feeds the watchdog; here samples stand for conversions, and a run of
        // this for a run of `detect`.
        if look.samples != self.seen {
            self.seen = look.samples;
            shared.liveness.acquired.bump();
        }
        shared.liveness.detected.bump();
    }
}

fn health<P>(look: &Look, shared: &Shared<P>) -> Health {
    let diagnostics = &shared.diagnostics;
    let [stack_used_bytes, stack_bytes] = diagnostics.stack_bytes();
    Health {
        t_us: look.position.t_us,
        samples: look.samples,
        deadlines_missed: look.deadlines_missed,
        latest_reading_us: look.latest_reading_us,
        state: look.state,
        amplitude_v: look.amplitude_v,
        requests_damaged: diagnostics.requests_damaged.get(),
        bytes_overrun: diagnostics.bytes_overrun.get(),
        messages_dropped: diagnostics.messages_dropped.get(),
        stack_used_bytes,
        stack_bytes,
        load: diagnostics.load(),
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    #[test]
    fn the_version_is_the_crate_s() {
        let [major, minor, patch] = super::VERSION;
        assert_eq!(
            std::format!("{major}.{minor}.{patch}"),
            env!("CARGO_PKG_VERSION")
        );
    }
}
