//! A converter of another family behind the firmware's tasks: eight channels at once, a status word
//! and a CRC. SPI bytes in, telemetry out. Simulated chip and driver know nothing of each other.

mod driver;

use driver::WiredAds131m08;
use embedded_storage::nor_flash::NorFlash;
use hal_mock::ads131m08::{Ads131m08, Ads131m08Fault};
use hal_mock::{CutFlash, Repeated, Scene, Sliding, SlidingScene};
use heapless::spsc::{Consumer, Queue};
use ridgetone_finger::converter::Facts;
use ridgetone_finger::tasks::{
    Detect, Drdy, DrdyPin, Fit, Mail, Outbox, PACKETS, Platform, RequestInbox, Requests, SAMPLES,
    Shared, Task, WINDOWS, WatchdogPolicy,
};
use ridgetone_finger::{Acquisition, Detector, Estimator, Ring, Wiring};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::store::FlashStore;
use ridgetone_proto::telemetry::{
    ConverterState, Decoder, Event, Health, Span, Status, WIRE_MAX, encode,
};
use rtic_core::Exclusive;

const CLKIN_HZ: f64 = 8_192_000.0;
/// Time between two runs of `watch`, nanoseconds.
const WATCH_NS: u64 = 500_000_000;

/// A divider by four before each input: full scale of the chip is 1.2 V.
struct Divided<S>(S);

impl<S: Scene> Scene for Divided<S> {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        self.0.volts(input, t_s) / 4.0
    }

    fn end_s(&self) -> f64 {
        self.0.end_s()
    }
}

/// The input that a code of 780000h stands for, behind the divider.
const VREF_V: f32 = 4.0 * 1.2 * 0x78_0000 as f32 / 0x80_0000 as f32;

const WIRING: Wiring = Wiring {
    converter: &Facts::of::<WiredAds131m08<Ads131m08>>(),
};

struct Clock(Ads131m08);

impl Platform for Clock {
    /// The tasks run in turn.
    fn pend(_: &Shared<Self>, _: Task) {}

    fn now_us(&self) -> u32 {
        (self.0.now_ns() / 1000) as u32
    }
}

struct Pin {
    chip: Ads131m08,
    edge_us: u32,
    is_muted: bool,
}

impl DrdyPin for Pin {
    fn acknowledge(&mut self) -> Option<bool> {
        self.edge_us = (self.chip.now_ns() / 1000) as u32;
        (!self.is_muted && self.chip.drdy_is_low()).then_some(true)
    }

    fn edge_us(&self) -> u32 {
        self.edge_us
    }

    fn mute(&mut self) {
        self.is_muted = true;
    }

    fn unmute(&mut self) {
        self.is_muted = false;
    }
}

/// The firmware's tasks around the chip.
struct Board<'a, F: NorFlash> {
    chip: Ads131m08,
    shared: Shared<Clock>,
    drdy: Drdy<'a, WiredAds131m08<Ads131m08>, Pin>,
    detect: Detect<'a>,
    fit: Fit<'a, FlashStore<F>>,
    policy: WatchdogPolicy,
    watch_ns: u64,
    detector: Box<Detector>,
    ring: Box<Ring>,
    inbox: RequestInbox,
    outbox: Outbox<PACKETS>,
    decoder: Decoder,
    events: Vec<Event>,
}

/// A board before touches of the paper's protocol, and the tone of its grating, hertz.
fn board<'a>(osr: u16, is_absent: bool) -> (Board<'a, impl NorFlash>, f64) {
    let scene = SlidingScene::new(Sliding::default()).unwrap();
    let tone_hz = scene.truth().frequency_hz;
    let chip = Ads131m08::new(Divided(Repeated(scene)), CLKIN_HZ);
    chip.begin_fault(Ads131m08Fault::Absent(is_absent));
    let plan = driver::plan(osr, 0xff);
    let settings = Settings {
        vref_v: VREF_V,
        ..Settings::DEFAULT.with_plan(plan)
    };
    let (samples_in, samples) = Box::leak(Box::new(Queue::<_, SAMPLES>::new())).split();
    let (windows_in, windows): (_, Consumer<'_, _>) =
        Box::leak(Box::new(Queue::<_, WINDOWS>::new())).split();
    let converter = WiredAds131m08::new(chip.clone(), CLKIN_HZ as f32);
    let mut acquisition = Acquisition::new(converter, plan);
    let shared = Shared::new(Clock(chip.clone()), plan);
    let is_set_up = acquisition.set_up(&shared.diagnostics, &mut chip.clone());
    assert_eq!(is_set_up, !is_absent);
    let pin = Pin {
        chip: chip.clone(),
        edge_us: 0,
        is_muted: false,
    };
    let board = Board {
        shared,
        drdy: Drdy::new(acquisition, pin, samples_in),
        detect: Detect::new(samples, windows_in),
        fit: Fit {
            estimator: Box::leak(Box::new(Estimator::new(settings))),
            windows,
            requests: Requests::new(FlashStore::new(CutFlash::<4096>::new(1))),
        },
        policy: WatchdogPolicy::new(),
        watch_ns: WATCH_NS,
        detector: Box::new(Detector::wired(settings, WIRING)),
        ring: Box::new(Ring::new()),
        inbox: RequestInbox::new(),
        outbox: Outbox::new(),
        decoder: Decoder::default(),
        events: Vec::new(),
        chip,
    };
    (board, tone_hz)
}

impl<F: NorFlash> Board<'_, F> {
    fn run_until(&mut self, until_s: f64) {
        let until_ns = (until_s * 1e9) as u64;
        while self.chip.now_ns() < until_ns {
            let edge_ns = self.chip.next_drdy_fall_ns().unwrap_or(u64::MAX);
            let next_ns = edge_ns.min(self.watch_ns).min(until_ns);
            self.chip
                .advance_ns(next_ns.saturating_sub(self.chip.now_ns()));
            if next_ns == self.watch_ns {
                self.watch_ns += WATCH_NS;
                let _ = self.policy.run(&self.shared);
            }
            self.drdy.run(&self.shared, &mut self.chip.clone());
            self.run_tasks();
        }
    }

    fn run_tasks(&mut self) {
        let outbox = &mut self.outbox;
        self.detect
            .run(&mut self.detector, &mut self.ring, outbox, &self.shared);
        let mail = Mail {
            inbox: &mut Exclusive(&mut self.inbox),
            outbox: &mut Exclusive(&mut self.outbox),
        };
        let (ring, detector) = (
            &mut Exclusive(&mut self.ring),
            &mut Exclusive(&mut self.detector),
        );
        self.fit.run(ring, detector, mail, &self.shared);
        while let Some(packet) = self.outbox.take() {
            let mut bytes = [0; WIRE_MAX];
            let used = encode(&packet, &mut bytes).unwrap();
            for byte in &bytes[..used] {
                self.events
                    .extend(self.decoder.push(*byte).map(|packet| packet.event));
            }
        }
    }

    fn health(&self) -> Health {
        let is_health = |event: &Event| match event {
            Event::Health(health) => Some(*health),
            _ => None,
        };
        self.events
            .iter()
            .rev()
            .find_map(is_health)
            .expect("health once a second")
    }

    fn converter(&self) -> ConverterState {
        let is_state = |event: &Event| match event {
            Event::Converter(state) => Some(state.clone()),
            _ => None,
        };
        let states = self.events.iter().rev();
        states.clone().find_map(is_state).expect("it is reported")
    }

    fn faults(&self) -> Vec<FaultKind> {
        let is_fault = |event: &Event| match event {
            Event::Fault(fault) if fault.until_us.is_none() => Some(fault.kind),
            _ => None,
        };
        self.events.iter().filter_map(is_fault).collect()
    }
}

