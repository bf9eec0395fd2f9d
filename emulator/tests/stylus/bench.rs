//! A stylus that runs its image under a simulated hand, and what it reports and puts out.

use hal_mock::Constant;
use ridgetone_emulator::{Board, Emulator, Image, Output, Start};
use ridgetone_proto::command::REQUEST_WIRE_MAX;
use ridgetone_proto::framing;
use ridgetone_stimulus::Actuator;
use ridgetone_stylus::gate::State;
use ridgetone_stylus::message::{Command, Decoder, Event, Health, Mark, Outcome, Request};
use ridgetone_stylus::parameters::Parameters;
use std::f64::consts::TAU;

/// One count, millimetres, and volts of the greatest code, of the default parameters.
pub const COUNT_MM: f64 = 0.005;
pub const VOLTS: f64 = 150.0;

/// TIM6's interrupt (RM0090, table 61).
pub const IRQ_TIM6: u16 = 54;

pub struct Stylus {
    pub emulator: Emulator,
    decoder: Decoder,
    pub events: Vec<Event>,
    number: u16,
}

/// The counts of a place.
pub fn counts(x_mm: f64) -> i64 {
    (x_mm / COUNT_MM).floor() as i64
}

/// A request as it travels, behind a zero that ends what was on the line before.
pub fn request(number: u16, command: Command) -> Vec<u8> {
    let mut bytes = vec![0; REQUEST_WIRE_MAX + 1];
    let used = framing::encode(
        &Request {
            number,
            command: Mark(command),
        },
        &mut bytes[1..],
    )
    .expect("it fits");
    bytes.truncate(used + 1);
    bytes
}

impl Stylus {
    /// Powered, with a hand that rests.
    pub fn new() -> Self {
        let image = Image::built(Board::StylusF405).unwrap_or_else(|error| panic!("{error}"));
        let emulator = Emulator::new(
            Board::StylusF405,
            &image,
            Constant::default(),
            Start::default(),
        )
        .expect("vectors");
        Self {
            emulator,
            decoder: Decoder::new(),
            events: Vec::new(),
            number: 0,
        }
    }

    /// One that has greeted, and waits at 0 V.
    pub fn ready() -> Self {
        let mut stylus = Self::new();
        stylus.run_s(0.1);
        assert!(
            matches!(stylus.events.first(), Some(Event::Hello(_))),
            "{:?}",
            stylus.events
        );
        stylus
    }

    /// Runs for `s` seconds of virtual time.
    pub fn run_s(&mut self, s: f64) {
        let outcome = self.emulator.run_ns((s * 1e9) as u64);
        for byte in self.emulator.take_sent() {
            self.events
                .extend(self.decoder.push(byte).map(|packet| packet.event.0));
        }
        outcome.unwrap_or_else(|failure| panic!("{failure}"));
    }

    /// Runs while the line is kept alive, ten times a second.
    pub fn run_alive_s(&mut self, s: f64) {
        for _ in 0..(10.0 * s).round() as u32 {
            assert_eq!(self.command(Command::Alive), Outcome::Done);
            self.run_s(0.095);
        }
    }

    /// Sends a command and waits for its reply.
    #[track_caller]
    pub fn command(&mut self, command: Command) -> Outcome {
        self.number += 1;
        self.repeat(self.number, command)
    }

    /// Sends a command with a given number.
    #[track_caller]
    pub fn repeat(&mut self, number: u16, command: Command) -> Outcome {
        self.emulator.send(&request(number, command));
        let seen = self.events.len();
        self.run_s(0.005);
        let reply = self.events[seen..].iter().find_map(|event| match event {
            Event::Reply(reply) if reply.number == number => Some(reply.outcome.clone()),
            _ => None,
        });
        reply.unwrap_or_else(|| panic!("no reply to {number}: {:?}", &self.events[seen..]))
    }

