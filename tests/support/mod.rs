//! What the whole-path tests share: a board that runs a scene through driver, pipeline and
//! telemetry.

use hal_mock::{Options, Scene, SimulatedBoard};
use ridgetone_finger::Pipeline;
use ridgetone_finger::TimedConversion;
use ridgetone_finger::converter::Ads1258Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Decoder, Estimate, Event, Packet, Status, WIRE_MAX, encode};

/// Runs `scene` through the simulated chip, byte by byte over SPI, the driver, the pipeline, and
/// the wire; `keep` may drop or change conversions on the way. Gives what a reader gets.
pub fn run(
    scene: impl Scene + 'static,
    settings: Settings,
    keep: impl FnMut(u32, TimedConversion) -> Option<TimedConversion>,
) -> Vec<Event> {
    run_on(SimulatedBoard::new(scene, chip(&settings)), settings, keep)
}

/// The chip with the clock that the settings say.
fn chip(settings: &Settings) -> Options {
    Options {
        clock_hz: settings.plan.adc_clock_hz,
        ..Options::default()
    }
}

/// Runs a board of the caller's.
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
        if let Some(kept) = keep(
            count,
            TimedConversion::new((edge_ns / 1000) as u32, conversion),
        ) {
            pipeline.push(kept, &mut |event| wire.send(event));
        }
        count += 1;
    }
    pipeline.finish(&mut |event| wire.send(event));
    assert_eq!((wire.decoder.damaged, wire.decoder.missing), (0, 0));
    wire.received
}

/// Everything is kept.
pub fn all(_: u32, conversion: TimedConversion) -> Option<TimedConversion> {
    Some(conversion)
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
        let used = encode(
            &Packet {
                sequence: self.sequence,
                event,
            },
            &mut bytes,
        )
        .unwrap();
        self.sequence = self.sequence.wrapping_add(1);
        for byte in &bytes[..used] {
            self.received
                .extend(self.decoder.push(*byte).map(|packet| packet.event));
        }
    }
}

/// Result of a run of one touch.
#[derive(Debug, Default)]
pub struct Outcome {
    /// Times of the contact spikes, seconds.
    pub contacts_s: Vec<f64>,
    /// Starts and ends of the slides, seconds.
    pub slides_s: Vec<(f64, f64)>,
    /// Releases, seconds.
    pub releases_s: Vec<f64>,
    /// Fits over whole slides.
    pub slide_fits: Vec<ridgetone_proto::telemetry::Estimate>,
    /// Fits over windows.
    pub window_fits: Vec<ridgetone_proto::telemetry::Estimate>,
    /// Static images.
    pub images: Vec<ridgetone_proto::telemetry::Image>,
    /// Textures.
    pub textures: Vec<ridgetone_proto::telemetry::Texture>,
    /// The last health message.
    pub health: ridgetone_proto::telemetry::Health,
}

/// Sorts the events of a run.
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
            Event::Estimate(fit) if fit.span == ridgetone_proto::telemetry::Span::Slide => {
                out.slide_fits.push(fit.clone())
            }
            Event::Estimate(fit) => out.window_fits.push(fit.clone()),
            Event::Health(health) => out.health = *health,
            Event::Image(image) => out.images.push(image.clone()),
            Event::Texture(texture) => out.textures.push(*texture),
            Event::Hello(_)
            | Event::Fault(_)
            | Event::Reply(_)
            | Event::Raw(_)
            | Event::Converter(_) => {}
        }
    }
    out
}

/// How many estimates are good.
#[derive(Debug, Default)]
pub struct Rate {
    estimates: usize,
    others: Vec<Estimate>,
}

impl Rate {
    /// Counts one more; each has a tone.
    #[track_caller]
    pub fn add(&mut self, estimate: &Estimate) {
        self.estimates += 1;
        if estimate.status != Status::Good {
            assert_eq!(estimate.status, Status::Ambiguous, "{estimate:?}");
            self.others.push(estimate.clone());
        }
    }

    /// Asserts that at most one of a hundred is not good; in a test of some size chance adds three
    /// standard deviations.
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
