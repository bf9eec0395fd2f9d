//! Tests against the simulated chip, over a bus that can fail.

use super::watch::PUT_OFF_MAX;
use super::*;
use crate::converter::{Ads1258Plan, SCAN, WiredAds1258};
use FaultKind::{Bus, BusDead, NoAnswer, Registers, Repeated, Silent, Storm};
use ads1258::Ads1258;
use core::convert::Infallible;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use hal_mock::board::{ChipSpi, ResetPin, StartPin};
use hal_mock::{Constant, Fault, Options, SimulatedBoard};
extern crate std;
use std::boxed::Box;
use std::cell::RefCell;
use std::rc::Rc;
use std::vec::Vec;

/// Registers of the chip (SBAS297G): CONFIG1 and MUXSG0.
const CONFIG1: u8 = 1;
const MUXSG0: u8 = 4;

/// A bus that may be stuck, and on which time may pass before each transaction.
struct Wire {
    spi: ChipSpi,
    board: SimulatedBoard,
    trouble: Rc<RefCell<Trouble>>,
}

#[derive(Default)]
struct Trouble {
    /// Delays before the next transactions, nanoseconds.
    waits_ns: Vec<u64>,
    stuck: Option<u8>,
}

impl ErrorType for Wire {
    type Error = Infallible;
}

impl SpiDevice for Wire {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let mut trouble = self.trouble.borrow_mut();
        if !trouble.waits_ns.is_empty() {
            self.board.advance_ns(trouble.waits_ns.remove(0));
        }
        self.spi.transaction(operations)?;
        if let (Some(stuck), [Operation::TransferInPlace(bytes)]) = (trouble.stuck, operations) {
            bytes.fill(stuck);
        }
        Ok(())
    }
}

struct Bench {
    board: SimulatedBoard,
    trouble: Rc<RefCell<Trouble>>,
    acquisition: Acquisition<WiredAds1258<Wire, StartPin, ResetPin>>,
    queue: Box<SampleQueue>,
    diagnostics: Diagnostics,
}

impl Bench {
    fn new() -> Self {
        Self::with(Plan::PAPER)
    }

    fn with(plan: Plan) -> Self {
        // Noise makes all codes differ.
        let board = SimulatedBoard::new(
            Constant {
                end_s: f64::INFINITY,
                ..Constant::default()
            },
            Options::default(),
        );
        let trouble = Rc::<RefCell<Trouble>>::default();
        let wire = Wire {
            spi: board.spi(),
            board: board.clone(),
            trouble: trouble.clone(),
        };
        let (start, reset) = (board.start_pin(), board.reset_pin());
        let converter = WiredAds1258::new(Ads1258::new(wire), start, reset);
        let mut acquisition = Acquisition::new(converter, plan);
        let diagnostics = Diagnostics::new();
        assert!(acquisition.set_up(&diagnostics, &mut board.delay()));
        Self {
            board,
            trouble,
            acquisition,
            queue: Box::new(SampleQueue::<[_; 64]>::new()),
            diagnostics,
        }
    }

    fn now_us(&self) -> u32 {
        (self.board.now_ns() / 1000) as u32
    }

    /// Serves the interrupt of an edge, now.
    fn serve(&mut self) -> Drdy {
        let t_us = self.now_us();
        self.acquisition
            .edge(|| t_us, &self.queue, &self.diagnostics)
    }

    /// Serves the next conversion at its edge.
    fn next(&mut self) -> Drdy {
        self.board.wait_for_drdy().expect("a conversion");
        self.serve()
    }

    /// Serves the next conversion and does what it requests, as `tasks::drdy` does.
    fn follow(&mut self) -> Drdy {
        let drdy = self.next();
        if drdy == Drdy::HealthRead {
            self.acquisition
                .read_inputs(&self.diagnostics, &mut self.board.delay());
        }
        drdy
    }

