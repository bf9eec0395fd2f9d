//! Sends requests to a stylus' board until it is in the wanted state, one at a time, each repeated
//! until answered.

use crate::stimulus::Texture;
use crate::stylus::gate::State;
use crate::stylus::message::{Command, Outcome, Reply};
use crate::stylus::parameters::Parameters;
use ridgetone_proto::settings::SettingsError;

/// Time after which an unanswered request is repeated, and minimum time between signs of life,
/// seconds: five fit into the half second after which a board without requests stops.
const REPEAT_S: f64 = 0.1;

/// Requests that the board is known to have executed since it was first heard.
#[derive(Clone, Copy, Debug, Default)]
struct Done {
    is_at_rest: bool,
    is_configured: bool,
    texture: Option<Texture>,
    is_enabled: bool,
}

#[derive(Clone, Copy, Debug)]
struct Sent {
    number: u16,
    command: Command,
    t_s: f64,
    is_answered: bool,
}

#[derive(Clone, Debug)]
pub struct StylusRequests {
    parameters: Parameters,
    /// Texture that should be felt now.
    pub texture: Option<Texture>,
    done: Done,
    refused: Option<Texture>,
    sent: Option<Sent>,
    number: u16,
}

impl StylusRequests {
    /// `first` is the number of the first request. It must differ from the number of the board's
    /// last request, whose reply the board would repeat.
    pub fn new(parameters: Parameters, first: u16) -> Self {
        Self {
            parameters,
            texture: None,
            done: Done::default(),
            refused: None,
            sent: None,
            number: first,
        }
    }

    /// Forgets the board's state, after a start or before it is first heard.
    pub fn forget(&mut self) {
        (self.done, self.sent) = (Done::default(), None);
    }

    /// True if the board has the wanted texture and is enabled.
    pub fn is_done(&self) -> bool {
        self.done.is_enabled && self.done.texture == self.texture
    }

    /// True if the board is known to rest.
    pub fn is_at_rest(&self) -> bool {
        self.done.is_at_rest
    }

    pub fn due(&mut self, t_s: f64) -> Option<(u16, Command)> {
        if let Some(sent) = &mut self.sent
            && !sent.is_answered
        {
            if t_s - sent.t_s < REPEAT_S {
                return None;
            }
            // The texture of a pending request is no longer wanted.
            let is_old =
                matches!(sent.command, Command::Texture(texture) if Some(texture) != self.texture);
            if !is_old {
                sent.t_s = t_s;
                return Some((sent.number, sent.command));
            }
        }
        let is_quiet = self.sent.is_none_or(|sent| t_s - sent.t_s >= REPEAT_S);
        let command = self.next().or(is_quiet.then_some(Command::Alive))?;
        let number = self.number;
        self.number = number.wrapping_add(1);
        self.sent = Some(Sent {
            number,
            command,
            t_s,
            is_answered: false,
        });
        Some((number, command))
    }

    /// Returns the next step towards the wanted state. Parameters change only at rest, so the board
    /// is disabled first.
    fn next(&self) -> Option<Command> {
        let Done {
            is_at_rest,
            is_configured,
            texture,
            is_enabled,
        } = self.done;
        let wanted = self.texture.filter(|wanted| Some(*wanted) != self.refused);
        match wanted {
            _ if !is_configured => Some(if is_at_rest {
                Command::Configure(self.parameters)
            } else {
                Command::Disable
            }),
            None => (!is_at_rest).then_some(Command::Disable),
            Some(wanted) if texture != Some(wanted) => Some(Command::Texture(wanted)),
            Some(_) => (!is_enabled).then_some(Command::Enable),
        }
    }

    /// Takes a reply. Returns what the board refuses: a texture is then not sent again, and refused
    /// parameters make the board unusable.
    pub fn answered(&mut self, t_s: f64, reply: &Reply) -> Option<(Command, SettingsError)> {
        let sent = self
            .sent
            .as_mut()
            .filter(|sent| sent.number == reply.number && !sent.is_answered)?;
        sent.is_answered = true;
        let command = sent.command;
        match (&reply.outcome, command) {
            (Outcome::Done, Command::Configure(_)) => {
                // New parameters erase the texture.
                self.done = Done {
                    is_at_rest: true,
                    is_configured: true,
                    ..Done::default()
                };
            }
            (Outcome::Done, Command::Texture(texture)) => self.done.texture = Some(texture),
            (Outcome::Done, Command::Enable) => {
                (self.done.is_enabled, self.done.is_at_rest) = (true, false)
            }
            (Outcome::Done, Command::Disable) => {
                (self.done.is_enabled, self.done.is_at_rest) = (false, true)
            }
            (Outcome::Done, Command::Alive) => {}
            // The output is still falling: retry soon.
            (Outcome::NotAtRest, _) => (sent.is_answered, sent.t_s) = (false, t_s),
            (Outcome::Refused(why), command) => {
                if let Command::Texture(texture) = command {
                    self.refused = Some(texture);
                }
                return Some((command, why.clone()));
            }
        }
        None
    }

    /// Takes the board's state. A board that stopped because of a silent line must be enabled
    /// again, and one without a texture has restarted.
    pub fn is_now(&mut self, state: State) {
        if state == State::NoTexture && self.done.texture.is_some() {
            // The board has restarted and its greeting was lost, so its parameters and limits are
            // unknown.
            self.forget();
        }
        if matches!(state, State::LineSilent | State::Disabled) && self.done.is_enabled {
            (self.done.is_enabled, self.done.is_at_rest) = (false, true);
        }
    }

