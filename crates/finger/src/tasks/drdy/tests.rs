use super::*;
use crate::converter::WiredAds1258;
use ads1258::Ads1258;
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

struct Clock(SimulatedBoard);

impl Platform for Clock {
    fn pend(_: &Shared<Self>, _: Task) {}

    fn now_us(&self) -> u32 {
        (self.0.now_ns() / 1000) as u32
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
    let board = SimulatedBoard::new(
        Constant {
            end_s: f64::INFINITY,
            ..Constant::default()
        },
        Options::default(),
    );
    board.set_sclk_hz(5_250_000);
    let samples: &SampleQueue = &SampleQueue::<[_; 88]>::new();
    let pins = (board.start_pin(), board.reset_pin());
    let converter = WiredAds1258::new(Ads1258::new(board.spi()), pins.0, pins.1);
    let mut acquisition = Acquisition::new(converter, Plan::SINGLE);
    let shared = Shared::new(Clock(board.clone()), Plan::SINGLE);
    let mut wait = board.delay();
    assert!(acquisition.set_up(&shared.diagnostics, &mut wait));
    let mut drdy = Drdy::new(
        acquisition,
        Pin {
            board: board.clone(),
            ahead_ns: None,
            edge_us: 0,
        },
        samples,
    );
    drdy.pin.unmute();
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
