//! Runs a board with its image, and decodes its reports.
#![allow(dead_code, reason = "each test program uses some of it")]

use ads1258::Conversion;
use hal_mock::{Constant, Scene, Sliding, SlidingScene};
use ridgetone_emulator::{Board, Emulator, Image, Start};
use ridgetone_finger::Pipeline;
use ridgetone_finger::TimedConversion;
use ridgetone_proto::command::{Command, Outcome, REQUEST_WIRE_MAX, Request};
use ridgetone_proto::fault::Fault;
use ridgetone_proto::framing;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{ConverterState, Decoder, Estimate, Event, Health, Hello};

pub const BOARDS: [Board; 2] = [Board::FeatherF405, Board::NucleoF446re];

pub struct Run {
    pub emulator: Emulator,
    decoder: Decoder,
    pub events: Vec<Event>,
}

pub fn image(board: Board) -> Image {
    Image::built(board).unwrap_or_else(|error| panic!("{error}"))
}

impl Run {
    /// Starts a board on a grating that slides at 30 mm/s, as in the demo.
    pub fn sliding(board: Board) -> Self {
        Self::new(
            board,
            SlidingScene::new(Sliding::default()).expect("the default scene"),
            Start::default(),
        )
    }

    /// Starts an untouched board, and waits until it has greeted and scans.
    pub fn at_rest(board: Board) -> Self {
        let mut run = Self::new(board, Constant::default(), Start::default());
        run.run_to(1.0, hello);
        run.run_s(0.2);
        run
    }

    pub fn new(board: Board, scene: impl Scene + 'static, start: Start) -> Self {
        let emulator = Emulator::new(board, &image(board), scene, start).expect("vectors");
        Self {
            emulator,
            decoder: Decoder::new(),
            events: Vec::new(),
        }
    }

    pub fn run_s(&mut self, s: f64) {
        let outcome = self.emulator.run_ns((s * 1e9) as u64);
        for byte in self.emulator.take_sent() {
            self.events
                .extend(self.decoder.push(byte).map(|packet| packet.event));
        }
        outcome.unwrap_or_else(|failure| panic!("{failure}"));
    }

    /// Runs until `find` accepts an event, but no longer than `limit_s` seconds.
    pub fn run_to<T>(&mut self, limit_s: f64, find: impl Fn(&Event) -> Option<T>) -> T {
        let end_ns = self.emulator.now_ns() + (limit_s * 1e9) as u64;
        let mut seen = self.events.len();
        while self.emulator.now_ns() < end_ns {
            self.run_s(0.001);
            if let Some(found) = self.events[seen..].iter().find_map(&find) {
                return found;
            }
            seen = self.events.len();
        }
        let late = &self.events[self.events.len().saturating_sub(4)..];
        panic!(
            "not reported within {limit_s} s: {late:?}, {:?}, {:?}",
            self.emulator.resets(),
            self.emulator.findings()
        );
    }

    pub fn missing(&self) -> u32 {
        self.decoder.missing
    }

    #[track_caller]
    pub fn assert_rules(&self) {
        assert!(
            self.emulator.findings().is_empty(),
            "{:#?}",
            self.emulator.findings()
        );
    }

    pub fn command(&mut self, number: u16, command: Command) -> Outcome {
        self.emulator.send(&request(number, command));
        self.run_to(5.0, reply_to(number))
    }
}

pub fn hello(event: &Event) -> Option<Hello> {
    if let Event::Hello(hello) = event {
        Some(hello.clone())
    } else {
        None
    }
}

/// Encodes a request for the line, preceded by a zero that ends earlier bytes.
pub fn request(number: u16, command: Command) -> Vec<u8> {
    let mut bytes = vec![0; REQUEST_WIRE_MAX + 1];
    let used = framing::encode(&Request { number, command }, &mut bytes[1..]).expect("it fits");
    bytes.truncate(used + 1);
    bytes
}

pub fn reply_to(number: u16) -> impl Fn(&Event) -> Option<Outcome> {
    move |event| match event {
        Event::Reply(reply) if reply.number == number => Some(reply.outcome.clone()),
        _ => None,
    }
}

pub fn converter(event: &Event) -> Option<ConverterState> {
    if let Event::Converter(state) = event {
        Some(state.clone())
    } else {
        None
    }
}

pub fn health(event: &Event) -> Option<Health> {
    if let Event::Health(health) = event {
        Some(*health)
    } else {
        None
    }
}

/// Runs the library on this PC with the conversions that the board read.
pub fn on_pc(run: &Run) -> Vec<Event> {
    let mut pipeline = Pipeline::new(Settings::DEFAULT);
    let mut events = Vec::new();
    for reading in run.emulator.readings() {
        let conversion = TimedConversion::new(reading.t_us, Conversion::from_bytes(reading.bytes));
        pipeline.push(conversion, &mut |event| events.push(event));
    }
    events
}

/// Selects contacts, slides, releases and images in order, then estimates in order, because the
/// time at which a fit ends varies.
pub fn touches_and_tones(events: &[Event]) -> Vec<Event> {
    let is_kept = |event: &&Event| {
        matches!(
            event,
            Event::Estimate(_)
                | Event::Contact(_)
                | Event::Moving(_)
                | Event::Slide(_)
                | Event::Release(_)
                | Event::Image(_)
        )
    };
    let mut kept: Vec<Event> = events.iter().filter(is_kept).cloned().collect();
    kept.sort_by_key(|event| matches!(event, Event::Estimate(_)));
    kept
}

pub fn estimate_of(event: &Event) -> Option<Estimate> {
    if let Event::Estimate(estimate) = event {
        Some(estimate.clone())
    } else {
        None
    }
}

pub fn estimates(events: &[Event]) -> Vec<Estimate> {
    events.iter().filter_map(estimate_of).collect()
}

pub fn fault_of(event: &Event) -> Option<Fault> {
    if let Event::Fault(fault) = event {
        Some(*fault)
    } else {
        None
    }
}