    /// Takes the board's present parameters, which differ from the wanted ones after a restart.
    pub fn has(&mut self, parameters: &Parameters) {
        if self.done.is_configured && *parameters != self.parameters {
            self.forget();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Time after which every request may be due.
    const LATER_S: f64 = 1.1 * REPEAT_S;

    const WANTED: Parameters = Parameters {
        still_s: 0.4,
        ..Parameters::DEFAULT
    };

    const SET_UP: [Command; 2] = [Command::Disable, Command::Configure(WANTED)];

    /// Answers requests in virtual time.
    struct Bench {
        requests: StylusRequests,
        t_s: f64,
    }

    impl Bench {
        fn new() -> Self {
            Self {
                requests: StylusRequests::new(WANTED, 7),
                t_s: 0.0,
            }
        }

        fn ready() -> Self {
            let mut bench = Self::new();
            assert_eq!(bench.commands_until_idle(), SET_UP);
            bench
        }

        fn due(&mut self) -> (u16, Command) {
            self.t_s += LATER_S;
            self.requests.due(self.t_s).expect("a request")
        }

        fn answer(&mut self, number: u16, outcome: Outcome) -> Option<(Command, SettingsError)> {
            let reply = Reply { number, outcome };
            self.requests.answered(self.t_s, &reply)
        }

        /// Answers requests until only signs of life are left, and returns them.
        fn commands_until_idle(&mut self) -> Vec<Command> {
            let mut commands = Vec::new();
            for _ in 0..20 {
                let (number, command) = self.due();
                self.answer(number, Outcome::Done);
                if command == Command::Alive {
                    return commands;
                }
                commands.push(command);
            }
            panic!("{commands:?}");
        }
    }

    #[test]
    fn a_board_is_set_up_gets_its_texture_and_is_kept_alive() {
        let mut bench = Bench::ready();
        let [first, second] = [1.4, 0.9].map(Texture::new);
        let all = [&SET_UP[..], &[Command::Texture(second), Command::Enable]].concat();
        type Change = fn(&mut StylusRequests);
        let nothing: Change = |_| {};
        let line_silent: Change = |requests| requests.is_now(State::LineSilent);
        let started: Change = |requests| requests.has(&Parameters::DEFAULT);
        let the_same: Change = |requests| requests.has(&WANTED);
        let disabled: Change = |requests| requests.is_now(State::Disabled);
        // The board has restarted, and its greeting was lost.
        let no_texture: Change = |requests| requests.is_now(State::NoTexture);
        let cases: [(Change, Option<Texture>, &[Command]); 9] = [
            (
                nothing,
                Some(first),
                &[Command::Texture(first), Command::Enable],
            ),
            (nothing, Some(second), &[Command::Texture(second)]),
            (nothing, None, &[Command::Disable]),
            // The board still has the texture.
            (nothing, Some(second), &[Command::Enable]),
            (line_silent, Some(second), &[Command::Enable]),
            (started, Some(second), &all),
            (the_same, Some(second), &[]),
            (disabled, Some(second), &[Command::Enable]),
            (no_texture, Some(second), &all),
        ];
        for (case, (change, texture, commands)) in cases.into_iter().enumerate() {
            bench.requests.texture = texture;
            change(&mut bench.requests);
            assert_eq!(bench.commands_until_idle(), commands, "{case}");
            let is_done = (bench.requests.is_done(), bench.requests.is_at_rest());
            assert_eq!(is_done, (texture.is_some(), texture.is_none()), "{case}");
        }
    }

    #[test]
    fn what_is_not_answered_is_repeated_under_its_number() {
        let mut bench = Bench::new();
        let first = Some((7, Command::Disable));
        assert_eq!(bench.requests.due(0.0), first);
        assert_eq!(bench.requests.due(0.99 * REPEAT_S), None);
        assert_eq!(bench.requests.due(REPEAT_S), first);
        bench.answer(3, Outcome::Done);
        assert!(!bench.requests.is_at_rest(), "a reply to another request");
        bench.t_s = REPEAT_S;
        bench.answer(7, Outcome::Done);
        let second = Some((8, Command::Configure(WANTED)));
        assert_eq!(bench.requests.due(REPEAT_S), second);
        bench.answer(8, Outcome::NotAtRest);
        assert_eq!(bench.requests.due(1.5 * REPEAT_S), None);
        assert_eq!(bench.requests.due(2.0 * REPEAT_S), second);
    }

    #[test]
    fn a_texture_that_is_refused_is_not_felt_and_not_sent_again() {
        let mut bench = Bench::ready();
        let bad = Texture::new(1e9);
        bench.requests.texture = Some(bad);
        let (number, command) = bench.due();
        assert_eq!(command, Command::Texture(bad));
        let why = SettingsError {
            field: "period_mm".try_into().expect("short"),
            value: 1e9,
            min: 0.05,
            max: 100.0,
        };
        let refused = bench.answer(number, Outcome::Refused(why.clone()));
        assert_eq!(refused, Some((command, why)));
        assert_eq!(bench.commands_until_idle(), []);
        assert!(!bench.requests.is_done());
    }

    /// Tests that a new texture replaces one whose request is still unanswered.
    #[test]
    fn the_latest_texture_counts() {
        let mut bench = Bench::ready();
        for texture in [1.4, 0.9].map(Texture::new) {
            bench.requests.texture = Some(texture);
            assert_eq!(bench.due().1, Command::Texture(texture));
        }
    }
}
