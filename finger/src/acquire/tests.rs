//! Against the simulated chip, and a bus that is in its way.

use super::*;
use FaultKind::{Bus, BusDead, NoAnswer, Registers, Repeated, Silent, Storm};
use core::convert::Infallible;
use embedded_hal::spi::{ErrorType, Operation};
use hal_mock::board::{ChipSpi, ResetPin, StartPin};
use hal_mock::{Constant, Fault, Options, SimulatedBoard};
use heapless::spsc::Queue;
extern crate std;
use std::cell::RefCell;
use std::rc::Rc;
use std::vec::Vec;

/// Registers of the chip (SBAS297G): CONFIG1 and MUXSG0.
const CONFIG1: u8 = 1;
const MUXSG0: u8 = 4;

/// The bus: before every transaction some time may pass, and it may be dead.
struct Wire {
    spi: ChipSpi,
    board: SimulatedBoard,
    trouble: Rc<RefCell<Trouble>>,
}

#[derive(Default)]
struct Trouble {
    /// From the next transaction on: nanoseconds before each.
    waits_ns: Vec<u64>,
    /// What DOUT is stuck at.
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
    acquisition: Acquisition<Wire, StartPin, ResetPin>,
    queue: Queue<TimedConversion, 64>,
    diagnostics: Diagnostics,
}

impl Bench {
    /// A chip that was set up.
    fn new() -> Self {
        // Every code another one, by the noise.
        let board = SimulatedBoard::new(Constant { end_s: f64::INFINITY, ..Constant::default() }, Options::default());
        let trouble = Rc::<RefCell<Trouble>>::default();
        let wire = Wire { spi: board.spi(), board: board.clone(), trouble: trouble.clone() };
        let mut acquisition = Acquisition::new(Ads1258::new(wire), board.start_pin(), board.reset_pin());
        let diagnostics = Diagnostics::new();
        assert!(acquisition.set_up(&diagnostics, &mut board.delay()));
        Self { board, trouble, acquisition, queue: Queue::new(), diagnostics }
    }

    fn now_us(&self) -> u32 {
        (self.board.now_ns() / 1000) as u32
    }

    /// Serves the interrupt of an edge, whose time the board takes as it gets there.
    fn serve(&mut self) -> Drdy {
        let t_us = self.now_us();
        self.acquisition.edge(|| t_us, &mut self.queue.split().0, &self.diagnostics)
    }

    /// The next conversion, served at its edge.
    fn next(&mut self) -> Drdy {
        self.board.wait_for_drdy().expect("a conversion");
        self.serve()
    }

    /// Conversions that are not looked at.
    fn pass(&mut self, conversions: u32) {
        for _ in 0..conversions {
            let _ = self.next();
        }
    }

    fn watch(&mut self) {
        let now_us = self.now_us();
        self.acquisition.watch(now_us, &self.diagnostics, &mut self.board.delay());
    }

    /// The ids queued so far.
    fn ids(&mut self) -> Vec<u8> {
        self.taken().iter().map(|timed| timed.conversion.status.chid()).collect()
    }

    fn taken(&mut self) -> Vec<TimedConversion> {
        let mut out = self.queue.split().1;
        core::iter::from_fn(|| out.dequeue()).collect()
    }

    fn count(&self, kind: FaultKind) -> u32 {
        self.diagnostics.faults.count(kind)
    }

    fn faults(&self) -> u32 {
        self.diagnostics.faults.counts().iter().sum()
    }

    /// Counts of the simulated chip.
    fn read_and_lost(&self) -> (u64, u64) {
        self.board.with_chip(|chip| (chip.counters().read, chip.counters().lost))
    }
}

#[test]
fn every_conversion_is_read_twice_and_queued_once() {
    let mut bench = Bench::new();
    assert!((0..50).all(|_| bench.next() == Drdy::Listen));
    // Two scans and a bit (SBAS297G: ascending CHID; 19h is unused).
    let scan = [8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 26, 27, 28, 29];
    assert!(bench.ids().iter().eq(scan.iter().cycle().take(50)));
    assert_eq!((bench.faults(), bench.read_and_lost()), (0, (50, 0)));
}