    /// Moves the hand from now on: millimetres from where it is, by seconds from now.
    pub fn move_hand(&mut self, place_mm: impl Fn(f64) -> f64 + 'static) {
        let from_ns = self.emulator.now_ns();
        self.emulator
            .move_hand(move |ns| counts(place_mm((ns as f64 - from_ns as f64) * 1e-9)));
    }

    /// The latest health, after the next one has come.
    pub fn health(&mut self) -> Health {
        self.run_s(1.1);
        let of = |event: &Event| {
            if let Event::Health(health) = event {
                Some(*health)
            } else {
                None
            }
        };
        self.events.iter().rev().find_map(of).expect("health")
    }

    /// Fails if a rule was broken, or a code is farther from the one before than the slew of the
    /// actuator.
    #[track_caller]
    pub fn assert_limits(&self, actuator: &Actuator) {
        assert!(
            self.emulator.findings().is_empty(),
            "{:#?}",
            self.emulator.findings()
        );
        let slew = (f64::from(actuator.slew_v_s) / 10_000.0 / f64::from(actuator.voltage_v)
            * 4095.0)
            .max(1.0) as u16;
        let codes: Vec<u16> = self
            .emulator
            .outputs()
            .iter()
            .filter_map(|output| output.code)
            .collect();
        let step = codes.windows(2).map(|pair| pair[0].abs_diff(pair[1])).max();
        assert!(step.is_some_and(|step| step <= slew), "{step:?} of {slew}");
    }

    /// What is put out from a time on, seconds since power-up: when its middle is, and volts.
    pub fn volts_from(&self, from_s: f64) -> Vec<(f64, f64)> {
        let volts = |output: &Output| {
            let t_s = output.at_ns as f64 * 1e-9 + 5e-5;
            (t_s > from_s).then(|| {
                (
                    t_s,
                    f64::from(output.code.expect("it is on")) / 4095.0 * VOLTS,
                )
            })
        };
        self.emulator.outputs().iter().filter_map(volts).collect()
    }

    pub fn now_s(&self) -> f64 {
        self.emulator.now_ns() as f64 * 1e-9
    }
}

/// Amplitude and phase, cycles, of volts against sin(2 pi x / period), and the greatest error over
/// the amplitude.
pub fn against(
    volts: &[(f64, f64)],
    place_mm: impl Fn(f64) -> f64,
    period_mm: f64,
    amplitude_v: f64,
) -> [f64; 3] {
    let (mut ss, mut sc, mut cc, mut ys, mut yc, mut worst) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0f64);
    for (t_s, volts) in volts {
        let y = volts - 0.5 * VOLTS;
        let (s, c) = (TAU * place_mm(*t_s) / period_mm).sin_cos();
        (ss, sc, cc) = (ss + s * s, sc + s * c, cc + c * c);
        (ys, yc) = (ys + y * s, yc + y * c);
        worst = worst.max((y - amplitude_v * s).abs() / amplitude_v);
    }
    let det = ss * cc - sc * sc;
    let (a, b) = ((ys * cc - yc * sc) / det, (yc * ss - ys * sc) / det);
    [a.hypot(b) / amplitude_v, b.atan2(a) / TAU, worst]
}

/// Equations 2 and 3 of Okamoto et al. in f64, volts.
pub fn amplitude_v(period_mm: f64) -> f64 {
    let x = period_mm;
    75.0 / 6000.0
        * (30770.0 * x.powi(4) - 162_663.0 * x.powi(3) + 309_743.0 * x * x - 248_938.0 * x
            + 72298.0)
}

pub const DEFAULT: Parameters = Parameters::DEFAULT;

/// The states that it has reported, one after the other.
pub fn states(stylus: &Stylus) -> Vec<State> {
    let of = |event: &Event| {
        if let Event::State(change) = event {
            Some(change.state)
        } else {
            None
        }
    };
    stylus.events.iter().filter_map(of).collect()
}
