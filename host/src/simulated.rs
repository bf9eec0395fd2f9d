//! Runs the firmware's tasks on this PC, behind the simulated chip and its faults.
//!
//! Virtual time replaces interrupts: it triggers DRDY edges when they reach the pin, the watch
//! twice a second, and the tasks that these start. The processor and the line take no time; the bus
//! takes as long as on the board.

use crate::input::Opened;
use ads1258::Ads1258;
use anyhow::Result;
use embedded_hal::delay::DelayNs;
use embedded_storage::nor_flash::NorFlash;
use hal_mock::SimulatedBoard;
use hal_mock::board::{ChipSpi, ResetPin, StartPin};
use heapless::spsc::{Consumer, Queue};
use ridgetone_finger::Acquisition;
use ridgetone_finger::Detector;
use ridgetone_finger::Estimator;
use ridgetone_finger::Ring;
use ridgetone_finger::TimedConversion;
use ridgetone_finger::converter::WiredAds1258;
use ridgetone_finger::tasks::Detect;
use ridgetone_finger::tasks::Fit;
use ridgetone_finger::tasks::Report;
use ridgetone_finger::tasks::Requests;
use ridgetone_finger::tasks::WatchdogPolicy;
use ridgetone_finger::tasks::{BYTES, Platform, Samples, Shared, Task, WINDOWS};
use ridgetone_finger::tasks::{Drdy, DrdyPin};
use ridgetone_finger::tasks::{Mail, Outbox};
use ridgetone_finger::tasks::{Received, RequestInbox, receive};
use ridgetone_proto::boot::{Boot, ResetCause, SettingsSource};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::store::{FlashStore, Store};
use ridgetone_tone::Fitter;
use rtic_core::Exclusive;
use std::cell::{Cell, RefCell};

/// SCLK of the board, hertz.
const SCLK_HZ: u32 = 5_250_000;
/// Interval between two watches, nanoseconds.
const WATCH_NS: u64 = 500_000_000;

/// Surroundings of the board: the far end of its line, and an observer of its chip.
pub trait Surroundings {
    /// Called after the firmware has set up the chip, or has failed to.
    fn started(&mut self, board: &SimulatedBoard, is_set_up: bool) -> Result<()>;

    /// Called before `detect` takes this conversion.
    fn read(&mut self, _conversion: &TimedConversion, _board: &SimulatedBoard) {}

    /// Takes the bytes that the board has sent, usually none. Returns the bytes that the board
    /// receives.
    fn exchange(&mut self, board: &SimulatedBoard, sent: &[u8]) -> Result<Vec<Received>>;
}

/// Initial state of a board.
#[derive(Debug)]
pub struct Start<F: NorFlash> {
    pub store: FlashStore<F>,
    pub settings: Settings,
    pub source: SettingsSource,
    pub boot: Boot,
}

impl<F: NorFlash> Start<F> {
    /// Starts with the settings stored in the flash.
    pub fn new(flash: F, boot: Boot) -> Self {
        let mut store = FlashStore::new(flash);
        let (settings, source) = store.load();
        Self {
            store,
            settings,
            source,
            boot,
        }
    }
}

/// Runs the firmware's tasks until the input ends, including requested restarts. Returns the board.
pub fn run<F: NorFlash>(
    input: Opened,
    start: Start<F>,
    around: &mut dyn Surroundings,
) -> Result<SimulatedBoard> {
    let board = SimulatedBoard::new(input.scene, input.options);
    board.set_sclk_hz(SCLK_HZ);
    let mut start = start;
    while let Some(store) = run_until_restart(&board, start, around)? {
        start = Start::new(
            store.release(),
            Boot {
                cause: ResetCause::Software,
                ..Boot::UNKNOWN
            },
        );
    }
    Ok(board)
}

