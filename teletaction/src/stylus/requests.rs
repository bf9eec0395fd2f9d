//! Requests: each is decided, carried out within a short lock, and answered. A damaged one is
//! refused without its number.

use super::message::{Command, Event, Mark, Outcome, Reply, Request};
use super::parameters::{Parameters, refusal};
use super::sampler::Sampler;
use ridgetone_finger::tasks::Outbox;
use ridgetone_finger::tasks::RequestInbox;
use ridgetone_finger::tasks::{PACKETS, Platform, Shared};
use ridgetone_proto::framing::decode;
use rtic_core::Mutex;

/// State of the requests, owned by the task.
#[derive(Debug)]
pub struct Requests {
    /// The parameters in force.
    pub parameters: Parameters,
    latest: Option<Reply>,
}

impl Default for Requests {
    fn default() -> Self {
        Self::new()
    }
}

impl Requests {
    /// Before the first one.
    pub const fn new() -> Self {
        Self {
            parameters: Parameters::DEFAULT,
            latest: None,
        }
    }

    /// Carries out the request in the inbox, if there is one, and posts its reply. Gives whether
    /// `hello` is due, as new parameters demand.
    pub fn step<P: Platform>(
        &mut self,
        sampler: &mut impl Mutex<T = Sampler>,
        inbox: &mut impl Mutex<T = RequestInbox>,
        outbox: &mut impl Mutex<T = Outbox<PACKETS, Mark<Event>>>,
        shared: &Shared<P>,
    ) -> bool {
        let Some(mut frame) = inbox.lock(|inbox| inbox.take()) else {
            return false;
        };
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
                // Doubles, without making a sample wait.
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
