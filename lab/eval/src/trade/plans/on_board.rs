//! Load and latency of a plan: the Feather's image on the register model, while the finger slides.

use super::accuracy::{TONES_HZ, scene};
use super::{Choice, OnBoard};
use crate::accuracy::rounded;
use crate::trade::units::CLOCK_HZ;
use anyhow::{Context, Result, anyhow, ensure};
use hal_mock::{Sliding, SlidingScene};
use ridgetone_emulator::{Board, Emulator, Image, Start};
use ridgetone_proto::command::{Command, Outcome, REQUEST_WIRE_MAX, Request};
use ridgetone_proto::framing;
use ridgetone_proto::telemetry::{Decoder, Event, Span};

/// Interrupt of the task `fit`, on both boards.
const FIT_IRQ: u16 = 76;

/// How long it is watched, seconds: some windows of each stride.
const WATCHED_S: f64 = 1.5;
/// From the slide's report to the first window that counts, beside the window itself, seconds: the
/// scan may begin late, and strides with it.
const SETTLED_S: f64 = 0.4;
/// Step of the time at which bytes are taken off the line, nanoseconds: a hundredth of a
/// millisecond.
const STEP_NS: u64 = 10_000;

/// The image that gets flashed.
pub fn image() -> Result<Image> {
    Ok(Image::built(Board::FeatherF405)?)
}

/// A request as it travels.
fn request(number: u16, command: Command) -> Result<Vec<u8>> {
    let mut wire = [0; REQUEST_WIRE_MAX];
    let length = framing::encode(&Request { number, command }, &mut wire)
        .map_err(|_| anyhow!("a request"))?;
    Ok(wire[..length].to_vec())
}

struct Run {
    emulator: Emulator,
    decoder: Decoder,
}

impl Run {
    /// Runs for `seconds` seconds; gives the events with the time of their last byte, nanoseconds
    /// since power-up.
    fn run_s(&mut self, seconds: f64) -> Result<Vec<(u64, Event)>> {
        let end_ns = self.emulator.now_ns() + (seconds * 1e9) as u64;
        let mut events = Vec::new();
        while self.emulator.now_ns() < end_ns {
            self.emulator.run_ns(STEP_NS)?;
            let now_ns = self.emulator.now_ns();
            for byte in self.emulator.take_sent() {
                events.extend(self.decoder.push(byte).map(|packet| (now_ns, packet.event)));
            }
        }
        Ok(events)
    }

    /// Runs until an event.
    fn run_to(&mut self, what: &str, limit_s: f64, is_it: impl Fn(&Event) -> bool) -> Result<()> {
        let end_ns = self.emulator.now_ns() + (limit_s * 1e9) as u64;
        while self.emulator.now_ns() < end_ns {
            if self.run_s(1e-3)?.iter().any(|(_, event)| is_it(event)) {
                return Ok(());
            }
        }
        anyhow::bail!("no {what} within {limit_s} s")
    }
}

/// Sets the choice by a request, waits for the slide, and watches.
pub fn measure(image: &Image, choice: Choice) -> Result<OnBoard> {
    let of = || format!("{:?}", choice.plan.name());
    let settings = choice.settings();
    let [.., tone_hz] = TONES_HZ;
    let slide_s = choice.window_s + SETTLED_S + WATCHED_S + 1.0;
    let scene = Sliding {
        hold_before_s: 1.0,
        ..scene(&choice.plan, tone_hz, slide_s, 1)
    };
    let emulator = Emulator::new(
        Board::FeatherF405,
        image,
        SlidingScene::new(scene)?,
        Start::default(),
    )?;
    let mut run = Run {
        emulator,
        decoder: Decoder::new(),
    };
    run.run_to("greeting", 1.0, |event| matches!(event, Event::Hello(_)))?;
    // The first reading is zero of the device's time, which goes on with another plan.
    let zero_ns = run
        .emulator
        .readings()
        .first()
        .context("no conversion is read")?
        .edge_ns;
    run.emulator.send(&request(
        1,
        Command::Set {
            settings,
            keep: false,
        },
    )?);
    run.run_to(
        "reply",
        0.4,
        |event| matches!(event, Event::Reply(reply) if reply.outcome == Outcome::Done),
    )
    .with_context(of)?;
    run.run_to("slide", 3.0, |event| matches!(event, Event::Slide(_)))
        .with_context(of)?;
    run.run_s(choice.window_s + SETTLED_S)?;

    let (before, lost_before) = (run.emulator.cycles(), run.emulator.adc().counters().lost);
    run.emulator.forget_served();
    let events = run.run_s(WATCHED_S)?;
    let (cycles, asleep) = (
        run.emulator.cycles().0 - before.0,
        run.emulator.cycles().1 - before.1,
    );
    let late_s: Vec<f64> = events
        .iter()
        .filter_map(|(at_ns, event)| match event {
            Event::Estimate(one) if one.span == Span::Window => {
                Some((at_ns - zero_ns) as f64 * 1e-9 - one.t_us as f64 * 1e-6)
            }
            _ => None,
        })
        .collect();
    // One stride may be cut by either end.
    let strides = (WATCHED_S / f64::from(settings.stride_s)) as usize;
    ensure!(
        late_s.len() + 1 >= strides,
        "{}: {} estimates in {strides} strides",
        of(),
        late_s.len()
    );
    ensure!(
        run.emulator.adc().counters().lost == lost_before,
        "{}: conversions are lost",
        of()
    );
    ensure!(
        run.emulator.findings().is_empty(),
        "{}: {:?}",
        of(),
        run.emulator.findings()
    );
    Ok(OnBoard {
        load: rounded((cycles - asleep) as f64 / cycles as f64),
        fit_s: rounded(run.emulator.served(FIT_IRQ).longest_run_cycles as f64 / CLOCK_HZ),
        late_s: rounded(
            late_s
                .iter()
                .fold(0.0, |most: f64, late_s| most.max(*late_s)),
        ),
    })
}