/// Runs until the input ends or the board must restart. Returns the store if the board must
/// restart.
fn run_until_restart<F: NorFlash>(
    board: &SimulatedBoard,
    start: Start<F>,
    around: &mut dyn Surroundings,
) -> Result<Option<FlashStore<F>>> {
    let mut wait = board.delay();
    let adc = Ads1258::new(board.spi());
    let converter = WiredAds1258::new(adc, board.start_pin(), board.reset_pin());
    let acquisition = Acquisition::new(converter, start.settings.plan);
    wait.delay_us(crate::replay::START_US);

    let samples = &Samples::new();
    let mut queues = (Queue::<_, WINDOWS>::new(), Queue::<_, BYTES>::new());
    let (windows_in, windows_out) = queues.0.split();
    let (bytes_in, bytes_out) = queues.1.split();
    let interrupt = Interrupt::default();
    let pin = Pin {
        board,
        interrupt: &interrupt,
        edge_us: 0,
    };
    let drdy = RefCell::new(Drdy::new(acquisition, pin, samples));
    let shared = Shared::new(
        Simulated {
            board,
            interrupt: &interrupt,
            drdy,
        },
        start.settings.plan,
    );
    let is_set_up = shared
        .platform
        .drdy
        .borrow_mut()
        .acquisition
        .set_up(&shared.diagnostics, &mut wait);
    around.started(board, is_set_up)?;
    let mut fitter = Box::new(Fitter::new());
    let mut detector = Box::new(Detector::new(start.settings));
    detector.boot(start.settings, start.source, start.boot);
    let mut tasks = Tasks {
        detect: Detect::new(samples, windows_in),
        fit: Fit {
            estimator: Estimator::new(start.settings),
            fitter: &mut fitter,
            windows: windows_out,
            requests: Requests::new(start.store),
        },
        report: Report::new(bytes_in),
        detector,
        ring: Box::new(Ring::new()),
        inbox: RequestInbox::new(),
        outbox: Outbox::new(),
        line: bytes_out,
        around,
    };
    tasks.run(&shared)?;
    let mut policy = WatchdogPolicy::new();
    let mut watch_ns = board.now_ns() + WATCH_NS;
    loop {
        let (edge_ns, event_ns) =
            board.with_chip(|chip| (chip.next_drdy_fall_ns(), chip.next_event_ns()));
        let edge_ns = edge_ns.filter(|_| !interrupt.is_muted.get());
        let next_ns = [edge_ns, event_ns]
            .into_iter()
            .flatten()
            .fold(watch_ns, u64::min);
        board.advance_ns(next_ns.saturating_sub(board.now_ns()));
        if edge_ns.is_some_and(|edge_ns| edge_ns <= next_ns) {
            interrupt.is_pending.set(true);
        }
        if next_ns >= watch_ns {
            watch_ns += WATCH_NS;
            // The result is ignored: the watchdog's policy is tested separately.
            let _ = policy.run(&shared);
            tasks.run(&shared)?;
        }
        // An edge that falls while `drdy` runs makes it run again.
        while interrupt.is_pending.get() {
            Simulated::pend(&shared, Task::Drdy);
            tasks.run(&shared)?;
        }
        if shared.is_restarting() && tasks.outbox.is_empty() {
            return Ok(Some(tasks.fit.requests.into_store()));
        }
        if board.with_chip(|chip| chip.ended()) {
            interrupt.has_ended.set(true);
            tasks.run(&shared)?;
            return Ok(None);
        }
    }
}

#[derive(Default)]
struct Interrupt {
    /// True if an edge has fallen and `drdy` has not run since.
    is_pending: Cell<bool>,
    is_muted: Cell<bool>,
    /// Board time of the next edge (nanoseconds), as known when `drdy` began or at the latest
    /// [`Interrupt::look`].
    ahead_ns: Cell<Option<u64>>,
    /// True if the scene has ended and the chip is no longer used.
    has_ended: Cell<bool>,
}

struct Pin<'a> {
    board: &'a SimulatedBoard,
    interrupt: &'a Interrupt,
    edge_us: u32,
}

impl Interrupt {
    /// Records an edge that has fallen.
    fn look(&self, board: &SimulatedBoard) {
        if !self.is_muted.get()
            && self
                .ahead_ns
                .get()
                .is_some_and(|ahead_ns| ahead_ns <= board.now_ns())
        {
            self.is_pending.set(true);
            self.ahead_ns
                .set(board.with_chip(|chip| chip.next_drdy_fall_ns()));
        }
    }
}