    fn read_health(&mut self) -> bool {
        self.acquisition
            .read_health(&self.diagnostics, &mut self.board.delay())
    }

    fn change(&mut self, plan: Plan) {
        let now_us = self.now_us();
        self.acquisition
            .change(plan, now_us, &self.diagnostics, &mut self.board.delay());
    }

    /// Serves an unexpected edge.
    fn nothing(&mut self) -> Drdy {
        let now_us = self.now_us();
        self.acquisition.nothing(now_us, &self.diagnostics)
    }

    /// Number of unexpected edges until DRDY is muted.
    fn storm(&mut self) -> Option<u16> {
        (1..).find(|_| self.nothing() == Drdy::Mute)
    }

    fn can_begin(&mut self) -> bool {
        let now_us = self.now_us();
        self.acquisition.can_begin(now_us)
    }

    /// Serves six conversions. Returns true for each after which a different scan could begin.
    fn can_begin_six_times(&mut self) -> [bool; 6] {
        [(); 6].map(|()| {
            assert!(self.next().goes_on());
            self.can_begin()
        })
    }

    fn begin(&self, fault: Fault) {
        self.board.with_chip(|chip| chip.begin_fault(fault));
    }

    fn flip_dout(&self, bytes_ahead: u64, mask: u8) {
        self.begin(Fault::DoutFlip { bytes_ahead, mask });
    }

    fn flip_register(&self, address: u8, mask: u8) {
        self.begin(Fault::RegisterFlip { address, mask });
    }

    fn registers(&self) -> [u8; 9] {
        self.board
            .with_chip(|chip| *chip.registers().first_chunk().expect("ten registers"))
    }

    fn restarts(&self) -> u32 {
        self.diagnostics.chip_restarts.get()
    }

    fn overruns(&self) -> u32 {
        self.diagnostics.queue_overruns.get()
    }

    /// Asserts that the scan begins with its first channel.
    #[track_caller]
    fn assert_begins_anew(&mut self) {
        assert_eq!((self.next(), self.ids()), (Drdy::Midway, std::vec![8]));
    }

    /// Serves conversions and ignores the results.
    fn pass(&mut self, conversions: u32) {
        for _ in 0..conversions {
            let _ = self.next();
        }
    }

    fn watch(&mut self) -> bool {
        let now_us = self.now_us();
        self.acquisition
            .watch(now_us, &self.diagnostics, &mut self.board.delay())
    }

    fn ids(&mut self) -> Vec<u8> {
        self.taken()
            .iter()
            .map(|timed| timed.status().chid())
            .collect()
    }

    fn taken(&mut self) -> Vec<TimedConversion> {
        core::iter::from_fn(|| self.queue.dequeue()).collect()
    }

    fn count(&self, kind: FaultKind) -> u32 {
        self.diagnostics.faults.count(kind)
    }

    fn faults(&self) -> u32 {
        self.diagnostics.faults.counts().iter().sum()
    }

    /// Numbers of conversions read and lost, by the simulated chip's count.
    fn read_and_lost(&self) -> (u64, u64) {
        self.board
            .with_chip(|chip| (chip.counters().read, chip.counters().lost))
    }
}

impl Drdy {
    fn goes_on(self) -> bool {
        matches!(self, Self::Listen | Self::Midway)
    }
}

#[test]
fn every_conversion_is_read_twice_and_queued_once() {
    let mut bench = Bench::new();
    for n in 1..=50 {
        // The detector runs when a scan is over.
        let expected = if n % 21 == 0 {
            Drdy::Listen
        } else {
            Drdy::Midway
        };
        assert_eq!(bench.next(), expected, "{n}");
    }
    // Ids of a scan (SBAS297G: ascending CHID; 19h is unused); 50 are more than two scans.
    let scan = [
        8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 26, 27, 28, 29,
    ];
    assert!(bench.ids().iter().eq(scan.iter().cycle().take(50)));
    assert_eq!((bench.faults(), bench.read_and_lost()), (0, (50, 0)));
}