#[test]
fn a_bit_that_falls_over_is_mended_wherever_it_is() {
    // Two reads of five bytes; what comes during the command has no meaning.
    for byte in (0..10).filter(|byte| byte % 5 != 0) {
        for bit in 0..8 {
            let (mut plain, mut bench) = (Bench::new(), Bench::new());
            for n in 0..30 {
                plain.pass(1);
                if n == 7 {
                    bench
                        .board
                        .with_chip(|chip| chip.begin_fault(Fault::DoutFlip { bytes_ahead: byte, mask: 1 << bit }));
                }
                assert_eq!(bench.next() == Drdy::Watch, n == 7, "byte {byte}, bit {bit}");
            }
            assert_eq!(bench.taken(), plain.taken(), "byte {byte}, bit {bit}");
            assert_eq!((bench.count(Bus), bench.faults()), (1, 1), "byte {byte}, bit {bit}");
        }
    }
}

#[test]
fn what_no_two_reads_agree_on_is_dropped_and_counted() {
    let mut bench = Bench::new();
    for byte in [2, 8, 14] {
        bench.board.with_chip(|chip| chip.begin_fault(Fault::DoutFlip { bytes_ahead: byte, mask: 1 << (byte / 5) }));
    }
    assert_eq!([bench.next(), bench.next(), bench.next()], [Drdy::Watch, Drdy::Listen, Drdy::Listen]);
    assert_eq!(bench.ids(), [9, 10]);
    assert_eq!((bench.count(Bus), bench.faults(), bench.diagnostics.overruns.get()), (1, 1, 1));
}

#[test]
fn a_conversion_that_ends_between_two_reads_is_taken_once_and_none_is_lost_in_silence() {
    let period_ns = 197_474;
    for late_ns in [period_ns - 1, period_ns - 1000, 1000] {
        let mut bench = Bench::new();
        bench.pass(1);
        bench.board.wait_for_drdy();
        // The board is late: the next edge is between the first read and the second, or (the last time) behind both.
        bench.trouble.borrow_mut().waits_ns = std::vec![late_ns, 2000];
        assert_eq!(bench.serve(), Drdy::Listen);
        let between = late_ns > period_ns - 2000;
        if between {
            // Its interrupt is pending and finds nothing new, with DRDY low or high again.
            assert_eq!(bench.serve(), Drdy::Listen);
        }
        assert!((0..5).all(|_| bench.next() == Drdy::Listen));
        let ids = bench.ids();
        assert_eq!(ids, if between { &[8, 10, 11, 12, 13, 14, 15][..] } else { &[8, 9, 10, 11, 12, 13, 14] });
        assert_eq!((bench.faults(), bench.diagnostics.overruns.get()), (0, between as u32));
        assert_eq!(bench.read_and_lost().0, ids.len() as u64 + between as u64);
    }
}

#[test]
fn what_does_not_fit_the_queue_is_counted() {
    let mut bench = Bench::new();
    assert!((0..70).all(|_| bench.next() == Drdy::Listen));
    assert_eq!((bench.taken().len(), bench.diagnostics.overruns.get()), (63, 7));
}

#[test]
fn an_edge_without_a_conversion_is_counted_and_gives_none() {
    let mut bench = Bench::new();
    bench.pass(1);
    bench.board.advance_ns(50_000);
    assert_eq!(bench.serve(), Drdy::Watch);
    assert_eq!(bench.acquisition.nothing(0, &bench.diagnostics), Drdy::Listen);
    assert_eq!((bench.count(Repeated), bench.faults()), (2, 2));
    bench.watch();
    assert_eq!((bench.next(), bench.ids()), (Drdy::Listen, std::vec![8, 9]));
}

#[test]
fn a_storm_is_muted_until_the_next_watch() {
    let mut bench = Bench::new();
    bench.pass(1);
    let served = (1..).find(|_| bench.acquisition.nothing(0, &bench.diagnostics) == Drdy::Mute);
    assert_eq!(served, Some(STORM_EDGES));
    assert!(bench.acquisition.is_quiet(bench.now_us()) && bench.count(Storm) == 1);
    // As long as it likes: nothing could come, so the chip is not taken for silent.
    bench.board.advance_ns(500_000_000);
    bench.watch();
    assert!(bench.next() == Drdy::Listen || bench.next() == Drdy::Listen);
    assert_eq!((bench.count(Silent), bench.diagnostics.chip_restarts.get()), (0, 0));
}

