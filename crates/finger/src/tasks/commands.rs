//! Commands of a PC: each is decided first, and takes effect between two windows.

use crate::detector::Detector;
use crate::estimator::Estimator;
use crate::surface::odometry::track::Track;
use crate::surface::profile::Profile;
use heapless::Vec;
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::command::{Command, Outcome, Part, Reply, Request};
use ridgetone_proto::profile::{After, KNOTS_MAX, Knot};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::store::{NotStored, Saved, Store};
use ridgetone_proto::telemetry::Event;

/// Decides commands and carries them out. Its memory is bounded: a profile, the latest reply. The
/// parts of the next profile are kept in the slots of a robot's track, which is of no use
/// meanwhile.
#[derive(Debug, Default)]
pub struct CommandExecutor {
    /// The speed profile in force.
    pub(super) profile: Option<Profile>,
    /// Knots of the next profile that are in the track's slots.
    knots: usize,
    latest: Option<Reply>,
    /// The board resets as soon as the line is silent.
    pub(super) restarting: bool,
}

impl CommandExecutor {
    /// An executor before the first command.
    pub const fn new() -> Self {
        Self {
            profile: None,
            knots: 0,
            latest: None,
            restarting: false,
        }
    }

    /// Decides a command, and stores settings that are to be kept. Gives the reply, and the command
    /// for [`Self::carry_out`] unless it is refused. While the finger `is_touched` no page is
    /// erased: that stops the processor for a second.
    #[inline(never)]
    pub fn decide(
        &mut self,
        request: Request,
        is_touched: bool,
        store: &mut dyn Store,
        track: &Track,
    ) -> (Option<Command>, Reply) {
        let Request { number, command } = request;
        if let Some(again) = self.latest.as_ref().filter(|reply| reply.number == number) {
            return (None, again.clone());
        }
        if self.knots > 0 && !matches!(command, Command::Follow(_)) {
            // The PC has given up its profile half-way: a robot's places need the room.
            self.knots = 0;
            track.lend(false);
        }
        let outcome = match &command {
            _ if self.restarting => Outcome::Busy,
            Command::Set { settings, keep } => match settings.validate() {
                Err(error) => Outcome::Setting(error),
                Ok(()) if *keep => stored(store.save(Some(settings), !is_touched)),
                Ok(()) => Outcome::Done,
            },
            Command::Forget => stored(store.save(None, !is_touched)),
            Command::Follow(part) => self.collect(part, track),
            _ => Outcome::Done,
        };
        let settings = match &command {
            Command::Set { settings, .. } => Some(settings),
            Command::Forget => Some(&Settings::DEFAULT),
            _ => None,
        };
        let is_in_force = !matches!(outcome, Outcome::Busy | Outcome::Setting(_));
        let gives = settings
            .filter(|_| is_in_force)
            .map(|settings| settings.plan.gives());
        let reply = Reply {
            number,
            outcome,
            gives,
        };
        // A PC that repeats a request after `Busy` must get a new decision.
        if reply.outcome != Outcome::Busy {
            self.latest = Some(reply.clone());
        }
        let is_refused = matches!(
            reply.outcome,
            Outcome::Busy | Outcome::Setting(_) | Outcome::Profile
        );
        (Some(command).filter(|_| !is_refused), reply)
    }

    /// Takes a part of a profile. A part that does not fit drops all parts; the profile in force
    /// stays.
    fn collect(&mut self, part: &Part, track: &Track) -> Outcome {
        if part.first == 0 {
            self.knots = 0;
        }
        let follows = usize::from(part.first) == self.knots && !part.knots.is_empty();
        let fits = follows && self.knots + part.knots.len() <= KNOTS_MAX;
        track.lend(fits);
        if fits {
            for (slot, knot) in (self.knots..).zip(&part.knots) {
                track.write(slot, [knot.t_us, knot.speed_mm_s.to_bits()]);
            }
            self.knots += part.knots.len();
        }
        if !fits
            || part
                .last
                .is_some_and(|after| self.collected(after, track).is_none())
        {
            self.knots = 0;
            track.lend(false);
            return Outcome::Profile;
        }
        Outcome::Done
    }