#[test]
fn a_bit_that_falls_over_is_mended_wherever_it_is() {
    // Two reads of five bytes; the byte during the command has no meaning.
    for byte in (0..10).filter(|byte| byte % 5 != 0) {
        for bit in 0..8 {
            let (mut plain, mut bench) = (Bench::new(), Bench::new());
            for n in 0..30 {
                plain.pass(1);
                if n == 7 {
                    bench.flip_dout(byte, 1 << bit);
                }
                assert_eq!(
                    bench.next() == Drdy::Watch,
                    n == 7,
                    "byte {byte}, bit {bit}"
                );
            }
            assert_eq!(bench.taken(), plain.taken(), "byte {byte}, bit {bit}");
            assert_eq!(
                (bench.count(Bus), bench.faults()),
                (1, 1),
                "byte {byte}, bit {bit}"
            );
        }
    }
}

#[test]
fn what_no_two_reads_agree_on_is_dropped_and_counted() {
    let mut bench = Bench::new();
    for byte in [2, 8, 14] {
        bench.flip_dout(byte, 1 << (byte / 5));
    }
    assert_eq!(
        [bench.next(), bench.next(), bench.next()],
        [Drdy::Watch, Drdy::Midway, Drdy::Midway]
    );
    assert_eq!(bench.ids(), [9, 10]);
    assert_eq!(
        (bench.count(Bus), bench.faults(), bench.overruns()),
        (1, 1, 1)
    );
}

#[test]
fn a_conversion_that_ends_between_two_reads_is_taken_once_and_none_is_lost_in_silence() {
    let period_ns = 197_474;
    for late_ns in [period_ns - 1, period_ns - 1000, 1000] {
        let mut bench = Bench::new();
        bench.pass(1);
        bench.board.wait_for_drdy();
        // Let the board be late: the next edge comes between the first read and the second or, the
        // last time, after both.
        bench.trouble.borrow_mut().waits_ns = std::vec![late_ns, 2000];
        assert!(bench.serve().goes_on());
        let between = late_ns > period_ns - 2000;
        if between {
            // The interrupt of the second conversion is pending and finds nothing new, with DRDY
            // low or high again.
            assert_eq!(bench.serve(), Drdy::Listen);
        }
        assert!((0..5).all(|_| bench.next().goes_on()));
        let ids = bench.ids();
        assert_eq!(
            ids,
            if between {
                &[8, 10, 11, 12, 13, 14, 15][..]
            } else {
                &[8, 9, 10, 11, 12, 13, 14]
            }
        );
        assert_eq!((bench.faults(), bench.overruns()), (0, between as u32));
        assert_eq!(bench.read_and_lost().0, ids.len() as u64 + between as u64);
    }
}

#[test]
fn what_does_not_fit_the_queue_is_counted() {
    let mut bench = Bench::new();
    assert!((0..70).all(|_| bench.next().goes_on()));
    assert_eq!((bench.taken().len(), bench.overruns()), (63, 7));
}

#[test]
fn an_edge_without_a_conversion_is_counted_and_gives_none() {
    let mut bench = Bench::new();
    bench.pass(1);
    bench.board.advance_ns(50_000);
    assert_eq!(bench.serve(), Drdy::Watch);
    assert_eq!(bench.nothing(), Drdy::Listen);
    assert_eq!((bench.count(Repeated), bench.faults()), (2, 2));
    bench.watch();
    assert_eq!((bench.next(), bench.ids()), (Drdy::Midway, std::vec![8, 9]));
}

#[test]
fn a_storm_is_muted_until_the_next_watch() {
    let mut bench = Bench::new();
    bench.pass(1);
    assert_eq!(bench.storm(), Some(STORM_EDGES));
    assert!(bench.acquisition.is_quiet(bench.now_us()) && bench.count(Storm) == 1);
    // A muted chip never counts as silent, because no conversion could come.
    bench.board.advance_ns(500_000_000);
    bench.watch();
    assert!(bench.next().goes_on() || bench.next().goes_on());
    assert_eq!((bench.count(Silent), bench.restarts()), (0, 0));
}

