//! A board that runs its image, and what it reports.
#![allow(dead_code, reason = "each test program uses some of it")]

use hal_mock::Scene;
use ridgetone_proto::command::{Command, Outcome, REQUEST_WIRE_MAX, Request};
use ridgetone_proto::framing;
use ridgetone_proto::telemetry::{Decoder, Event, Health, Hello};
use rig::{Board, Finding, Image, Rig, Rule, Start};
use std::path::Path;

pub const BOARDS: [Board; 2] = [Board::FeatherF405, Board::NucleoF446re];

/// Rules that the images of today break, by the parts of the issue that mend them.
pub const KNOWN: [Rule; 0] = [];

/// A rig with the receiver of its telemetry.
pub struct Run {
    pub rig: Rig,
    decoder: Decoder,
    pub events: Vec<Event>,
}

/// The image of a board, as `cargo xtask firmware` has built it.
pub fn image(board: Board) -> Image {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), |target| root.join(target));
    let path = target.join("firmware").join(board.name()).join("ridgetone-firmware.elf");
    Image::read(&path).unwrap_or_else(|error| panic!("{error}: build it with `cargo xtask firmware`"))
}

impl Run {
    pub fn new(board: Board, scene: impl Scene + 'static, start: Start) -> Self {
        let rig = Rig::new(board, &image(board), scene, start).expect("vectors");
        Self { rig, decoder: Decoder::new(), events: Vec::new() }
    }

    /// Runs for so many seconds of virtual time.
    pub fn run_s(&mut self, s: f64) {
        let outcome = self.rig.run_ns((s * 1e9) as u64);
        for byte in self.rig.take_sent() {
            self.events.extend(self.decoder.push(byte).map(|packet| packet.event));
        }
        outcome.unwrap_or_else(|failure| panic!("{failure}"));
    }

    /// Runs until the board has reported what is sought, at most `limit_s` seconds.
    pub fn run_to<T>(&mut self, limit_s: f64, sought: impl Fn(&Event) -> Option<T>) -> T {
        let end_ns = self.rig.now_ns() + (limit_s * 1e9) as u64;
        let mut seen = self.events.len();
        while self.rig.now_ns() < end_ns {
            self.run_s(0.001);
            if let Some(found) = self.events[seen..].iter().find_map(&sought) {
                return found;
            }
            seen = self.events.len();
        }
        panic!("not reported within {limit_s} s: {:?}, {:?}", self.events, self.rig.findings());
    }

    /// Fails if a rule was broken that is not known to be.
    pub fn assert_rules(&self) {
        let unknown: Vec<&Finding> = self.rig.findings().iter().filter(|one| !KNOWN.contains(&one.rule)).collect();
        assert!(unknown.is_empty(), "{unknown:#?}");
    }
}

/// The greeting.
pub fn hello(event: &Event) -> Option<Hello> {
    if let Event::Hello(hello) = event { Some(hello.clone()) } else { None }
}

/// A request as it travels, behind a zero that ends what was on the line before.
pub fn request(number: u16, command: Command) -> Vec<u8> {
    let mut bytes = vec![0; REQUEST_WIRE_MAX + 1];
    let used = framing::encode(&Request { number, command }, &mut bytes[1..]).expect("it fits");
    bytes.truncate(used + 1);
    bytes
}

/// The reply to a request.
pub fn reply_to(number: u16) -> impl Fn(&Event) -> Option<Outcome> {
    move |event| match event {
        Event::Reply(reply) if reply.number == number => Some(reply.outcome.clone()),
        _ => None,
    }
}

/// The latest health.
pub fn health(event: &Event) -> Option<Health> {
    if let Event::Health(health) = event { Some(*health) } else { None }
}
