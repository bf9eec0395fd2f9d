//! Code shared by the whole-path tests: a board that runs a scene through driver, pipeline and
//! telemetry.

use hal_mock::{Options, Scene, SimulatedBoard, Truth};
use ridgetone_finger::converter::Ads1258Plan;
use ridgetone_finger::{Pipeline, TimedConversion};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{
    Decoder, Estimate, Event, Health, Image, Packet, Span, Status, Texture, WIRE_MAX, encode,
};

/// Runs `scene` through the simulated chip, byte by byte over SPI, then through driver, pipeline
/// and telemetry line; `keep` may drop or modify conversions. Returns the decoded events.
pub fn run(
    scene: impl Scene + 'static,
    settings: Settings,
    keep: impl FnMut(u32, TimedConversion) -> Option<TimedConversion>,
) -> Vec<Event> {
    run_on(SimulatedBoard::new(scene, chip(&settings)), settings, keep)
}

fn chip(settings: &Settings) -> Options {
    Options {
        clock_hz: settings.plan.adc_clock_hz,
        ..Options::default()
    }
}

pub fn run_on(
    board: SimulatedBoard,
    settings: Settings,
    mut keep: impl FnMut(u32, TimedConversion) -> Option<TimedConversion>,
) -> Vec<Event> {
    let mut adc = ads1258::Ads1258::new(board.spi());
    let mut start = board.start_pin();
    adc.stop(&mut start).unwrap();
    adc.configure(&Ads1258Plan::of(&settings.plan).config())
        .unwrap();
    adc.start(&mut start).unwrap();

    let mut pipeline = Box::new(Pipeline::new(settings));
    let mut wire = Wire::default();
    wire.send(pipeline.hello());
    let mut count = 0;
    while let Some(edge_ns) = board.wait_for_drdy() {
        let conversion = adc.read().unwrap();
        if board.with_chip(|chip| chip.ended()) {
            break;
        }
        let timed = TimedConversion::new((edge_ns / 1000) as u32, conversion);
        if let Some(kept) = keep(count, timed) {
            pipeline.push(kept, &mut |event| wire.send(event));
        }
        count += 1;
    }
    pipeline.finish(&mut |event| wire.send(event));
    assert_eq!((wire.decoder.damaged, wire.decoder.missing), (0, 0));
    wire.received
}

pub fn all(_: u32, conversion: TimedConversion) -> Option<TimedConversion> {
    Some(conversion)
}

/// A finger without contact, with a little noise.
pub fn in_the_air(end_s: f64) -> impl Scene {
    let volts = [2.5; 16];
    hal_mock::Noisy::new(hal_mock::Constant { volts, end_s }, 20e-6, 5)
}

pub fn count(events: &[Event], is_it: fn(&Event) -> bool) -> usize {
    events.iter().filter(|event| is_it(event)).count()
}

#[derive(Default)]
struct Wire {
    sequence: u16,
    decoder: Decoder,
    received: Vec<Event>,
}

impl Wire {
    fn send(&mut self, event: Event) {
        let mut bytes = [0; WIRE_MAX];
        let sequence = self.sequence;
        let used = encode(&Packet { sequence, event }, &mut bytes).unwrap();
        self.sequence = self.sequence.wrapping_add(1);
        for byte in &bytes[..used] {
            self.received
                .extend(self.decoder.push(*byte).map(|packet| packet.event));
        }
    }
}

#[derive(Debug, Default)]
pub struct Outcome {
    /// Times of the contact spikes, seconds.
    pub contacts_s: Vec<f64>,
    pub slides_s: Vec<(f64, f64)>,
    pub releases_s: Vec<f64>,
    pub slide_fits: Vec<Estimate>,
    pub window_fits: Vec<Estimate>,
    pub images: Vec<Image>,
    pub textures: Vec<Texture>,
    /// The last health message.
    pub health: Health,
}

impl Outcome {
    #[track_caller]
    pub fn assert_one_slide(&self, what: &str) {
        let touch = (
            self.contacts_s.len(),
            self.slides_s.len(),
            self.releases_s.len(),
        );
        assert_eq!(touch, (1, 1, 1), "{what}: {self:?}");
    }

    /// Asserts one touch with one slide at the scene's times: the contact within 10 ms, the slide
    /// within `slide_s`.
    #[track_caller]
    pub fn assert_touch(&self, what: &str, truth: &Truth, slide_s: f64) {
        self.assert_slide(what, truth, slide_s);
        let off_s = self.contacts_s[0] - truth.contact_s;
        assert!(
            off_s.abs() < 0.010,
            "{what}: contact off by {off_s} s: {self:?} {truth:?}"
        );
    }

    /// Like [`Self::assert_touch`], but the contact may be reported at any time.
    #[track_caller]
    pub fn assert_slide(&self, what: &str, truth: &Truth, within_s: f64) {
        self.assert_one_slide(what);
        let (start_s, end_s) = self.slides_s[0];
        for (moment, off_s) in [
            ("start", start_s - truth.slide_start_s),
            ("end", end_s - truth.slide_end_s),
        ] {
            assert!(
                off_s.abs() < within_s,
                "{what}: {moment} off by {off_s} s: {self:?} {truth:?}"
            );
        }
    }

    pub fn fits(&self) -> impl Iterator<Item = &Estimate> {
        self.window_fits.iter().chain(&self.slide_fits)
    }
}

/// Error of an estimate's frequency, in its own standard deviations.
pub fn off(fit: &Estimate, truth: &Truth) -> f64 {
    (f64::from(fit.frequency) - truth.frequency_hz) / f64::from(fit.sigma)
}

pub fn outcome(events: &[Event]) -> Outcome {
    let mut out = Outcome::default();
    let seconds = |us: u64| us as f64 * 1e-6;
    for event in events {
        match event {
            Event::Contact(contact) => out.contacts_s.push(seconds(contact.t_us)),
            Event::Slide(slide) => {
                out.slides_s.extend(
                    slide
                        .end_us
                        .map(|end| (seconds(slide.start_us), seconds(end))),
                );
            }
            Event::Release(release) => out.releases_s.push(seconds(release.t_us)),
            Event::Estimate(fit) if fit.span == Span::Slide => out.slide_fits.push(fit.clone()),
            Event::Estimate(fit) => out.window_fits.push(fit.clone()),
            Event::Health(health) => out.health = *health,
            Event::Image(image) => out.images.push(image.clone()),
            Event::Texture(texture) => out.textures.push(*texture),
            Event::Hello(_)
            | Event::Fault(_)
            | Event::Reply(_)
            | Event::Raw(_)
            | Event::Converter(_)
            | Event::Track(_)
            | Event::Moving(_) => {}
        }
    }
    out
}

/// Number of all estimates, and the estimates that are not good.
#[derive(Debug, Default)]
pub struct Rate {
    estimates: usize,
    others: Vec<Estimate>,
}

impl Rate {
    /// Counts one estimate, which must have a tone.
    #[track_caller]
    pub fn add(&mut self, estimate: &Estimate) {
        self.estimates += 1;
        if estimate.status != Status::Good {
            assert_eq!(estimate.status, Status::Ambiguous, "{estimate:?}");
            self.others.push(estimate.clone());
        }
    }

    /// Asserts that at most 1 % of the estimates are not good, plus three standard deviations for
    /// chance.
    #[track_caller]
    pub fn assert_good(&self) {
        let (count, expected) = (self.others.len(), self.estimates as f64 / 100.0);
        assert!(
            count as f64 <= expected + 3.0 * expected.sqrt(),
            "{count} of {}: {:?}",
            self.estimates,
            self.others
        );
    }
}