#[test]
fn registers_that_change_are_written_anew_and_the_scan_begins_at_its_top() {
    let mut bench = Bench::new();
    bench.pass(5);
    bench.flip_register(CONFIG1, 0x02);
    bench.watch();
    assert_eq!(
        (bench.count(Registers), bench.faults(), bench.restarts()),
        (1, 1, 1)
    );
    assert_eq!(bench.registers(), SCAN.registers().unwrap());
    bench.ids();
    bench.assert_begins_anew();
}

#[test]
fn one_wrong_look_at_the_registers_is_no_reason_to_restart() {
    let mut bench = Bench::new();
    bench.pass(1);
    bench.flip_dout(3, 0x10);
    bench.watch();
    assert_eq!((bench.faults(), bench.restarts()), (0, 0));
}

#[test]
fn a_chip_that_resets_itself_is_noticed_by_its_ids_within_one_scan() {
    let mut bench = Bench::new();
    bench.pass(30);
    let now_ns = bench.board.now_ns();
    bench.board.with_chip(|chip| {
        chip.set_reset(now_ns, false);
        chip.set_reset(now_ns, true);
    });
    bench.ids();
    let noticed = (1..40).find(|_| bench.next() == Drdy::Watch);
    // The reset scan begins at AIN0, which does not follow the 30th conversion.
    assert_eq!(noticed, Some(1));
    bench.watch();
    bench.ids();
    assert!((0..21).all(|_| bench.next().goes_on()));
    assert_eq!((bench.count(Registers), bench.restarts()), (1, 1));
}

#[test]
fn a_silent_chip_is_restarted_again_and_again_with_pauses_that_grow() {
    let mut bench = Bench::new();
    bench.pass(1);
    bench.begin(Fault::Stall);
    let mut restarts_ms = Vec::new();
    for half in 1..=60 {
        bench.board.advance_ns(500_000_000);
        bench.watch();
        if bench.restarts() as usize > restarts_ms.len() {
            restarts_ms.push(half * 500);
        }
    }
    // The first restart is immediate; others come at the first half-second check after pauses of
    // 125 ms, 250 ms, ... 4 s.
    assert_eq!(
        restarts_ms,
        [
            500, 1000, 1500, 2000, 3000, 5000, 9000, 13000, 17000, 21000, 25000, 29000
        ]
    );
    assert_eq!((bench.count(Silent), bench.faults()), (60, 60));
    bench.board.with_chip(|chip| chip.end_fault(Fault::Stall));
    // The chip continues by itself as soon as it can; a second later a new fault is mended at once.
    for _ in 0..5 * 5064 {
        bench.pass(1);
        bench.ids();
    }
    bench.watch();
    bench.flip_register(MUXSG0, 0x01);
    bench.watch();
    assert_eq!((bench.count(Registers), bench.restarts()), (1, 13));
}

#[test]
fn a_dead_bus_gives_no_conversion_and_is_tried_again_until_it_lives() {
    for stuck in [0x00, 0xff] {
        let mut bench = Bench::new();
        bench.pass(3);
        bench.trouble.borrow_mut().stuck = Some(stuck);
        assert_eq!(bench.next(), Drdy::Watch);
        bench.watch();
        // A converter that cannot be set up must not be started.
        assert_eq!(
            bench.board.wait_for_drdy().and(bench.board.wait_for_drdy()),
            None
        );
        assert_eq!(
            (bench.count(BusDead), bench.count(NoAnswer), bench.faults()),
            (1, 1, 2),
            "{stuck:#x}"
        );
        assert_eq!(bench.ids(), [8, 9, 10]);
        bench.trouble.borrow_mut().stuck = None;
        bench.board.advance_ns(500_000_000);
        bench.watch();
        bench.assert_begins_anew();
        assert_eq!(bench.restarts(), 2);
    }
}

