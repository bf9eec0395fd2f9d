//! The firmware's tasks on this PC, behind the simulated chip and its faults.
//!
//! Virtual time takes the place of interrupts: DRDY's edges as they arrive at the pin, the watch twice a second, then the
//! tasks that these start. The processor takes no time, the bus takes as long as the board's.

use super::power_cuts::CutFlash;
use super::scan_order::ScanOrder;
use ads1258::Ads1258;
use anyhow::{Result, ensure};
use embedded_hal::delay::DelayNs;
use hal_mock::board::{ChipSpi, ResetPin, StartPin};
use hal_mock::chip::REGISTERS;
use hal_mock::{Counters, Injected, SimulatedBoard};
use heapless::spsc::{Consumer, Queue};
use ridgetone::acquire::Acquisition;
use ridgetone::detector::Detector;
use ridgetone::estimator::Estimator;
use ridgetone::frame::TimedConversion;
use ridgetone::ring::Ring;
use ridgetone::tasks::detect::Detect;
use ridgetone::tasks::drdy::{Drdy, DrdyPin};
use ridgetone::tasks::fit::Fit;
use ridgetone::tasks::liveness::WatchdogPolicy;
use ridgetone::tasks::outbox::Outbox;
use ridgetone::tasks::report::Report;
use ridgetone::tasks::requests::Requests;
use ridgetone::tasks::shared::{BYTES, PACKETS, Platform, SAMPLES, Shared, Task, WINDOWS};
use ridgetone::tasks::watch;
use ridgetone_host::input::Opened;
use ridgetone_proto::framing::Inbox;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::store::FlashStore;
use ridgetone_proto::telemetry::{Decoder, Packet};
use rtic_core::Exclusive;
use std::cell::{Cell, RefCell};

/// SCLK of the board, hertz.
const SCLK_HZ: u32 = 5_250_000;
/// From one watch to the next, nanoseconds.
const WATCH_NS: u64 = 500_000_000;

#[derive(Clone, Debug, Default)]
pub struct Ran {
    pub packets: Vec<Packet>,
    /// Packets that were lost, and damaged ones.
    pub line: (u32, u32),
    pub chip: Counters,
    /// When each injection acted, nanoseconds of the simulated board.
    pub injected: Vec<Injected>,
    /// Conversions from the queue with NEW set.
    pub delivered: u64,
    /// Those among them that are not what the chip had converted.
    pub altered: u64,
    /// Times of the simulated board, nanoseconds, at which a scan was complete without a flaw while the registers were right.
    pub whole_ns: Vec<u64>,
    /// Zero of the device time, nanoseconds of the simulated board.
    pub zero_ns: u64,
    /// End of the run, nanoseconds of the simulated board.
    pub end_ns: u64,
    pub registers_right: bool,
}

/// Runs `input` through the firmware's tasks.
pub fn run(input: Opened, settings: Settings) -> Result<Ran> {
    let board = SimulatedBoard::new(input.scene, input.options);
    board.set_sclk_hz(SCLK_HZ);
    let mut wait = board.delay();
    let acquisition = Acquisition::new(Ads1258::new(board.spi()), board.start_pin(), board.reset_pin());
    wait.delay_us(ridgetone_host::replay::START_US);

    let mut queues = (Queue::<_, SAMPLES>::new(), Queue::<_, WINDOWS>::new(), Queue::<_, BYTES>::new());
    let (samples_in, samples_out) = queues.0.split();
    let (windows_in, windows_out) = queues.1.split();
    let (bytes_in, bytes_out) = queues.2.split();
    let interrupt = Interrupt::default();
    let pin = Pin { board: &board, interrupt: &interrupt, edge_us: 0 };
    let drdy = RefCell::new(Drdy { acquisition, pin, samples: samples_in });
    let shared = Shared::new(Simulated { board: &board, interrupt: &interrupt, drdy });
    let is_set_up = shared.platform.drdy.borrow_mut().acquisition.set_up(&shared.diagnostics, &mut wait);
    ensure!(is_set_up, "the simulated chip cannot be set up");
    let mut estimator = Box::new(Estimator::new(settings));
    let mut tasks = Tasks {
        detect: Detect::new(samples_out, windows_in),
        fit: Fit {
            estimator: &mut estimator,
            windows: windows_out,
            requests: Requests::new(FlashStore::new(CutFlash::new(1))),
        },
        report: Report::new(bytes_in),
        detector: Box::new(Detector::new(settings)),
        ring: Box::new(Ring::new()),
        inbox: Inbox::new(),
        outbox: Outbox::new(),
        line: bytes_out,
        decoder: Decoder::new(),
        ran: Ran::default(),
        registers: board.with_chip(|chip| chip.registers()),
        order: ScanOrder::default(),
        begun: false,
    };
    tasks.run(&shared);
    let mut policy = WatchdogPolicy::new();
    let mut watch_ns = board.now_ns() + WATCH_NS;
    loop {
        let (edge_ns, event_ns) = board.with_chip(|chip| (chip.next_drdy_fall_ns(), chip.next_event_ns()));
        let edge_ns = edge_ns.filter(|_| !interrupt.is_muted.get());
        let next_ns = [edge_ns, event_ns].into_iter().flatten().fold(watch_ns, u64::min);
        board.advance_ns(next_ns.saturating_sub(board.now_ns()));
        if edge_ns.is_some_and(|edge_ns| edge_ns <= next_ns) {
            interrupt.is_pending.set(true);
        }
        if next_ns >= watch_ns {
            watch_ns += WATCH_NS;
            // The watchdog's policy has tests of its own.
            let _ = watch::run(&mut policy, &shared);
            tasks.run(&shared);
        }
        // An edge that falls while `drdy` runs makes it run again.
        while interrupt.is_pending.get() {
            Simulated::pend(&shared, Task::Drdy);
            tasks.run(&shared);
        }
        if board.with_chip(|chip| chip.ended()) {
            interrupt.has_ended.set(true);
            tasks.run(&shared);
            return Ok(tasks.into_ran(&board));
        }
    }
}

