//! Tests samples and requests on a PC without a board: time, deadlines, limits and refusals.

use proptest::prelude::*;
use ridgetone_proto::command::REQUEST_WIRE_MAX;
use ridgetone_proto::framing;
use ridgetone_teletaction::link::simulated::Tasks;
use ridgetone_teletaction::stimulus::{Actuator, Texture};
use ridgetone_teletaction::stylus::gate::State;
use ridgetone_teletaction::stylus::message::{Command, Event, Mark, Outcome, Request};
use ridgetone_teletaction::stylus::parameters::Parameters;
use ridgetone_teletaction::stylus::sampler::Look;

struct Bench {
    tasks: Tasks,
    now_us: u32,
    number: u16,
}

impl Bench {
    fn new() -> Self {
        Self {
            tasks: Tasks::default(),
            // The counter is about to wrap.
            now_us: u32::MAX - 5000,
            number: 0,
        }
    }

    /// Runs a sample in time, and returns its code.
    fn sample(&mut self, counter: i32) -> u16 {
        self.now_us = self.now_us.wrapping_add(100);
        let code = self.tasks.sampler.next(self.now_us, 0, counter as u16);
        self.tasks.sampler.written(false);
        code
    }

    fn look(&self) -> Look {
        self.tasks.sampler.look()
    }

    fn bytes(&mut self, bytes: &[u8]) -> Option<Outcome> {
        let packets = self.tasks.receive(bytes).into_iter();
        let mut replies = packets.filter_map(|packet| match packet.event.0 {
            Event::Reply(reply) => Some(reply.outcome),
            _ => None,
        });
        replies.next()
    }

    fn command(&mut self, command: Command) -> Option<Outcome> {
        self.number += 1;
        let mut wire = [0; REQUEST_WIRE_MAX];
        let request = Request {
            number: self.number,
            command: Mark(command),
        };
        let used = framing::encode(&request, &mut wire).expect("it fits");
        self.bytes(&wire[..used])
    }
}

/// The longest requests must fit the line, and finger and stylus must refuse each other's messages.
#[test]
fn neither_takes_the_others_messages() {
    let mut wire = [0; REQUEST_WIRE_MAX];
    let finger = ridgetone_proto::command::Request {
        number: 1,
        command: ridgetone_proto::command::Command::Greet,
    };
    let used = framing::encode(&finger, &mut wire).expect("it fits");
    let mut bench = Bench::new();
    assert_eq!(bench.bytes(&wire[..used]), None);
    assert_eq!(bench.tasks.requests_damaged(), 1);
    for command in [
        Command::Configure(Parameters::DEFAULT),
        Command::Texture(Texture::new(1.4)),
        Command::Enable,
        Command::Alive,
    ] {
        let request = Request {
            number: u16::MAX,
            command: Mark(command),
        };
        let used = framing::encode(&request, &mut wire).expect("it fits");
        let taken = framing::decode::<ridgetone_proto::command::Request>(&mut wire[..used - 1]);
        assert_eq!(taken, None, "{command:?}");
    }
}

#[test]
fn time_goes_on_over_a_wrap_and_missed_triggers_are_counted() {
    let mut bench = Bench::new();
    for n in 1..=100u32 {
        bench.sample(0);
        let look = bench.look();
        assert_eq!(
            (look.position.t_us, look.samples, look.deadlines_missed),
            (u64::from(100 * n), n, 0)
        );
    }
    // A delay of 30 us is in time. The two counters may step at different moments.
    bench
        .tasks
        .sampler
        .next(bench.now_us.wrapping_add(131), 30, 0);
    let look = bench.look();
    assert_eq!(
        (look.samples, look.deadlines_missed, look.latest_reading_us),
        (101, 0, 30)
    );
    // Miss three triggers, and write a code too late.
    bench
        .tasks
        .sampler
        .next(bench.now_us.wrapping_add(500), 0, 0);
    bench.tasks.sampler.written(true);
    let look = bench.look();
    assert_eq!(
        (look.position.t_us, look.samples, look.deadlines_missed),
        (10_500, 105, 4)
    );
}

#[test]
fn a_texture_is_taken_and_impossible_ones_are_named() {
    let mut bench = Bench::new();
    assert_eq!(
        bench.command(Command::Texture(Texture::new(1.4))),
        Some(Outcome::Done)
    );
    let refused = bench.command(Command::Texture(Texture::new(f32::NAN)));
    assert!(
        matches!(&refused, Some(Outcome::Refused(error)) if error.field == "period_mm"),
        "{refused:?}"
    );
    assert_eq!(bench.command(Command::Enable), Some(Outcome::Done));
    let codes: Vec<u16> = (0..2000).map(|n| bench.sample(3 * n)).collect();
    assert_eq!(bench.look().state, State::Vibrating);
    assert!(codes.iter().max() > Some(&2500) && codes[1000..].iter().min() < Some(&1600));
    assert_eq!(
        bench.command(Command::Configure(Parameters::DEFAULT)),
        Some(Outcome::NotAtRest)
    );
    assert_eq!(bench.command(Command::Disable), Some(Outcome::Done));
    for _ in 0..400 {
        bench.sample(6000);
    }
    assert_eq!(bench.sample(6000), 2048);
    let mut parameters = Parameters::DEFAULT;
    parameters.actuator.voltage_v = 5.0;
    let configured = bench.command(Command::Configure(parameters));
    assert_eq!(configured, Some(Outcome::Done));
    assert_eq!(bench.sample(6000), 2048, "the middle is the middle");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_code_is_beyond_the_slew_whatever_comes(
        (voltage_v, slew_v_s, fade_s) in (0.1f32..200.0, 10.0f32..1e6, 0.001f32..0.1),
        moves in prop::collection::vec((any::<i16>(), 0u8..8, 0.01f32..120.0), 1..200),
    ) {
        let mut bench = Bench::new();
        let actuator = Actuator { voltage_v, slew_v_s, fade_s, ..Actuator::PIEZO };
        let configured = bench.command(Command::Configure(Parameters { actuator, ..Parameters::DEFAULT }));
        prop_assert_eq!(configured, Some(Outcome::Done));
        let max = (f64::from(slew_v_s) / 1e4 / f64::from(voltage_v) * 4095.0 * 1.000_001).max(1.0) as u16;
        let (mut counter, mut last) = (0i32, 0u16);
        for (speed, what, value) in moves {
            match what {
                0 => drop(bench.command(Command::Enable)),
                1 => drop(bench.command(Command::Disable)),
                2 | 3 => drop(bench.command(Command::Texture(Texture { power: 6000.0, ..Texture::new(value) }))),
                _ => {}
            }
            for _ in 0..30 {
                counter = counter.wrapping_add(i32::from(speed) >> (what + 2));
                let code = bench.sample(counter);
                prop_assert!(code <= 4095 && code.abs_diff(last) <= max, "{last} {code} {max}");
                last = code;
            }
        }
    }
}