    /// The profile of the knots in the track's slots, if it is one.
    #[inline(never)]
    fn collected(&self, after: After, track: &Track) -> Option<Profile> {
        let knot = |slot| {
            let [t_us, speed_bits] = track.read(slot);
            Knot {
                t_us,
                speed_mm_s: f32::from_bits(speed_bits),
            }
        };
        let knots: Vec<Knot, KNOTS_MAX> = (0..self.knots.min(KNOTS_MAX)).map(knot).collect();
        Profile::new(&knots, after).ok()
    }

    /// Lets a command take effect. The windows that were due before it must have been fitted.
    #[inline(never)]
    pub fn carry_out(
        &mut self,
        command: &Command,
        (detector, estimator): (&mut Detector, &mut Estimator),
        track: &Track,
        emit: &mut dyn FnMut(Event),
    ) {
        let mut change = |settings: &Settings, source| {
            estimator.change(settings);
            // With another plan the greeting precedes its first frame.
            if detector.change(settings, source) {
                emit(detector.hello());
            }
        };
        match command {
            Command::Greet => {
                // A PC that greets knows nothing yet.
                estimator.textures.forget();
                emit(detector.hello());
            }
            Command::Set { settings, .. } => change(settings, SettingsSource::Sent),
            Command::Forget => change(&Settings::DEFAULT, SettingsSource::Default),
            Command::Start => detector.restart(true),
            Command::Stop => detector.restart(false),
            Command::Raw { frames } => detector.report_raw(*frames),
            Command::Follow(part) => {
                if let Some(after) = part.last {
                    // Built again, because to keep it since `decide` would take half a kilobyte.
                    self.profile = self.collected(after, track);
                    self.knots = 0;
                    track.lend(false);
                }
            }
            Command::Unfollow => {
                (self.profile, self.knots) = (None, 0);
                track.lend(false);
            }
            Command::Restart => self.restarting = true,
        }
    }
}