/// The state of DRDY's interrupt.
#[derive(Default)]
struct Interrupt {
    /// An edge has fallen, and `drdy` has not run since.
    is_pending: Cell<bool>,
    is_muted: Cell<bool>,
    /// The scene is over: the chip is left alone.
    has_ended: Cell<bool>,
}

struct Pin<'a> {
    board: &'a SimulatedBoard,
    interrupt: &'a Interrupt,
    edge_us: u32,
}

impl DrdyPin for Pin<'_> {
    fn acknowledge(&mut self) -> Option<bool> {
        // The board's own clock, read first thing.
        self.edge_us = now_us(self.board);
        self.interrupt.is_pending.take().then(|| self.board.with_chip(|chip| !chip.drdy_high(0)))
    }

    fn edge_us(&self) -> u32 {
        self.edge_us
    }

    fn mute(&mut self) {
        self.interrupt.is_muted.set(true);
    }

    fn unmute(&mut self) {
        self.interrupt.is_muted.set(false);
    }
}

fn now_us(board: &SimulatedBoard) -> u32 {
    (board.now_ns() / 1000) as u32
}

/// Runs `drdy` at once, and leaves the other tasks to [`Tasks::run`].
struct Simulated<'a> {
    board: &'a SimulatedBoard,
    interrupt: &'a Interrupt,
    drdy: RefCell<Drdy<'a, ChipSpi, StartPin, ResetPin, Pin<'a>>>,
}

impl Platform for Simulated<'_> {
    fn pend(shared: &Shared<Self>, task: Task) {
        if task != Task::Drdy {
            return;
        }
        let Self { board, interrupt, drdy } = &shared.platform;
        let ahead_ns = board.with_chip(|chip| chip.next_drdy_fall_ns());
        drdy.borrow_mut().run(shared, &mut board.delay());
        if !interrupt.is_muted.get() && ahead_ns.is_some_and(|ahead_ns| ahead_ns <= board.now_ns()) {
            interrupt.is_pending.set(true);
        }
    }

    fn now_us(&self) -> u32 {
        now_us(self.board)
    }

    fn has_ended(&self) -> bool {
        self.interrupt.has_ended.get()
    }
}

/// The tasks below `drdy`, and what the campaign observes.
struct Tasks<'a> {
    detect: Detect<'a>,
    fit: Fit<'a, FlashStore<CutFlash<1024>>>,
    report: Report<'a>,
    detector: Box<Detector>,
    ring: Box<Ring>,
    inbox: Inbox<{ ridgetone_proto::command::REQUEST_WIRE_MAX }>,
    outbox: Outbox<PACKETS>,
    line: Consumer<'a, u8>,
    decoder: Decoder,
    ran: Ran,
    /// The registers after set-up.
    registers: [u8; REGISTERS],
    order: ScanOrder,
    begun: bool,
}

impl Tasks<'_> {
    /// Runs every task once, and the line until it is silent.
    fn run(&mut self, shared: &Shared<Simulated>) {
        if let Some(conversion) = self.detect.next().copied() {
            self.observe(&conversion, shared.platform.board);
        }
        let Self { detect, fit, report, detector, ring, inbox, outbox, .. } = self;
        detect.run(detector, ring, outbox, shared);
        let outbox = &mut Exclusive(outbox);
        fit.run(&mut Exclusive(ring), &mut Exclusive(detector), &mut Exclusive(inbox), outbox, shared);
        while !outbox.is_empty() {
            report.run(outbox, shared);
            while let Some(byte) = self.line.dequeue() {
                self.ran.packets.extend(self.decoder.push(byte));
            }
        }
    }

    fn into_ran(self, board: &SimulatedBoard) -> Ran {
        let (line, end_ns) = ((self.decoder.missing, self.decoder.damaged), board.now_ns());
        let registers_right = board.with_chip(|chip| chip.registers()) == self.registers;
        board.with_chip(|chip| Ran {
            line,
            chip: chip.counters(),
            injected: chip.injected().to_vec(),
            end_ns,
            registers_right,
            ..self.ran
        })
    }

    /// Compares a conversion with what the chip knows of it.
    fn observe(&mut self, timed: &TimedConversion, board: &SimulatedBoard) {
        let status = timed.conversion.status;
        if !status.is_new() {
            return;
        }
        let (truth, registers, edge_ns) =
            board.with_chip(|chip| (chip.latest_results(), chip.registers(), chip.latest_drdy_fall_ns().unwrap_or(0)));
        let ran = &mut self.ran;
        if !std::mem::replace(&mut self.begun, true) {
            ran.zero_ns = edge_ns;
        }
        ran.delivered += 1;
        ran.altered += u64::from(!truth.contains(&(status.0 & 0x7F, timed.conversion.code)));
        let is_whole = self.order.take(&timed.conversion);
        if is_whole && registers == self.registers {
            ran.whole_ns.push(board.now_ns());
        }
    }
}