#[test]
fn a_fast_plan_reads_its_health_at_the_start_and_when_it_is_requested() {
    for plan in [Plan::HAND, Plan::TEXTURE, Plan::VIBRATION, Plan::SINGLE] {
        let mut bench = Bench::with(plan);
        let inputs = Ads1258Plan::of(&plan).config().registers().unwrap();
        for round in 0..2 {
            for n in 0..40 {
                let is_health_read = bench.follow() == Drdy::HealthRead;
                assert_eq!(is_health_read, n == 4, "{plan:?} {n}");
            }
            let taxels = (0..16u8)
                .filter(|taxel| plan.inputs >> taxel & 1 == 1)
                .map(|taxel| 8 + taxel);
            let taxels: Vec<u8> = taxels.collect();
            let expected = [24, 26, 27, 28, 29]
                .into_iter()
                .chain(taxels.into_iter().cycle().take(35));
            assert!(bench.ids().into_iter().eq(expected), "{plan:?} {round}");
            assert_eq!(bench.registers(), inputs);
            bench.watch();
            assert_eq!((bench.faults(), bench.restarts()), (0, 0));
            assert!(bench.read_health());
        }
    }
    let mut paper = Bench::new();
    assert!(!paper.read_health(), "they are in its scan");
}

#[test]
fn a_plan_is_written_with_read_back_and_its_mark_precedes_its_conversions() {
    let mut bench = Bench::new();
    bench.pass(30);
    for plan in [Plan::SINGLE, Plan::HAND, Plan::PAPER] {
        bench.taken();
        bench.change(plan);
        for _ in 0..10 {
            let _ = bench.follow();
        }
        let taken = bench.taken();
        assert_eq!(taken[0].as_mark(), Some(plan.mark()));
        assert!(
            taken.len() == 11 && taken[1..].iter().all(|timed| timed.as_mark().is_none()),
            "{taken:?}"
        );
        let expected = Ads1258Plan::of(&plan).config().registers().unwrap();
        assert_eq!(bench.registers(), expected);
    }
    assert_eq!((bench.faults(), bench.overruns()), (0, 0));
    // While the queue is full, the mark waits.
    bench.pass(70);
    bench.change(Plan::HAND);
    let _ = bench.follow();
    // One health reading was lost.
    assert_eq!(bench.diagnostics.unseen.get(), 1);
    bench.taken();
    let _ = bench.follow();
    assert_eq!(bench.taken()[0].as_mark(), Some(Plan::HAND.mark()));
}

#[test]
fn a_fast_plan_reads_once_and_finds_wrong_ids() {
    let mut bench = Bench::with(Plan::HAND);
    for _ in 0..10 {
        let _ = bench.follow();
    }
    bench.taken();
    // Bit errors in the id, in NEW and in the code.
    for (byte, mask, is_seen) in [(1, 0x01, true), (1, 0x80, true), (3, 0x10, false)] {
        bench.flip_dout(byte, mask);
        let before = bench.count(Bus);
        let _ = bench.next();
        assert_eq!(bench.count(Bus) > before, is_seen, "{byte} {mask:#x}");
        bench.pass(3);
    }
    let ids = bench.ids();
    assert!(
        ids.windows(2)
            .all(|pair| pair[1] == if pair[0] == 23 { 8 } else { pair[0] + 1 }),
        "{ids:?}"
    );
    assert_eq!(bench.overruns(), 0);
}

#[test]
fn a_set_up_that_fails_once_is_tried_again_at_once() {
    let mut bench = Bench::new();
    bench.pass(5);
    bench.flip_register(CONFIG1, 0x02);
    // The watch reads nine registers twice and CONFIG0 once, each after a command byte; the set-up
    // then writes nine. Flip a bit of their read-back.
    bench.flip_dout(10 + 10 + 2 + 10 + 5, 0x04);
    bench.watch();
    assert_eq!((bench.count(NoAnswer), bench.restarts()), (0, 1));
    assert_eq!(bench.registers(), SCAN.registers().unwrap());
    bench.ids();
    bench.assert_begins_anew();
}

