//! Commands of a PC: each is first decided, and then takes effect between two windows.

use crate::converter::Facts;
use crate::detector::Detector;
use crate::estimator::Estimator;
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::command::{Command, Outcome, Reply, Request};
use ridgetone_proto::settings::{Settings, SettingsError};
use ridgetone_proto::store::{NotStored, Saved, Store};
use ridgetone_proto::telemetry::Event;

/// State that a decision depends on.
#[derive(Clone, Copy, Debug)]
pub struct At {
    /// True if the finger touches something.
    pub is_touched: bool,
    pub converter: &'static Facts,
}

impl At {
    /// Checks settings, and that the converter can run their plan.
    fn check(&self, settings: &Settings) -> Result<(), SettingsError> {
        settings.validate()?;
        (self.converter.check)(&settings.plan).map_err(SettingsError::from)
    }
}

/// Decides and carries out commands. Keeps the latest reply.
#[derive(Debug, Default)]
pub struct CommandExecutor {
    latest: Option<Reply>,
    /// True if the board resets as soon as the line is silent.
    pub(super) restarting: bool,
}

impl CommandExecutor {
    pub const fn new() -> Self {
        Self {
            latest: None,
            restarting: false,
        }
    }

    /// Decides a command, and stores settings that are to be kept. Returns the reply and, unless
    /// the command is refused, the command for [`Self::carry_out`]. Erases no page while the finger
    /// is touched, because that stops the processor for a second.
    pub fn decide(
        &mut self,
        request: Request,
        at: At,
        store: &mut dyn Store,
    ) -> (Option<Command>, Reply) {
        let Request { number, command } = request;
        if let Some(again) = self.latest.as_ref().filter(|reply| reply.number == number) {
            return (None, again.clone());
        }
        let outcome = match &command {
            _ if self.restarting => Outcome::Busy,
            Command::Set { settings, keep } => match at.check(settings) {
                Err(error) => Outcome::Setting(error),
                Ok(()) if *keep => stored(store.save(Some(settings), !at.is_touched)),
                Ok(()) => Outcome::Done,
            },
            Command::Forget => stored(store.save(None, !at.is_touched)),
            _ => Outcome::Done,
        };
        let settings = match &command {
            Command::Set { settings, .. } => Some(*settings),
            Command::Forget => Some(at.converter.fitting(Settings::DEFAULT)),
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
        (Some(command).filter(|_| is_in_force), reply)
    }

    /// Carries out a command. The windows due before it must have been fitted.
    pub fn carry_out(
        &mut self,
        command: &Command,
        detector: &mut Detector,
        estimator: &mut Estimator,
        emit: &mut dyn FnMut(Event),
    ) {
        let mut change = |detector: &mut Detector, settings: &Settings, source| {
            estimator.change(settings);
            // If the plan changes, the greeting comes later, before the plan's first frame.
            if detector.change(settings, source) {
                emit(detector.hello());
            }
        };
        match command {
            Command::Greet => {
                // A PC that greets may not know the latest texture.
                estimator.textures.forget();
                emit(detector.hello());
                detector.tell_converter();
            }
            Command::Set { settings, .. } => change(detector, settings, SettingsSource::Sent),
            Command::Forget => {
                let defaults = detector.converter().fitting(Settings::DEFAULT);
                change(detector, &defaults, SettingsSource::Default)
            }
            Command::Start => detector.restart(true),
            Command::Stop => detector.restart(false),
            Command::Raw { frames } => detector.report_raw(*frames),
            Command::Restart => self.restarting = true,
        }
    }
}

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
    use ridgetone_proto::command::REQUEST_WIRE_MAX;
    use ridgetone_proto::framing as wire;
    use ridgetone_proto::plan::Plan;
    use ridgetone_proto::settings::{Array, SettingsError, Slide, SlideRule};
    use ridgetone_proto::telemetry::Hello;
    extern crate std;
    use std::boxed::Box;
    use std::vec;

