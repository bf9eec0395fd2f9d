//! Tests the stylus' image on the register model. A simulated hand moves the encoder, and the
//! converter's output is compared with the surface in f64.

use hal_mock::Constant;
use ridgetone_emulator::{Board, Emulator, Image, ProcessorFault, Start};
use ridgetone_proto::boot::ResetCause;
use ridgetone_proto::command::REQUEST_WIRE_MAX;
use ridgetone_proto::framing;
use ridgetone_teletaction::stimulus::{Actuator, AmplitudeLaw, Harmonic, Texture};
use ridgetone_teletaction::stylus::gate::State;
use ridgetone_teletaction::stylus::message::{
    Command, Decoder, Event, Health, Mark, Outcome, Request,
};
use ridgetone_teletaction::stylus::parameters::Parameters;
use std::f64::consts::TAU;

/// Default parameters: millimetres per count, and volts at the maximum code.
const COUNT_MM: f64 = 0.005;
const VOLTS: f64 = 150.0;

/// Interrupts of TIM6 (RM0090, table 61) and of the line.
const IRQ_TIM6: u16 = 54;
const IRQ_USART3: u16 = 39;

struct Stylus {
    emulator: Emulator,
    decoder: Decoder,
    events: Vec<Event>,
    number: u16,
}

/// Encodes a request, preceded by a zero that ends an earlier frame on the line.
fn request(number: u16, command: Command) -> Vec<u8> {
    let mut bytes = vec![0; REQUEST_WIRE_MAX + 1];
    let request = Request {
        number,
        command: Mark(command),
    };
    let used = framing::encode(&request, &mut bytes[1..]).expect("it fits");
    bytes.truncate(used + 1);
    bytes
}

impl Stylus {
    /// Starts a stylus, and waits until it has greeted and is at 0 V under a resting hand.
    fn ready() -> Self {
        let image = Image::built(Board::StylusF405).unwrap_or_else(|error| panic!("{error}"));
        let scene = Constant::default();
        let emulator =
            Emulator::new(Board::StylusF405, &image, scene, Start::default()).expect("vectors");
        let mut stylus = Self {
            emulator,
            decoder: Decoder::new(),
            events: Vec::new(),
            number: 0,
        };
        stylus.run_s(0.1);
        assert!(matches!(stylus.events.first(), Some(Event::Hello(_))));
        stylus
    }

    fn run_s(&mut self, s: f64) {
        let outcome = self.emulator.run_ns((s * 1e9) as u64);
        for byte in self.emulator.take_sent() {
            self.events
                .extend(self.decoder.push(byte).map(|packet| packet.event.0));
        }
        outcome.unwrap_or_else(|failure| panic!("{failure}"));
    }

    /// Runs while sending `Alive` ten times a second.
    fn run_alive_s(&mut self, s: f64) {
        for _ in 0..(10.0 * s).round() as u32 {
            assert_eq!(self.command(Command::Alive), Outcome::Done);
            self.run_s(0.095);
        }
    }

    #[track_caller]
    fn command(&mut self, command: Command) -> Outcome {
        self.number += 1;
        self.emulator.send(&request(self.number, command));
        let seen = self.events.len();
        self.run_s(0.005);
        let reply = self.events[seen..].iter().find_map(|event| match event {
            Event::Reply(reply) if reply.number == self.number => Some(reply.outcome.clone()),
            _ => None,
        });
        reply.unwrap_or_else(|| panic!("no reply: {:?}", &self.events[seen..]))
    }

    /// Moves the hand; `position_mm` is a function of the seconds from now.
    fn move_hand(&mut self, position_mm: impl Fn(f64) -> f64 + 'static) {
        let from_ns = self.emulator.now_ns();
        self.emulator.move_hand(move |ns| {
            (position_mm((ns as f64 - from_ns as f64) * 1e-9) / COUNT_MM).floor() as i64
        });
    }

    fn state(&self) -> Option<State> {
        self.events.iter().rev().find_map(|event| match event {
            Event::State(change) => Some(change.state),
            _ => None,
        })
    }