/// Serves conversions and does what they request, until the scan of the inputs runs.
fn inputs_of(plan: Plan) -> Bench {
    let mut bench = Bench::with(plan);
    for _ in 0..8 {
        let _ = bench.follow();
    }
    bench
}

#[test]
fn another_scan_begins_only_where_it_is_known_when_the_latest_conversion_ended() {
    let mut bench = inputs_of(Plan::HAND);
    let period_ns = u64::from(Plan::HAND.conversion_ns());
    // The next conversion comes near, and later the chip is silent.
    for (fifths, expected) in [(0, true), (2, true), (3, false), (2500, true)] {
        let later_us = (fifths * period_ns / 5 / 1000) as u32;
        let then_us = bench.now_us() + later_us;
        let can_begin = bench.acquisition.can_begin(then_us);
        assert_eq!(can_begin, expected, "{fifths} fifths of a conversion later");
    }
    // A conversion may have ended while the unexpected edge was served.
    let _ = bench.nothing();
    let answers = bench.can_begin_six_times();
    assert_eq!(
        (answers[..3].contains(&true), answers[5]),
        (false, true),
        "{answers:?}"
    );
}

#[test]
fn lasting_trouble_puts_another_scan_off_for_a_while_only() {
    let mut bench = inputs_of(Plan::HAND);
    let put_off = (0..=PUT_OFF_MAX)
        .take_while(|_| {
            assert!(bench.next().goes_on());
            let _ = bench.nothing();
            bench.taken();
            !bench.can_begin()
        })
        .count();
    assert_eq!(put_off, usize::from(PUT_OFF_MAX));
    assert_eq!(bench.count(Storm), 0);
}

/// Tests the restart after a storm: the first conversion may be read at any of the storm's edges.
#[test]
fn no_other_scan_begins_right_behind_a_storm() {
    let mut bench = inputs_of(Plan::SINGLE);
    bench.storm();
    bench.board.advance_ns(1_000_000);
    bench.watch();
    let answers = bench.can_begin_six_times();
    assert_eq!(
        (answers[..3].contains(&true), answers[5]),
        (false, true),
        "{answers:?}"
    );
}

/// Tests that losses from the scan of the health readings are added. Of other losses, which the
/// assembler counts too, `health` reports the larger of the two counts.
#[test]
fn a_conversion_of_the_health_readings_that_is_lost_comes_on_top() {
    let mut bench = inputs_of(Plan::SINGLE);
    assert!(bench.read_health());
    bench.pass(1);
    let lost = bench.read_and_lost().1;
    bench
        .board
        .wait_for_drdy()
        .expect("a conversion that is not read");
    bench.pass(2);
    assert_eq!(bench.read_and_lost().1, lost + 1, "by the chip's own count");
    assert_eq!((bench.diagnostics.unseen.get(), bench.overruns()), (1, 0));
}

/// Tests that the watch counts health readings lost while DRDY was muted, which no gap between
/// frames shows.
#[test]
fn conversions_of_health_readings_that_pass_while_drdy_is_muted_are_counted() {
    for (is_health, expected) in [(true, 11_669), (false, 0)] {
        let mut bench = inputs_of(Plan::HAND);
        if is_health {
            assert!(bench.read_health());
            bench.pass(2);
        }
        assert_eq!(bench.storm(), Some(STORM_EDGES), "{is_health}");
        assert!(!bench.can_begin(), "it is muted");
        bench.board.advance_ns(500_000_000);
        bench.watch();
        let unseen = bench.diagnostics.unseen.get();
        assert!(unseen.abs_diff(expected) <= 1, "{is_health}: {unseen}");
    }
}
