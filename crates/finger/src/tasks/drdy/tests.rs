use super::*;
use crate::converter::WiredAds1258;
use ads1258::Ads1258;
use core::sync::atomic::AtomicBool;
use hal_mock::{Constant, Fault, Options, SimulatedBoard};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::plan::Plan;

/// DRDY's pin, and the board time of the next edge that is not acknowledged yet, nanoseconds.
struct Pin {
    board: SimulatedBoard,
    ahead_ns: Option<u64>,
    edge_us: u32,
}

impl DrdyPin for Pin {
    fn acknowledge(&mut self) -> Option<bool> {
        let now_ns = self.board.now_ns();
        self.edge_us = (now_ns / 1000) as u32;
        let has_fallen = self.ahead_ns.is_some_and(|ahead_ns| ahead_ns <= now_ns);
        self.ahead_ns = self.board.with_chip(|chip| chip.next_drdy_fall_ns());
        has_fallen.then(|| self.board.with_chip(|chip| !chip.drdy_high(0)))
    }

    fn edge_us(&self) -> u32 {
        self.edge_us
    }

    fn mute(&mut self) {}

    fn unmute(&mut self) {
        self.ahead_ns = self.board.with_chip(|chip| chip.next_drdy_fall_ns());
    }
}

const SCLK_HZ: u32 = 5_250_000;

struct Clock(SimulatedBoard);

impl Platform for Clock {
    fn pend(_: &Shared<Self>, _: Task) {}

    fn now_us(&self) -> u32 {
        (self.0.now_ns() / 1000) as u32
    }
}

fn simulated() -> SimulatedBoard {
    let scene = Constant {
        end_s: f64::INFINITY,
        ..Constant::default()
    };
    let board = SimulatedBoard::new(scene, Options::default());
    board.set_sclk_hz(SCLK_HZ);
    board
}

/// Sets the chip up for a plan.
fn set_up<'a>(
    board: &SimulatedBoard,
    plan: Plan,
    samples: &'a SampleQueue,
) -> (
    Drdy<'a, impl Converter + use<>, Pin>,
    Shared<Clock>,
    impl DelayNs + use<>,
) {
    let pins = (board.start_pin(), board.reset_pin());
    let converter = WiredAds1258::new(Ads1258::new(board.spi()), pins.0, pins.1);
    let mut acquisition = Acquisition::new(converter, plan);
    let shared = Shared::new(Clock(board.clone()), plan);
    let mut wait = board.delay();
    assert!(acquisition.set_up(&shared.diagnostics, &mut wait));
    let pin = Pin {
        board: board.clone(),
        ahead_ns: None,
        edge_us: 0,
    };
    let mut drdy = Drdy::new(acquisition, pin, samples);
    drdy.pin.unmute();
    (drdy, shared, wait)
}

/// A check that nothing makes urgent waits for the next conversion, also if an earlier one was
/// urgent, and is made once: with the default plan the health readings need no other scan.
#[test]
fn a_check_that_can_wait_follows_a_conversion() {
    let board = &simulated();
    let samples: &SampleQueue = &SampleQueue::<[_; 88]>::new();
    let (mut drdy, shared, mut wait) = set_up(board, Plan::PAPER, samples);
    let requests: [(&str, &[&AtomicBool]); 4] = [
        ("nothing", &[]),
        ("a check", &[&shared.check]),
        ("an urgent check", &[&shared.check, &shared.urgent]),
        ("health readings", &[&shared.health]),
    ];
    let bytes_since =
        |from_ns| (board.now_ns() - from_ns + 500) * u64::from(SCLK_HZ) / 8_000_000_000;
    // Bytes on the bus after an edge, and without one: the registers are read by a command and nine
    // bytes.
    let edge_bytes = [10, 20, 20, 10];
    for ((name, flags), expected) in requests.into_iter().zip(edge_bytes) {
        for _ in 0..30 {
            let ahead_ns = drdy.pin.ahead_ns.expect("the chip scans");
            board.advance_ns(ahead_ns.saturating_sub(board.now_ns()));
            flags.iter().for_each(|flag| flag.store(true, Relaxed));
            let before_ns = board.now_ns();
            drdy.run(&shared, &mut wait);
            assert_eq!(bytes_since(before_ns), expected, "after an edge, {name}");
            // Between two edges.
            shared.check.store(true, Relaxed);
            drdy.run(&shared, &mut wait);
            assert_eq!(bytes_since(before_ns), expected, "without an edge, {name}");
            shared.check.store(false, Relaxed);
            while samples.dequeue().is_some() {}
        }
    }
}

/// Tests conversions that end while the chip is checked: because noise caused an edge shortly
/// before, or because an estimate waits for the check.
#[test]
fn a_conversion_that_ends_during_a_check_is_read() {
    for is_urgent in [false, true] {
        check_before_edges(is_urgent);
    }
}

fn check_before_edges(is_urgent: bool) {
    let board = &simulated();
    let samples: &SampleQueue = &SampleQueue::<[_; 88]>::new();
    let (mut drdy, shared, mut wait) = set_up(board, Plan::SINGLE, samples);
    let lost = || board.with_chip(|chip| chip.counters().lost);
    let (mut before, mut edges) = (0, 0);
    for run in 0..1000 {
        if drdy
            .pin
            .ahead_ns
            .is_none_or(|ahead_ns| ahead_ns > board.now_ns())
        {
            // An edge of noise may have come before.
            drdy.pin.unmute();
        }
        let ahead_ns = drdy.pin.ahead_ns.expect("the chip scans");
        board.advance_ns(ahead_ns.saturating_sub(board.now_ns()));
        drdy.run(&shared, &mut wait);
        while samples.dequeue().is_some() {}
        match run {
            // The health readings are over by this run.
            100 => before = lost(),
            _ if run > 100 && run % 10 == 0 && is_urgent => {
                drdy.pin.unmute();
                let ahead_ns = drdy.pin.ahead_ns.expect("the chip scans");
                // A conversion takes 42.9 us, a check 15.
                board.advance_ns(ahead_ns.saturating_sub(board.now_ns() + 8_000));
                shared.check.store(true, Relaxed);
                shared.urgent.store(true, Relaxed);
                drdy.run(&shared, &mut wait);
                assert!(!shared.check.load(Relaxed), "the check is not done");
                while samples.dequeue().is_some() {}
            }
            _ if run > 100 && run % 10 == 0 => {
                // A conversion takes 42.9 us, a check 15.
                board.with_chip(|chip| chip.begin_fault(Fault::EdgeRepeated { after_ns: 25_000 }));
                edges += 1;
            }
            _ => {}
        }
    }
    assert_eq!(lost(), before, "by the chip's own count");
    assert!(
        is_urgent || shared.diagnostics.faults.count(FaultKind::Repeated) > edges / 2,
        "{edges}"
    );
}
