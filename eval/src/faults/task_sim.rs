//! The firmware's task_sim on this PC, run as its tasks run them, behind the simulated chip and its faults.
//!
//! What `main.rs` does by interrupts happens here by virtual time: DRDY's edges as they arrive at the pin, the watch
//! twice a second, then whatever they left to do. The processor takes no time, the bus takes the board's.

use super::scan_order::Order;

use ads1258::Ads1258;
use anyhow::{Result, ensure};
use embedded_hal::delay::DelayNs;
use hal_mock::board::{ChipSpi, ResetPin, StartPin};
use hal_mock::{Counters, Injected, SimulatedBoard};
use heapless::spsc::{Consumer, Producer, Queue};
use ridgetone::acquire::{Acquisition, Drdy};
use ridgetone::faults::diagnostics::Diagnostics;
use ridgetone::faults::qualify::qualify;
use ridgetone::frame::TimedConversion;
use ridgetone::pipeline::{Detector, Estimator};
use ridgetone::ring::Ring;
use ridgetone::tasks::outbox::Outbox;
use ridgetone::tasks::queues::{PACKETS, SAMPLES, WINDOWS};
use ridgetone::window::Window;
use ridgetone_host::input::Opened;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Decoder, Event, Packet, Span, WIRE_MAX, encode};
use std::collections::VecDeque;

/// SCLK of the board, hertz.
const SCLK_HZ: u32 = 5_250_000;
/// From one watch to the next, nanoseconds.
const WATCH_NS: u64 = 500_000_000;

/// What came of a run.
#[derive(Clone, Debug, Default)]
pub struct Ran {
    /// Telemetry, decoded.
    pub packets: Vec<Packet>,
    /// Packets that never came, and damaged ones.
    pub line: (u32, u32),
    /// What the chip has done.
    pub chip: Counters,
    /// When each injection acted, nanoseconds of the rig.
    pub injected: Vec<Injected>,
    /// Conversions that came out of the queue with NEW set.
    pub delivered: u64,
    /// Those among them that are not what the chip had converted.
    pub altered: u64,
    /// Times of the rig, nanoseconds, at which a scan had come without a flaw while the registers were right.
    pub whole_ns: Vec<u64>,
    /// Zero of the device time, nanoseconds of the rig.
    pub zero_ns: u64,
    /// End of the run, nanoseconds of the rig.
    pub end_ns: u64,
    /// Whether the registers were right at the end.
    pub registers_right: bool,
}

/// Runs `input` through the task_sim.
///
/// # Errors
/// An event that does not fit the wire format; the simulated chip does not let itself be set up.
pub fn run(input: Opened, settings: Settings) -> Result<Ran> {
    let rig = SimulatedBoard::new(input.scene, input.options);
    rig.set_sclk_hz(SCLK_HZ);
    let mut wait = rig.delay();
    let mut chip = Acquisition::new(Ads1258::new(rig.spi()), rig.start_pin(), rig.reset_pin());
    wait.delay_us(ridgetone_host::replay::START_US);
    ensure!(chip.set_up(&mut wait), "the simulated chip cannot be set up");

    let mut samples: Queue<TimedConversion, SAMPLES> = Queue::new();
    let (samples_in, samples_out) = samples.split();
    let registers = rig.with_chip(|chip| chip.registers());
    let diagnostics = Diagnostics::new();
    let mut tasks = Tasks::new(settings, samples_out, &diagnostics, registers);
    tasks.greet()?;
    let mut drdy = Interrupt {
        rig: &rig,
        chip,
        samples: samples_in,
        diagnostics: &diagnostics,
        muted: false,
        check: false,
        pending: false,
        ended: false,
    };
    let mut watch_ns = rig.now_ns() + WATCH_NS;
    loop {
        let (edge_ns, event_ns) = rig.with_chip(|chip| (chip.next_drdy_fall_ns(), chip.next_event_ns()));
        let edge_ns = edge_ns.filter(|_| !drdy.muted);
        let next_ns = [edge_ns, event_ns].into_iter().flatten().fold(watch_ns, u64::min);
        rig.advance_ns(next_ns.saturating_sub(rig.now_ns()));
        drdy.pending |= edge_ns.is_some_and(|edge_ns| edge_ns <= next_ns);
        if next_ns >= watch_ns {
            watch_ns += WATCH_NS;
            drdy.check = true;
            let edge = std::mem::take(&mut drdy.pending);
            drdy.serve(edge, false);
            tasks.run(&mut drdy)?;
            tasks.look(&rig)?;
        }
        // An edge that falls while one is served makes it run again.
        while std::mem::take(&mut drdy.pending) {
            drdy.serve(true, false);
            tasks.run(&mut drdy)?;
        }
        if rig.with_chip(|chip| chip.ended()) {
            drdy.ended = true;
            return tasks.finish(&mut drdy);
        }
    }
}