#[test]
fn its_samples_become_a_good_estimate() {
    // OSR 16,384 and 4096, bits 4 to 2 of CLOCK.
    for (osr, rate_hz, clock) in [(7, 250.0, 0x1e), (5, 1000.0, 0x16)] {
        let (mut board, tone_hz) = board(osr, false);
        board.run_until(4.9);
        // ID, STATUS, MODE, CLOCK as read back: all channels, the reset noted.
        let registers = [0x28, 0, 0x01, 0, 0x01, 0x10, 0xff, clock, 0, 0];
        let state = board.converter();
        assert_eq!((state.answers, state.registers), (true, registers));
        let slide = board.events.iter().find_map(|event| match event {
            Event::Estimate(estimate) if estimate.span == Span::Slide => Some(estimate),
            _ => None,
        });
        let slide = slide.expect("the slide is over");
        let off_hz = (f64::from(slide.frequency) - tone_hz).abs();
        assert!(
            off_hz < 4.0 * f64::from(slide.sigma),
            "{slide:?}, {tone_hz}"
        );
        assert_eq!((slide.status, slide.channels.len()), (Status::Good, 8));
        let health = board.health();
        assert_eq!(
            (health.conversions_lost, health.conversions_doubtful),
            (0, 0)
        );
        assert!(
            (health.frame_rate_hz / rate_hz - 1.0).abs() < 1e-5,
            "{health:?}"
        );
        assert_eq!(board.faults(), []);
    }
}

#[test]
fn a_damaged_crc_is_reported() {
    let (mut board, _) = board(5, false);
    board.run_until(1.0);
    // Read again, and right: nothing is lost.
    board.chip.begin_fault(Ads131m08Fault::Damaged(1));
    board.run_until(2.1);
    let health = board.health();
    assert_eq!(
        (
            health.faults[FaultKind::Bus as usize],
            health.conversions_lost
        ),
        (1, 0)
    );
    assert_eq!(board.faults(), [FaultKind::Bus]);
    // Three times in a row: the edge's eight samples are lost.
    board.chip.begin_fault(Ads131m08Fault::Damaged(3));
    board.run_until(3.1);
    let health = board.health();
    assert_eq!(
        (
            health.faults[FaultKind::Bus as usize],
            health.conversions_lost
        ),
        (2, 8)
    );
    assert_eq!((health.frames, health.chip_restarts), (3000, 0));
    // Ten edges that nobody serves: the latest sample is taken, though the chip keeps two.
    board.chip.advance_ns(10_000_000);
    board.run_until(4.1);
    let health = board.health();
    assert_eq!(
        (health.conversions_lost, health.chip_restarts),
        (8 + 80, 0),
        "{health:?}"
    );
}

#[test]
fn a_chip_that_is_not_there_is_named_within_a_second_and_found_later() {
    let (mut board, _) = board(5, true);
    board.run_until(1.0);
    assert_eq!(board.faults(), [FaultKind::NoAnswer]);
    let state = board.converter();
    assert_eq!((state.name.as_str(), state.answers), ("ADS131M08", false));
    assert!(state.t_us < 1_000_000);
    board.chip.begin_fault(Ads131m08Fault::Absent(false));
    board.run_until(7.0);
    assert!(board.converter().answers);
    let health = board.health();
    assert!(health.frames > 1000, "{health:?}");
    // Registers that changed are found twice a second.
    board.chip.begin_fault(Ads131m08Fault::BrownOut);
    board.run_until(8.6);
    assert!(board.faults().contains(&FaultKind::Registers));
    let again = board.health();
    assert!(again.frames > health.frames + 900, "{again:?}");
    assert!(again.chip_restarts > health.chip_restarts);
}
