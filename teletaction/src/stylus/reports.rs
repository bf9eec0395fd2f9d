//! The task `requests`. It executes each request within a short lock and answers it; a damaged
//! request is refused without its number. It also reports positions, state changes and health.

use super::gate::State;
use super::message::{
    Change, Command, Event, Health, Hello, Mark, Outcome, PROTOCOL, Reply, Request,
};
use super::parameters::{Parameters, refusal};
use super::sampler::{Look, Sampler};
use super::{REPORT_SAMPLES, SAMPLE_HZ};
use ridgetone_finger::tasks::{Outbox, Platform, RequestInbox, Shared, Task};
use ridgetone_proto::VERSION;
use ridgetone_proto::boot::Boot;
use ridgetone_proto::framing::decode;
use rtic_core::Mutex;

/// Intervals of `health` and of `hello`, seconds.
const HEALTH_S: u32 = 1;
const HELLO_S: u32 = 10;

#[derive(Debug)]
pub struct Reports {
    parameters: Parameters,
    latest: Option<Reply>,
    boot: Boot,
    /// Sample numbers of the latest position report, health message and greeting.
    placed: u32,
    healthy: u32,
    greeted: Option<u32>,
    state: State,
    /// Sample number at the latest run.
    seen: u32,
}

impl Reports {
    /// Creates the task. `boot` is the reason why this run began.
    pub const fn new(boot: Boot) -> Self {
        Self {
            parameters: Parameters::DEFAULT,
            latest: None,
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
        outbox: &mut impl Mutex<T = Outbox<Mark<Event>>>,
        shared: &Shared<P>,
    ) {
        let is_asked = self.request(sampler, inbox, outbox, shared);
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
                parameters: self.parameters,
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
        // Half an interval of slack, so that timer jitter does not skip a report.
        if since(self.placed) >= REPORT_SAMPLES / 2 {
            self.placed = look.samples;
            emit(Event::Position(look.position));
        }
        if since(self.healthy) >= HEALTH_S * SAMPLE_HZ {
            self.healthy = look.samples;
            emit(Event::Health(health(&look, shared)));
        }
        // The finger's policy feeds the watchdog; here samples count as conversions, and a run of
        // this task as a run of `detect`.
        if look.samples != self.seen {
            self.seen = look.samples;
            shared.liveness.acquired.bump();
        }
        shared.liveness.detected.bump();
    }

    /// Executes the request in the inbox, if there is one, and posts its reply. Returns true if
    /// `hello` is due because of new parameters.
    fn request<P: Platform>(
        &mut self,
        sampler: &mut impl Mutex<T = Sampler>,
        inbox: &mut impl Mutex<T = RequestInbox>,
        outbox: &mut impl Mutex<T = Outbox<Mark<Event>>>,
        shared: &Shared<P>,
    ) -> bool {
        let Some(mut frame) = inbox.lock(|inbox| inbox.take()) else {
            return false;
        };
        // Let `report` receive the next request.
        P::pend(shared, Task::Report);
        let Some(Request {
            number,
            command: Mark(command),
        }) = decode(&mut frame)
        else {
            shared.diagnostics.requests_damaged.add(1);
            return false;
        };
        sampler.lock(|sampler| sampler.heard());
        let again = self.latest.as_ref().filter(|reply| reply.number == number);
        let is_new = again.is_none();
        let reply = again.cloned().unwrap_or_else(|| Reply {
            number,
            outcome: self.carry_out(&command, sampler),
        });
        let is_done = reply.outcome == Outcome::Done;
        // A PC that repeats a request which came too early must get a new decision.
        self.latest = Some(reply.clone()).filter(|reply| reply.outcome != Outcome::NotAtRest);
        outbox.lock(|outbox| outbox.send(Mark(Event::Reply(reply)), shared));
        is_new && is_done && matches!(command, Command::Configure(_))
    }

    fn carry_out(&mut self, command: &Command, sampler: &mut impl Mutex<T = Sampler>) -> Outcome {
        match command {
            Command::Alive => {}
            Command::Texture(texture) => {
                // Computes in f64 without the lock, so no sample is delayed.
                match sampler.lock(|sampler| sampler.stimulus()).prepare(texture) {
                    Ok(prepared) => sampler.lock(|sampler| sampler.texture(&prepared)),
                    Err(error) => return Outcome::Refused(refusal(error)),
                }
            }
            Command::Configure(parameters) => match parameters.stimulus() {
                Ok(stimulus)
                    if sampler.lock(|sampler| sampler.configure(parameters, &stimulus)) =>
                {
                    self.parameters = *parameters;
                }
                Ok(_) => return Outcome::NotAtRest,
                Err(error) => return Outcome::Refused(error),
            },
            Command::Enable => sampler.lock(|sampler| sampler.enable(true)),
            Command::Disable => sampler.lock(|sampler| sampler.enable(false)),
        }
        Outcome::Done
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