/// The task `drdy`.
struct Interrupt<'a> {
    rig: &'a SimulatedBoard,
    chip: Acquisition<ChipSpi, StartPin, ResetPin>,
    samples: Producer<'a, TimedConversion>,
    diagnostics: &'a Diagnostics,
    muted: bool,
    /// The chip is to be checked.
    check: bool,
    /// An edge fell while this ran.
    pending: bool,
    /// The scene is over: the chip is left alone.
    ended: bool,
}

impl Interrupt<'_> {
    /// The check is made if it is `urgent`, or behind an edge, or if no conversion is likely to come.
    fn serve(&mut self, edge: bool, urgent: bool) {
        let ahead_ns = self.rig.with_chip(|chip| chip.next_drdy_fall_ns());
        self.once(edge, urgent);
        self.pending |= !self.muted && ahead_ns.is_some_and(|ahead_ns| ahead_ns <= self.rig.now_ns());
    }

    fn once(&mut self, edge: bool, urgent: bool) {
        let Self { rig, chip, samples, diagnostics, .. } = self;
        let now_us = || (rig.now_ns() / 1000) as u32;
        // The board's own clock, read first thing.
        let edge_us = now_us();
        let is_low = || rig.with_chip(|chip| !chip.drdy_high(0));
        let verdict = match edge.then(is_low) {
            Some(true) => chip.edge(|| edge_us, samples, diagnostics),
            Some(false) => chip.nothing(edge_us, diagnostics),
            None => Drdy::Listen,
        };
        match verdict {
            Drdy::Listen => {}
            Drdy::Watch => self.check = true,
            Drdy::Mute => self.muted = true,
        }
        if self.check && !self.ended && (edge || urgent || chip.is_quiet(now_us())) {
            self.check = false;
            chip.watch(now_us(), diagnostics, &mut rig.delay());
            self.muted = false;
        }
    }
}

/// What the other interrupts do.
struct Tasks<'a> {
    samples: Consumer<'a, TimedConversion>,
    diagnostics: &'a Diagnostics,
    detector: Box<Detector>,
    estimator: Box<Estimator>,
    ring: Box<Ring>,
    windows: VecDeque<Window>,
    outbox: Outbox<PACKETS>,
    decoder: Decoder,
    ran: Ran,
    /// The registers as they were written at first.
    registers: [u8; hal_mock::chip::REGISTERS],
    order: Order,
    begun: bool,
}

impl<'a> Tasks<'a> {
    fn new(
        settings: Settings,
        samples: Consumer<'a, TimedConversion>,
        diagnostics: &'a Diagnostics,
        registers: [u8; hal_mock::chip::REGISTERS],
    ) -> Self {
        Self {
            samples,
            diagnostics,
            detector: Box::new(Detector::new(settings)),
            estimator: Box::new(Estimator::new(settings)),
            ring: Box::new(Ring::new()),
            windows: VecDeque::new(),
            outbox: Outbox::new(),
            decoder: Decoder::new(),
            ran: Ran::default(),
            registers,
            order: Order::default(),
            begun: false,
        }
    }

    fn greet(&mut self) -> Result<()> {
        let hello = self.detector.hello().into();
        self.post(hello);
        self.report()
    }