impl DrdyPin for Pin<'_> {
    fn acknowledge(&mut self) -> Option<bool> {
        // Read the board's clock before anything else.
        self.edge_us = now_us(self.board);
        self.interrupt.look(self.board);
        self.interrupt
            .is_pending
            .take()
            .then(|| self.board.with_chip(|chip| !chip.drdy_high(0)))
    }

    fn edge_us(&self) -> u32 {
        self.edge_us
    }

    fn mute(&mut self) {
        self.interrupt.is_muted.set(true);
    }

    fn unmute(&mut self) {
        // Edges before this time are ignored: they belong to the scan before the chip was set up
        // again.
        self.interrupt.is_muted.set(false);
        self.interrupt
            .ahead_ns
            .set(self.board.with_chip(|chip| chip.next_drdy_fall_ns()));
    }
}

fn now_us(board: &SimulatedBoard) -> u32 {
    (board.now_ns() / 1000) as u32
}

/// Runs `drdy` at once when it is pended; [`Tasks::run`] runs the other tasks.
struct Simulated<'a> {
    board: &'a SimulatedBoard,
    interrupt: &'a Interrupt,
    drdy: RefCell<Drdy<'a, WiredAds1258<ChipSpi, StartPin, ResetPin>, Pin<'a>>>,
}

impl Platform for Simulated<'_> {
    fn pend(shared: &Shared<Self>, task: Task) {
        if task != Task::Drdy {
            return;
        }
        let Self {
            board,
            interrupt,
            drdy,
        } = &shared.platform;
        interrupt
            .ahead_ns
            .set(board.with_chip(|chip| chip.next_drdy_fall_ns()));
        drdy.borrow_mut().run(shared, &mut board.delay());
        interrupt.look(board);
    }

    fn now_us(&self) -> u32 {
        now_us(self.board)
    }

    fn has_ended(&self) -> bool {
        self.interrupt.has_ended.get()
    }
}

/// The tasks with lower priority than `drdy`.
struct Tasks<'a, F: NorFlash> {
    detect: Detect<'a>,
    fit: Fit<'a, FlashStore<F>>,
    report: Report<'a>,
    detector: Box<Detector>,
    ring: Box<Ring>,
    inbox: RequestInbox,
    outbox: Outbox,
    line: Consumer<'a, u8>,
    around: &'a mut dyn Surroundings,
}

impl<F: NorFlash> Tasks<'_, F> {
    /// Runs every task once, and the line until there is nothing to send or receive.
    fn run(&mut self, shared: &Shared<Simulated<'_>>) -> Result<()> {
        let board = shared.platform.board;
        if let Some(conversion) = self.detect.next() {
            self.around.read(&conversion, board);
        }
        let Self {
            detect,
            fit,
            report,
            detector,
            ring,
            inbox,
            outbox,
            line,
            around,
        } = self;
        detect.run(detector, ring, outbox, shared);
        let (ring, outbox) = (&mut Exclusive(ring), &mut Exclusive(outbox));
        let mail = Mail {
            inbox: &mut Exclusive(&mut *inbox),
            outbox: &mut *outbox,
        };
        fit.run(ring, &mut Exclusive(&mut *detector), mail, shared);
        let mut sent = Vec::new();
        while !outbox.is_empty() {
            report.run(outbox, shared);
            while let Some(byte) = line.dequeue() {
                sent.push(byte);
            }
        }
        for received in around.exchange(board, &sent)? {
            receive(inbox, received, shared);
            // Zero is the last byte of a request: carry it out before the next one arrives.
            if matches!(received, Received::Byte(0)) {
                let mail = Mail {
                    inbox: &mut Exclusive(&mut *inbox),
                    outbox: &mut *outbox,
                };
                fit.run(ring, &mut Exclusive(&mut *detector), mail, shared);
            }
        }
        Ok(())
    }
}