    /// Store in memory. When full, refuses to save during a touch.
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
            let is_full = self.full;
            Ok(if is_full {
                Saved::Erasing
            } else {
                Saved::AtOnce
            })
        }
    }

    struct Board {
        executor: CommandExecutor,
        detector: Box<Detector>,
        estimator: Estimator,
        store: Kept,
        greeted: vec::Vec<Hello>,
    }

    impl Board {
        fn new() -> Self {
            let settings = Settings::DEFAULT;
            Self {
                executor: CommandExecutor::new(),
                detector: Box::new(Detector::new(settings)),
                estimator: Estimator::new(settings),
                store: Kept::default(),
                greeted: vec![],
            }
        }

        fn execute(&mut self, number: u16, command: Command, touched: bool) -> Outcome {
            let request = Request { number, command };
            let at = At {
                is_touched: touched,
                converter: self.detector.converter(),
            };
            let (command, reply) = self.executor.decide(request, at, &mut self.store);
            assert_eq!(reply.number, number);
            let mut emit = |event| match event {
                Event::Hello(hello) => self.greeted.push(hello),
                event => panic!("{event:?}"),
            };
            if let Some(command) = command {
                self.executor.carry_out(
                    &command,
                    &mut self.detector,
                    &mut self.estimator,
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

    fn set(settings: Settings, keep: bool) -> Command {
        Command::Set { settings, keep }
    }

    /// Tests a plan of a different converter, and a rate that does not follow from the registers.
    #[test]
    fn a_plan_that_the_converter_cannot_run_is_refused_with_what_it_can() {
        let mut board = Board::new();
        let foreign = Plan::of_frames(1000.0, 3).unwrap();
        let hasty = Plan {
            frame_ticks: 40_000,
            ..Plan::PAPER
        };
        for (number, plan, field) in [
            (1, foreign, "plan.converter"),
            (2, hasty, "plan.frame_ticks"),
        ] {
            let settings = Settings::DEFAULT.with_plan(plan);
            assert_eq!(settings.validate(), Ok(()), "as another converter's");
            match board.execute(number, set(settings, true), false) {
                Outcome::Setting(error) => assert_eq!(error.field, field),
                outcome => panic!("{outcome:?}"),
            }
        }
        assert_eq!((board.store.saves, board.greeted.len()), (0, 0));
        assert_eq!(*board.detector.settings(), Settings::DEFAULT);
    }

    #[test]
    fn a_stored_plan_of_another_converter_gives_way_to_this_ones_own() {
        let stored = Settings {
            harmonics: 2,
            ..Settings::DEFAULT.with_plan(Plan::of_frames(1000.0, 3).unwrap())
        };
        let facts = Board::new().detector.converter();
        let expected = Settings {
            harmonics: 2,
            ..Settings::DEFAULT
        };
        assert_eq!(facts.fitting(stored), expected);
        assert_eq!(facts.fitting(OTHERS), OTHERS);
    }

    #[test]
    fn the_longest_request_fits_the_wire() {
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
        let (number, command) = (u16::MAX, set(settings, true));
        let request = Request { number, command };
        // Counted by hand: number 3, kind 1, settings 91, keep 1; then 4 of checksum, 1 of stuffing
        // and the zero.
        let mut wire = [0; REQUEST_WIRE_MAX];
        assert_eq!(wire::encode(&request, &mut wire), Ok(102));
    }

    #[test]
    fn settings_are_in_force_and_kept_if_they_are_to_be() {
        let mut board = Board::new();
        assert_eq!(board.execute(1, set(OTHERS, false), false), Outcome::Done);
        assert_eq!(
            (board.store.settings, board.greeted[0].settings),
            (None, OTHERS)
        );
        // A repeated request is not carried out again.
        for _ in 0..2 {
            assert_eq!(board.execute(2, set(OTHERS, true), false), Outcome::Done);
            assert_eq!(board.store.settings, Some(OTHERS));
            assert_eq!(board.greeted[1].source, SettingsSource::Sent);
            assert_eq!((board.store.saves, board.greeted.len()), (1, 2));
        }
        assert_eq!(board.execute(3, Command::Forget, false), Outcome::Done);
        let forgotten = (board.store.settings, board.greeted[2].settings);
        assert_eq!(forgotten, (None, Settings::DEFAULT));
    }

    #[test]
    fn settings_outside_their_bounds_change_nothing() {
        let mut board = Board::new();
        let settings = Settings {
            vref_v: f32::INFINITY,
            ..OTHERS
        };
        match board.execute(1, set(settings, true), false) {
            Outcome::Setting(SettingsError {
                min: 0.5, max: 5.5, ..
            }) => {}
            outcome => panic!("{outcome:?}"),
        }
        assert_eq!((board.store.saves, board.greeted.len()), (0, 0));
    }

    #[test]
    fn in_a_touch_a_full_page_is_reported() {
        let mut board = Board::new();
        board.store.full = true;
        assert_eq!(
            board.execute(1, set(OTHERS, true), true),
            Outcome::NotStored
        );
        assert_eq!((board.store.saves, board.greeted[0].settings), (0, OTHERS));
        assert_eq!(
            board.execute(2, set(OTHERS, true), false),
            Outcome::DoneErased
        );
        assert_eq!(board.store.settings, Some(OTHERS));
    }

    #[test]
    fn who_restarts_does_nothing_else() {
        let mut board = Board::new();
        assert_eq!(board.execute(1, Command::Restart, false), Outcome::Done);
        assert!(board.executor.restarting);
        assert_eq!(board.execute(2, set(OTHERS, true), false), Outcome::Busy);
        assert_eq!(board.execute(1, Command::Restart, false), Outcome::Done);
        assert_eq!((board.store.saves, board.greeted.len()), (0, 0));
    }
}