#[test]
fn registers_that_change_are_written_anew_and_the_scan_begins_at_its_top() {
    let mut bench = Bench::new();
    bench.pass(5);
    bench.board.with_chip(|chip| chip.begin_fault(Fault::RegisterFlip { address: CONFIG1, mask: 0x02 }));
    bench.watch();
    assert_eq!((bench.count(Registers), bench.faults(), bench.diagnostics.chip_restarts.get()), (1, 1, 1));
    let registers = bench.board.with_chip(|chip| chip.registers());
    assert_eq!(registers[..9], SCAN.registers().unwrap());
    bench.ids();
    assert_eq!((bench.next(), bench.ids()), (Drdy::Listen, std::vec![8]));
}

#[test]
fn one_wrong_look_at_the_registers_is_no_reason_to_restart() {
    let mut bench = Bench::new();
    bench.pass(1);
    bench.board.with_chip(|chip| chip.begin_fault(Fault::DoutFlip { bytes_ahead: 3, mask: 0x10 }));
    bench.watch();
    assert_eq!((bench.faults(), bench.diagnostics.chip_restarts.get()), (0, 0));
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
    // It begins at AIN0, which is not what follows the 30th conversion.
    assert_eq!(noticed, Some(1));
    bench.watch();
    bench.ids();
    assert!((0..21).all(|_| bench.next() == Drdy::Listen));
    assert_eq!((bench.count(Registers), bench.diagnostics.chip_restarts.get()), (1, 1));
}

#[test]
fn a_silent_chip_is_restarted_again_and_again_with_pauses_that_grow() {
    let mut bench = Bench::new();
    bench.pass(1);
    bench.board.with_chip(|chip| chip.begin_fault(Fault::Stall));
    let mut restarts_ms = Vec::new();
    for half in 1..=60 {
        bench.board.advance_ns(500_000_000);
        bench.watch();
        if bench.diagnostics.chip_restarts.get() as usize > restarts_ms.len() {
            restarts_ms.push(half * 500);
        }
    }
    // At once, then as soon as pauses of 125 ms, 250 ms, ... 4 s are over at one of the looks twice a second.
    assert_eq!(restarts_ms, [500, 1000, 1500, 2000, 3000, 5000, 9000, 13000, 17000, 21000, 25000, 29000]);
    assert_eq!((bench.count(Silent), bench.faults()), (60, 60));
    bench.board.with_chip(|chip| chip.end_fault(Fault::Stall));
    // It goes on by itself as soon as it can; after a while trouble is mended at once again.
    for _ in 0..5 * 5064 {
        bench.pass(1);
        bench.ids();
    }
    bench.watch();
    bench.board.with_chip(|chip| chip.begin_fault(Fault::RegisterFlip { address: MUXSG0, mask: 0x01 }));
    bench.watch();
    assert_eq!((bench.count(Registers), bench.diagnostics.chip_restarts.get()), (1, 13));
}

#[test]
fn a_dead_bus_gives_no_conversion_and_is_tried_again_until_it_lives() {
    for stuck in [0x00, 0xff] {
        let mut bench = Bench::new();
        bench.pass(3);
        bench.trouble.borrow_mut().stuck = Some(stuck);
        assert_eq!(bench.next(), Drdy::Watch);
        bench.watch();
        // It cannot be set up, so it is not started either.
        assert_eq!(bench.board.wait_for_drdy().and(bench.board.wait_for_drdy()), None);
        assert_eq!((bench.count(BusDead), bench.count(NoAnswer), bench.faults()), (1, 1, 2), "{stuck:#x}");
        assert_eq!(bench.ids(), [8, 9, 10]);
        bench.trouble.borrow_mut().stuck = None;
        bench.board.advance_ns(500_000_000);
        bench.watch();
        assert_eq!((bench.next(), bench.ids()), (Drdy::Listen, std::vec![8]));
        assert_eq!(bench.diagnostics.chip_restarts.get(), 2);
    }
}