    /// `detect`, `fit` and `report`, until nothing is left.
    fn run(&mut self, drdy: &mut Interrupt) -> Result<()> {
        while let Some(conversion) = self.samples.dequeue() {
            self.look_at(&conversion, drdy.rig);
            let Self { detector, ring, outbox, windows, diagnostics, .. } = self;
            detector.push(
                conversion,
                ring,
                diagnostics,
                &mut poster(outbox, diagnostics),
                &mut queue(windows, diagnostics),
            );
            self.fit_and_report(drdy)?;
        }
        Ok(())
    }

    /// What `watch` has `detect` do besides.
    fn look(&mut self, rig: &SimulatedBoard) -> Result<()> {
        let Self { detector, outbox, diagnostics, .. } = self;
        detector.look((rig.now_ns() / 1000) as u32, diagnostics, &mut poster(outbox, diagnostics));
        self.report()
    }

    fn finish(mut self, drdy: &mut Interrupt) -> Result<Ran> {
        let Self { detector, ring, outbox, windows, diagnostics, .. } = &mut self;
        detector.finish(ring, diagnostics, &mut poster(outbox, diagnostics), &mut queue(windows, diagnostics));
        self.fit_and_report(drdy)?;
        let rig = drdy.rig;
        let mut ran = self.ran;
        ran.line = (self.decoder.missing, self.decoder.damaged);
        ran.end_ns = rig.now_ns();
        rig.with_chip(|chip| {
            ran.chip = chip.counters();
            ran.injected = chip.injected().to_vec();
            ran.registers_right = chip.registers() == self.registers;
        });
        Ok(ran)
    }

    /// Compares a conversion with what the chip knows of it.
    fn look_at(&mut self, timed: &TimedConversion, rig: &SimulatedBoard) {
        let status = timed.conversion.status;
        if !status.is_new() {
            return;
        }
        let (truth, registers, edge_ns) =
            rig.with_chip(|chip| (chip.latest_results(), chip.registers(), chip.latest_drdy_fall_ns().unwrap_or(0)));
        let ran = &mut self.ran;
        if !std::mem::replace(&mut self.begun, true) {
            ran.zero_ns = edge_ns;
        }
        ran.delivered += 1;
        ran.altered += u64::from(!truth.contains(&(status.0 & 0x7F, timed.conversion.code)));
        let is_whole = self.order.take(&timed.conversion);
        if is_whole && registers == self.registers {
            ran.whole_ns.push(rig.now_ns());
        }
    }

    fn fit_and_report(&mut self, drdy: &mut Interrupt) -> Result<()> {
        while let Some(window) = self.windows.pop_front() {
            match self.estimator.run(&window, &mut &*self.ring, None) {
                Ok(Some(mut estimate)) => {
                    // Checked after the window's end, before it is told.
                    drdy.check = true;
                    drdy.serve(false, true);
                    qualify(&mut estimate, &window, self.diagnostics);
                    self.post(Event::Estimate(estimate));
                }
                Ok(None) => {}
                Err(_) => self.diagnostics.hop_skipped(),
            }
        }
        self.report()
    }

    fn post(&mut self, event: Event) {
        poster_of(&mut self.outbox, self.diagnostics, event);
    }

    fn report(&mut self) -> Result<()> {
        let mut wire = [0; WIRE_MAX];
        while let Some(packet) = self.outbox.take() {
            let length = encode(&packet, &mut wire)?;
            self.ran.packets.extend(wire[..length].iter().filter_map(|byte| self.decoder.push(*byte)));
        }
        Ok(())
    }
}

fn poster_of(outbox: &mut Outbox<PACKETS>, diagnostics: &Diagnostics, event: Event) {
    if outbox.post(event) {
        diagnostics.message_dropped();
    }
}

fn poster(outbox: &mut Outbox<PACKETS>, diagnostics: &Diagnostics) -> impl FnMut(Event) {
    move |event| poster_of(outbox, diagnostics, event)
}

fn queue(windows: &mut VecDeque<Window>, diagnostics: &Diagnostics) -> impl FnMut(Window) {
    move |window| {
        let wanted = window.span == Span::Slide || windows.is_empty();
        // A queue holds one less than its places.
        if wanted && windows.len() < WINDOWS - 1 {
            windows.push_back(window);
        } else {
            diagnostics.hop_skipped();
        }
    }
}