/// The outcome of storing settings.
fn stored(saved: Result<Saved, NotStored>) -> Outcome {
    match saved {
        Ok(Saved::AtOnce) => Outcome::Done,
        Ok(Saved::Erasing) => Outcome::DoneErased,
        Err(NotStored) => Outcome::NotStored,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::command::{KNOTS_A_COMMAND, REQUEST_WIRE_MAX};
    use ridgetone_proto::framing as wire;
    use ridgetone_proto::settings::{Array, SettingsError, Slide, SlideRule};
    use ridgetone_proto::telemetry::Hello;
    extern crate std;
    use std::boxed::Box;
    use std::vec;

    /// Keeps settings in memory. When it is full, it refuses in a touch.
    #[derive(Default)]
    struct Kept {
        settings: Option<Settings>,
        saves: u32,
        full: bool,
    }

    impl Store for Kept {
        fn load(&mut self) -> (Settings, SettingsSource) {
            (
                self.settings.unwrap_or(Settings::DEFAULT),
                SettingsSource::Stored,
            )
        }

        fn save(
            &mut self,
            settings: Option<&Settings>,
            may_erase: bool,
        ) -> Result<Saved, NotStored> {
            if self.full && !may_erase {
                return Err(NotStored);
            }
            self.settings = settings.copied();
            self.saves += 1;
            Ok(if self.full {
                Saved::Erasing
            } else {
                Saved::AtOnce
            })
        }
    }

    struct Board {
        executor: CommandExecutor,
        detector: Box<Detector>,
        estimator: Box<Estimator>,
        track: Track,
        store: Kept,
        greeted: vec::Vec<Hello>,
    }

    impl Board {
        fn new() -> Self {
            let settings = Settings::DEFAULT;
            let (detector, estimator) = (
                Box::new(Detector::new(settings)),
                Box::new(Estimator::new(settings)),
            );
            let (track, store) = (Track::new(), Kept::default());
            Self {
                executor: CommandExecutor::new(),
                detector,
                estimator,
                track,
                store,
                greeted: vec![],
            }
        }

        fn execute(&mut self, number: u16, command: Command, touched: bool) -> Outcome {
            let (command, reply) = self.executor.decide(
                Request { number, command },
                touched,
                &mut self.store,
                &self.track,
            );
            assert_eq!(reply.number, number);
            let mut emit = |event| match event {
                Event::Hello(hello) => self.greeted.push(hello),
                event => panic!("{event:?}"),
            };
            if let Some(command) = command {
                self.executor.carry_out(
                    &command,
                    (&mut self.detector, &mut self.estimator),
                    &self.track,
                    &mut emit,
                );
            }
            reply.outcome
        }
    }

    const OTHERS: Settings = Settings {
        window_s: 0.5,
        harmonics: 2,
        ..Settings::DEFAULT
    };

    #[test]
    fn the_longest_requests_fit_the_wire_and_every_name_fits_a_reply() {
        let slide = Slide {
            rule: SlideRule::Protocol,
            delay_s: 1.0,
            speed_mm_s: 30.0,
            length_mm: 55.0,
        };
        let array = Array {
            front: u16::MAX,
            alike: [u16::MAX; 4],
            ..Array::DEFAULT
        };
        let settings = Settings {
            slide,
            array,
            ..Settings::DEFAULT
        };
        let knots = Vec::from_slice(
            &[Knot {
                t_us: u32::MAX,
                speed_mm_s: 1.0,
            }; KNOTS_A_COMMAND],
        )
        .unwrap();
        let part = Part {
            first: u8::MAX,
            knots,
            last: Some(After::Repeat),
        };
        // By hand: number 3, kind 1, settings 117, keep 1; number 3, kind 1, first 1, knots 1 + 8
        // (5 + 4), last 2; then 4 of checksum, 1 of stuffing and the zero.
        for (command, bytes) in [
            (
                Command::Set {
                    settings,
                    keep: true,
                },
                128,
            ),
            (Command::Follow(part), 86),
        ] {
            let mut wire = [0; REQUEST_WIRE_MAX];
            assert_eq!(
                wire::encode(
                    &Request {
                        number: u16::MAX,
                        command
                    },
                    &mut wire
                ),
                Ok(bytes)
            );
        }
    }

    #[test]
    fn settings_are_in_force_and_kept_if_they_are_to_be() {
        let mut board = Board::new();
        assert_eq!(
            board.execute(
                1,
                Command::Set {
                    settings: OTHERS,
                    keep: false
                },
                false
            ),
            Outcome::Done
        );
        assert_eq!(
            (board.store.settings, board.greeted[0].settings),
            (None, OTHERS)
        );
        assert_eq!(
            board.execute(
                2,
                Command::Set {
                    settings: OTHERS,
                    keep: true
                },
                false
            ),
            Outcome::Done
        );
        assert_eq!(
            (board.store.settings, board.greeted[1].source),
            (Some(OTHERS), SettingsSource::Sent)
        );
        // The same number again: nothing happens twice.
        assert_eq!(
            board.execute(
                2,
                Command::Set {
                    settings: OTHERS,
                    keep: true
                },
                false
            ),
            Outcome::Done
        );
        assert_eq!((board.store.saves, board.greeted.len()), (1, 2));
        assert_eq!(board.execute(3, Command::Forget, false), Outcome::Done);
        assert_eq!(
            (board.store.settings, board.greeted[2].settings),
            (None, Settings::DEFAULT)
        );
    }

    #[test]
    fn settings_outside_their_bounds_change_nothing() {
        let mut board = Board::new();
        let settings = Settings {
            vref_v: f32::INFINITY,
            ..OTHERS
        };
        let refused = board.execute(
            1,
            Command::Set {
                settings,
                keep: true,
            },
            false,
        );
        assert!(
            matches!(
                refused,
                Outcome::Setting(SettingsError {
                    least: 0.5,
                    greatest: 5.5,
                    ..
                })
            ),
            "{refused:?}"
        );
        assert_eq!((board.store.saves, board.greeted.len()), (0, 0));
    }

    #[test]
    fn in_a_touch_a_full_page_is_reported() {
        let mut board = Board::new();
        board.store.full = true;
        assert_eq!(
            board.execute(
                1,
                Command::Set {
                    settings: OTHERS,
                    keep: true
                },
                true
            ),
            Outcome::NotStored
        );
        assert_eq!((board.store.saves, board.greeted[0].settings), (0, OTHERS));
        assert_eq!(
            board.execute(
                2,
                Command::Set {
                    settings: OTHERS,
                    keep: true
                },
                false
            ),
            Outcome::DoneErased
        );
        assert_eq!(board.store.settings, Some(OTHERS));
    }

    #[test]
    fn a_profile_comes_in_parts_and_is_in_force_with_the_last() {
        let knots = |from: u32, count: u32| {
            (from..from + count)
                .map(|k| Knot {
                    t_us: k,
                    speed_mm_s: 5.0,
                })
                .collect()
        };
        let part = |first: u32, count, last| {
            Command::Follow(Part {
                first: first as u8,
                knots: knots(first, count),
                last,
            })
        };
        let mut board = Board::new();
        for (number, first) in (0u16..).zip((0..24).step_by(8)) {
            assert_eq!(
                board.execute(number, part(first, 8, None), false),
                Outcome::Done
            );
            assert_eq!(board.executor.profile.as_ref(), None);
        }
        assert_eq!(
            board.execute(3, part(24, 8, Some(After::Repeat)), false),
            Outcome::Done
        );
        let all: vec::Vec<Knot> = (0..32)
            .map(|k| Knot {
                t_us: k,
                speed_mm_s: 5.0,
            })
            .collect();
        let whole = Profile::new(&all, After::Repeat).unwrap();
        assert_eq!(board.executor.profile.as_ref(), Some(&whole));
        // A part is missing; one that is out of order; one knot too many. The profile in force
        // stays.
        for (number, wrong) in (4u16..).zip([
            vec![part(8, 8, Some(After::Hold))],
            vec![part(0, 8, None), part(16, 8, Some(After::Hold))],
            vec![part(0, 8, None), part(0, 1, Some(After::Repeat))],
            vec![
                part(0, 8, None),
                part(8, 8, None),
                part(16, 8, None),
                part(24, 8, None),
                part(32, 1, None),
            ],
        ]) {
            let last = wrong.len() - 1;
            for (k, part) in wrong.into_iter().enumerate() {
                let outcome = board.execute(number * 10 + k as u16, part, false);
                assert_eq!(
                    outcome,
                    if k == last {
                        Outcome::Profile
                    } else {
                        Outcome::Done
                    },
                    "{number}"
                );
            }
        }
        assert_eq!(board.executor.profile.as_ref(), Some(&whole));
        assert_eq!(board.execute(100, Command::Unfollow, false), Outcome::Done);
        assert_eq!(board.executor.profile.as_ref(), None);
    }

    #[test]
    fn who_restarts_does_nothing_else() {
        let mut board = Board::new();
        assert_eq!(board.execute(1, Command::Restart, false), Outcome::Done);
        assert!(board.executor.restarting);
        assert_eq!(
            board.execute(
                2,
                Command::Set {
                    settings: OTHERS,
                    keep: true
                },
                false
            ),
            Outcome::Busy
        );
        assert_eq!(board.execute(1, Command::Restart, false), Outcome::Done);
        assert_eq!((board.store.saves, board.greeted.len()), (0, 0));
    }
}