    fn health(&mut self) -> Health {
        self.run_s(1.1);
        let healths = self.events.iter().rev().find_map(|event| match event {
            Event::Health(health) => Some(*health),
            _ => None,
        });
        healths.expect("health")
    }

    /// Asserts that no rule of the chip was broken, and that successive codes differ by no more
    /// than the slew.
    #[track_caller]
    fn assert_limits(&self) {
        assert!(
            self.emulator.findings().is_empty(),
            "{:#?}",
            self.emulator.findings()
        );
        let slew = f64::from(Actuator::PIEZO.slew_v_s) / 10_000.0 / VOLTS * 4095.0;
        let codes = self
            .emulator
            .outputs()
            .iter()
            .filter_map(|output| output.code);
        let codes: Vec<u16> = codes.collect();
        let step = codes.windows(2).map(|pair| pair[0].abs_diff(pair[1])).max();
        assert!(
            step.is_some_and(|step| f64::from(step) <= slew),
            "{step:?} of {slew}"
        );
    }

    /// Returns the output from `from_s` on (seconds since power-up): the middle of each sample, and
    /// volts.
    fn volts_from(&self, from_s: f64) -> Vec<(f64, f64)> {
        let outputs = self.emulator.outputs().iter();
        outputs
            .map(|output| {
                let volts = f64::from(output.code.unwrap_or(0)) / 4095.0 * VOLTS;
                (output.at_ns as f64 * 1e-9 + 5e-5, volts)
            })
            .filter(|(t_s, _)| *t_s > from_s)
            .collect()
    }

    fn now_s(&self) -> f64 {
        self.emulator.now_ns() as f64 * 1e-9
    }

    /// Asserts the state, and that the output has been at its bias for `s` seconds.
    #[track_caller]
    fn assert_rests(&self, state: State, s: f64) {
        assert_eq!(self.state(), Some(state));
        let volts = self.volts_from(self.now_s() - s);
        assert!(volts.iter().all(|(_, v)| (v - 0.5 * VOLTS).abs() < 0.1));
    }
}

/// The output must be 0 V at first, rise softly, and be y = A sin(2 pi x / period) + B at the
/// middle of each sample, for the paper's mean hand (section IV-A) and its fastest.
#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn it_rises_softly_and_its_output_is_the_surface() {
    let hands: [fn(f64) -> f64; 2] = [
        |t| 197.0 / (TAU * 1.07) * (1.0 - (TAU * 1.07 * t).cos()),
        |t| -230.0 * t,
    ];
    for (position, period_mm) in hands.into_iter().zip([1.0, 1.4]) {
        let mut stylus = Stylus::ready();
        stylus.command(Command::Texture(Texture::new(period_mm as f32)));
        assert!(
            stylus
                .emulator
                .outputs()
                .iter()
                .all(|output| output.code == Some(0)),
            "a texture alone is not enough"
        );
        let enabled = stylus.emulator.outputs().len();
        stylus.command(Command::Enable);
        let from_s = stylus.now_s();
        stylus.move_hand(position);
        stylus.run_alive_s(1.2);
        stylus.assert_limits();
        let codes = stylus.emulator.outputs()[enabled..].iter();
        let rise: Vec<u16> = codes.filter_map(|output| output.code).take(40).collect();
        assert!(
            rise[0] == 0
                && rise
                    .windows(2)
                    .all(|pair| pair[1].saturating_sub(pair[0]) <= 10),
            "{rise:?}"
        );
        // Equations 2 and 3 are covered by a test of the stimulus.
        let true_v = 75.0 * f64::from(AmplitudeLaw::OKAMOTO.fraction(period_mm as f32, 0.0));
        let mut worst = 0.0f64;
        // The filter settles and the vibration fades in within 0.1 s.
        for (t_s, volts) in stylus.volts_from(from_s + 0.1) {
            let surface = true_v * (TAU * position(t_s - from_s) / period_mm).sin();
            worst = worst.max((volts - 0.5 * VOLTS - surface).abs() / true_v);
        }
        // Every sample must be within 0.02 cycles plus one code, 37 mV.
        assert!(
            worst < 0.02 * TAU + 0.037 / true_v,
            "{period_mm} mm: {worst}"
        );
    }
}

/// The output must stop softly when the hand rests, when the line is silent and when the stylus is
/// disabled. The watchdog must reset a board without samples.
#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn it_stops_softly_and_a_dead_sampler_is_reset() {
    let mut stylus = Stylus::ready();
    stylus.command(Command::Texture(Texture::new(1.4)));
    stylus.command(Command::Enable);
    stylus.move_hand(|t_s| 100.0 * t_s.min(0.3));
    stylus.run_alive_s(1.0);
    stylus.assert_rests(State::HandStill, 0.1);
    stylus.move_hand(|t_s| -100.0 * t_s);
    stylus.run_alive_s(0.2);
    assert_eq!(stylus.state(), Some(State::Vibrating));
    stylus.run_s(1.0);
    stylus.assert_rests(State::LineSilent, 0.4);
    stylus.command(Command::Enable);
    stylus.run_s(0.1);
    assert_eq!(stylus.state(), Some(State::Vibrating));
    stylus.command(Command::Disable);
    stylus.run_s(0.1);
    stylus.assert_rests(State::Disabled, 0.075);

    stylus.assert_limits();
    stylus.emulator.inject(ProcessorFault::Mask(IRQ_TIM6));
    stylus.run_s(9.5);
    let watchdog = |event: &Event| matches!(event, Event::Hello(hello) if hello.boot.cause == ResetCause::Watchdog);
    assert!(stylus.events.iter().any(watchdog));
}

/// The interrupt may take a tenth of the sample period, with all harmonics and back-to-back bytes.
/// No sample may be late in 4 s of this, and a missed one must be counted.
#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn every_sample_is_in_time() {
    let mut stylus = Stylus::ready();
    stylus.command(Command::Configure(Parameters::DEFAULT));
    let overtone = |phase_cycles| Harmonic {
        amplitude: 0.3,
        phase_cycles,
    };
    let texture = Texture {
        overtones: [0.1, -0.7, 0.4].map(overtone),
        power: 6000.0,
        ..Texture::new(2.0)
    };
    stylus.command(Command::Texture(texture));
    stylus.command(Command::Enable);
    stylus.move_hand(|t_s| 40.0 * (TAU * 0.7 * t_s).sin());
    stylus.emulator.forget_served();
    let outputs = stylus.emulator.outputs().len();
    for n in 0..20 {
        let texture = Texture {
            period_mm: 1.0 + 0.02 * n as f32,
            ..texture
        };
        let many: Vec<u8> = (0..200)
            .flat_map(|number| request(5000 + 200 * n + number, Command::Texture(texture)))
            .collect();
        stylus.emulator.send(&many);
        stylus.run_s(0.2);
    }
    assert_eq!(stylus.state(), Some(State::Vibrating));
    let (served, line) = (
        stylus.emulator.served(IRQ_TIM6),
        stylus.emulator.served(IRQ_USART3),
    );
    println!("the interrupt of a sample: {served:?}; the line's: {line:?}");
    assert!(
        served.times > 39_000 && served.longest_run_cycles <= 1680,
        "{served:?}"
    );
    assert!(
        stylus.emulator.outputs()[outputs..]
            .windows(2)
            .all(|pair| (pair[1].at_ns - pair[0].at_ns).abs_diff(100_000) <= 1),
        "to the cycle"
    );
    let health = stylus.health();
    println!("{health:?}");
    assert_eq!((health.deadlines_missed, health.bytes_overrun), (0, 0));
    assert!(
        health.stack_used_bytes > 0 && health.stack_bytes - health.stack_used_bytes > 4096,
        "{health:?}"
    );
    stylus.emulator.inject(ProcessorFault::Mask(IRQ_TIM6));
    stylus.run_s(0.001);
    stylus.emulator.inject(ProcessorFault::Unmask(IRQ_TIM6));
    let missed = stylus.health().deadlines_missed;
    // Ten triggers are masked; the last one may still be served.
    assert!((9..=10).contains(&missed), "{missed}");
    stylus.assert_limits();
}
