//! The firmware: an RTIC app, no arithmetic.
//!
//! | task | priority | interrupt | does |
//! |---|---|---|---|
//! | `drdy` | 5 | EXTI4, DRDY's falling edge | reads one conversion, queues it; checks the chip when asked |
//! | `line` | 4 | USART3, transmitter empty or byte received | sends one byte of telemetry, takes one of an order |
//! | `detect` | 3 | CAN1_RX0, pended by `drdy` | frames, contact, windows |
//! | `report` | 2 | CAN1_TX, pended by whoever has an event | encodes packets |
//! | `watch` | 2 | TIM4, twice a second | has `drdy` check the chip's registers, feeds the watchdog if all tasks live |
//! | `fit` | 1 | CAN1_RX1, pended by `detect` and `line` | spectrum and sine fit; orders when no window is due |
//! | `idle` | 0 | | sleeps, measures the load and the stack |
//!
//! `detect`, `report` and `fit` are interrupts that only software pends. Unlike a spawned task a
//! pended interrupt cannot be lost while its handler runs, so no conversion is left lying in a queue.
//!
//! What is big - ring, estimator, queues - lives in statics from the start.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]
#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::unreachable,
    clippy::todo,
    clippy::unimplemented
)]

#[cfg(all(
    target_os = "none",
    any(all(feature = "stm32f4", feature = "emulated"), all(feature = "feather-f405", feature = "nucleo-f446re"))
))]
compile_error!("choose one board: the feature `feather-f405`, `nucleo-f446re` or `emulated`");
#[cfg(all(target_os = "none", not(any(feature = "stm32f4", feature = "emulated"))))]
compile_error!("choose a board: the feature `feather-f405`, `nucleo-f446re` or `emulated`");

#[cfg(target_os = "none")]
mod board;

/// On a PC there is nothing to run.
#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("This is the firmware; build it for thumbv7em-none-eabihf: cargo xtask firmware");
    std::process::exit(2);
}

#[cfg(target_os = "none")]
#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use crate::board;
    use crate::board::{Board, POWER_UP_US, Reset, Spi, Start, Wait};
    use ads1258::Ads1258;
    use core::hint::black_box;
    use core::mem::MaybeUninit;
    use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
    use embedded_hal::delay::DelayNs;
    use heapless::spsc::{Consumer, Producer, Queue};
    use ridgetone::acquire;
    use ridgetone::acquire::Acquisition;
    use ridgetone::faults::diagnostics::Diagnostics;
    use ridgetone::faults::qualify::qualify;
    use ridgetone::frame::TimedConversion;
    use ridgetone::pipeline::{Detector, Estimator};
    use ridgetone::ring::Ring;
    use ridgetone::tasks::commands::{CommandExecutor, Effect};
    use ridgetone::tasks::liveness::{Liveness, WatchdogPolicy};
    use ridgetone::tasks::load::LoadMeter;
    use ridgetone::tasks::outbox::Outbox;
    use ridgetone::tasks::queues::{PACKETS, SAMPLES, WINDOWS};
    use ridgetone::tasks::stack_depth::DepthMeter;
    use ridgetone::window::Window;
    use ridgetone_proto::boot::Record;
    use ridgetone_proto::command::{REQUEST_WIRE_MAX, Reply, Request};
    use ridgetone_proto::framing::{Inbox, Pushed};
    use ridgetone_proto::store::{FlashStore, Store};
    use ridgetone_proto::telemetry;
    use ridgetone_proto::telemetry::{Event, Span, WIRE_MAX};
    use ridgetone_tone::{FrameSource, Overwritten, Values};
    use rtic::Mutex;
    use stm32f4xx_hal::pac::Interrupt;

    /// Bytes between `report` and `line`: a packet is sent while the next is encoded.
    const BYTES: usize = 640;
    /// With no more than this many bytes waiting the longest packet still fits (a queue holds one
    /// less than its size).
    const LOW_WATER: usize = BYTES - 1 - WIRE_MAX;

    const DRDY: Interrupt = Interrupt::EXTI4;
    const DETECT: Interrupt = Interrupt::CAN1_RX0;
    const REPORT: Interrupt = Interrupt::CAN1_TX;
    const FIT: Interrupt = Interrupt::CAN1_RX1;
    const LINE: Interrupt = Interrupt::USART3;

    defmt::timestamp!("{=u32:us}", board::now_us());

    #[shared]
    struct Shared {
        ring: &'static mut Ring,
        detector: &'static mut Detector,
        inbox: Inbox<REQUEST_WIRE_MAX>,
        outbox: Outbox<PACKETS>,
        diagnostics: Diagnostics,
        liveness: Liveness,
        /// The registers are to be checked with the next conversion.
        check: AtomicBool,
        /// They are to be checked at once.
        urgent: AtomicBool,
        /// Half a second is over: `detect` is to see whether there is anything to tell.
        look: AtomicBool,
        /// The signal is over, and the last window is in its queue.
        finished: AtomicBool,
        /// Bytes are waiting for the line.
        sending: AtomicBool,
        /// The board is to be reset as soon as the line is silent.
        restarting: AtomicBool,
    }

    #[local]
    struct Local {
        estimator: &'static mut Estimator,
        executor: CommandExecutor,
        store: FlashStore<board::SettingsFlash>,
        acquisition: Acquisition<Spi, Start, Reset>,
        drdy: board::Drdy,
        line: board::Line,
        samples_in: Producer<'static, TimedConversion>,
        samples_out: Consumer<'static, TimedConversion>,
        windows_in: Producer<'static, Window>,
        windows_out: Consumer<'static, Window>,
        bytes_in: Producer<'static, u8>,
        bytes_out: Consumer<'static, u8>,
    }

    #[init(local = [
        ring: Ring = Ring::new(),
        samples: Queue<TimedConversion, SAMPLES> = Queue::new(),
        windows: Queue<Window, WINDOWS> = Queue::new(),
        bytes: Queue<u8, BYTES> = Queue::new(),
        // Not with their initial values: those would take their size of flash too.
        detector_place: MaybeUninit<Detector> = MaybeUninit::uninit(),
        estimator_place: MaybeUninit<Estimator> = MaybeUninit::uninit(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let Board { spi, start, reset, drdy, line, boot, flash } = board::init(cx.device, cx.core);
        if let Some(Record { file, line, pc, .. }) = &boot.record {
            defmt::error!("the run before died at {=str}:{=u32}, {=u32:#010x}", file.as_str(), *line, *pc);
        }
        let mut acquisition = Acquisition::new(Ads1258::new(spi), start, reset);
        Wait.delay_us(POWER_UP_US);
        if acquisition.set_up(&mut Wait) {
            defmt::info!("the ADS1258 is set up and scans");
        } else {
            defmt::error!("the ADS1258 does not answer as it should; trying on. Check supply, CLKSEL and wiring");
        }

        let (samples_in, samples_out) = cx.local.samples.split();
        let (windows_in, windows_out) = cx.local.windows.split();
        let (bytes_in, bytes_out) = cx.local.bytes.split();
        let mut store = FlashStore::new(flash);
        let (settings, source) = store.load();
        // The greeting goes out even if the chip is silent.
        rtic::pend(DETECT);
        (
            Shared {
                ring: black_box(cx.local.ring),
                // Not statics with an initial value: that would take their size of flash too.
                detector: put(cx.local.detector_place, || Detector::booted(settings, source, boot)),
                inbox: Inbox::new(),
                outbox: Outbox::new(),
                diagnostics: Diagnostics::new(),
                liveness: Liveness::new(),
                check: AtomicBool::new(false),
                urgent: AtomicBool::new(false),
                look: AtomicBool::new(false),
                finished: AtomicBool::new(false),
                sending: AtomicBool::new(false),
                restarting: AtomicBool::new(false),
            },
            Local {
                estimator: put(cx.local.estimator_place, || Estimator::new(settings)),
                executor: CommandExecutor::new(),
                store,
                acquisition,
                drdy,
                line,
                samples_in,
                samples_out,
                windows_in,
                windows_out,
                bytes_in,
                bytes_out,
            },
        )
    }

    /// Makes what is big in a frame of its own: the first tasks run on top of `init`'s frame, and a processor that never
    /// rests runs all of them there, for good. Where it lies is kept from the compiler, which would otherwise build every
    /// field's address anew instead of counting from where the whole begins: more instructions, and more flash.
    #[inline(never)]
    fn put<T>(place: &mut MaybeUninit<T>, make: impl FnOnce() -> T) -> &mut T {
        black_box(place.write(make()))
    }

    /// DRDY has fallen, or the chip is to be checked.
    #[task(
        binds = EXTI4,
        priority = 5,
        local = [acquisition, drdy, samples_in],
        shared = [&diagnostics, &liveness, &check, &urgent],
    )]
    fn drdy(cx: drdy::Context) {
        let drdy::LocalResources { acquisition, drdy, samples_in, .. } = cx.local;
        let (diagnostics, check) = (cx.shared.diagnostics, cx.shared.check);
        let edge = drdy.acknowledge();
        let verdict = match edge {
            Some(true) => acquisition.edge(|| drdy.edge_us(), samples_in, diagnostics),
            Some(false) => acquisition.nothing(drdy.edge_us(), diagnostics),
            None => acquire::Drdy::Listen,
        };
        match verdict {
            acquire::Drdy::Listen => {}
            acquire::Drdy::Watch => check.store(true, Relaxed),
            acquire::Drdy::Mute => drdy.mute(),
        }
        // Right after a read the next conversion is furthest away.
        let is_time = edge.is_some() || cx.shared.urgent.swap(false, Relaxed) || acquisition.is_quiet(board::now_us());
        if is_time && check.load(Relaxed) {
            check.store(false, Relaxed);
            if !board::ended() {
                acquisition.watch(board::now_us(), diagnostics, &mut Wait);
                drdy.unmute();
            }
        }
        cx.shared.liveness.acquired();
        rtic::pend(DETECT);
    }

    /// Takes a byte if one has come; sends one, or rests.
    #[task(binds = USART3, priority = 4, local = [line, bytes_out], shared = [inbox, &diagnostics, &sending])]
    fn line(mut cx: line::Context) {
        let line::LocalResources { line, bytes_out, .. } = cx.local;
        match line.receive() {
            Some(Ok(byte)) => match cx.shared.inbox.lock(|inbox| inbox.push(byte)) {
                Pushed::More => {}
                Pushed::Whole => rtic::pend(FIT),
                Pushed::Damaged => cx.shared.diagnostics.request_damaged(),
            },
            Some(Err(_)) => cx.shared.inbox.lock(|inbox| inbox.spoil()),
            None => {}
        }
        // Pended by `report` while a byte is on its way: the interrupt will come by itself.
        if !line.ready() {
            return;
        }
        match bytes_out.dequeue() {
            Some(byte) => line.send(byte),
            None => {
                line.rest();
                cx.shared.sending.store(false, Relaxed);
            }
        }
        if bytes_out.len() == LOW_WATER {
            rtic::pend(REPORT);
        }
    }

    /// Frames, contact, windows.
    #[task(
        binds = CAN1_RX0,
        priority = 3,
        local = [samples_out, windows_in, greeted: bool = false],
        shared = [ring, detector, outbox, &diagnostics, &liveness, &check, &look, &finished],
    )]
    fn detect(mut cx: detect::Context) {
        let detect::LocalResources { samples_out, windows_in, greeted, .. } = cx.local;
        let (diagnostics, liveness, check) = (cx.shared.diagnostics, cx.shared.liveness, cx.shared.check);
        let mut emit = |event| post(&mut cx.shared.outbox, diagnostics, event);
        let mut due = |window: Window| {
            // A hop is worth fitting only if the fit keeps up; a whole slide always is.
            let wanted = window.span == Span::Slide || windows_in.is_empty();
            if wanted && windows_in.enqueue(window).is_ok() {
                liveness.fit_due();
            } else {
                diagnostics.hop_skipped();
            }
            // An estimate is told only when the chip is known to have been well until the window's end.
            check.store(true, Relaxed);
            rtic::pend(FIT);
        };

        if !*greeted {
            *greeted = true;
            cx.shared.detector.lock(|detector| emit(detector.hello()));
        }
        while let Some(conversion) = samples_out.dequeue() {
            (&mut cx.shared.detector, &mut cx.shared.ring)
                .lock(|detector, ring| detector.push(conversion, ring, diagnostics, &mut emit, &mut due));
        }
        if cx.shared.look.swap(false, Relaxed) {
            cx.shared.detector.lock(|detector| detector.look(board::now_us(), diagnostics, &mut emit));
        }
        if board::ended() && !cx.shared.finished.load(Relaxed) {
            (&mut cx.shared.detector, &mut cx.shared.ring)
                .lock(|detector, ring| detector.finish(ring, diagnostics, &mut emit, &mut due));
            cx.shared.finished.store(true, Relaxed);
        }
        liveness.detected();
    }

    /// Encodes packets while the line has room.
    #[task(
        binds = CAN1_TX,
        priority = 2,
        local = [bytes_in, wire: [u8; WIRE_MAX] = [0; WIRE_MAX]],
        shared = [outbox, &diagnostics, &sending],
    )]
    fn report(mut cx: report::Context) {
        let report::LocalResources { bytes_in, wire, .. } = cx.local;
        while bytes_in.len() <= LOW_WATER {
            let Some(packet) = cx.shared.outbox.lock(|outbox| outbox.take()) else { break };
            let encoded = telemetry::encode(&packet, wire).ok().and_then(|length| wire.get(..length));
            let Some(encoded) = encoded else {
                cx.shared.diagnostics.message_dropped();
                continue;
            };
            for byte in encoded {
                // There is room: see above.
                let _ = bytes_in.enqueue(*byte);
            }
            // After the bytes: `line`, finding none, takes it back.
            cx.shared.sending.store(true, Relaxed);
            rtic::pend(LINE);
        }
    }

    /// Has the chip checked: with the next conversion, or at once if none is likely to come. Feeds the watchdog, above
    /// `fit`, so that a busy fit does not keep it from being fed.
    #[task(binds = TIM4, priority = 2, local = [watchdog_policy: WatchdogPolicy = WatchdogPolicy::new()], shared = [&check, &look, &liveness])]
    fn watch(cx: watch::Context) {
        board::acknowledge_heartbeat();
        if cx.local.watchdog_policy.feeds(cx.shared.liveness) {
            board::feed_watchdog();
        }
        cx.shared.check.store(true, Relaxed);
        cx.shared.look.store(true, Relaxed);
        rtic::pend(DRDY);
    }

    /// Spectrum and sine fit; then orders, one by one, so that none changes a window that was due before it.
    #[task(
        binds = CAN1_RX1,
        priority = 1,
        local = [estimator, executor, store, windows_out],
        shared = [ring, detector, inbox, outbox, &diagnostics, &liveness, &check, &urgent, &restarting],
    )]
    fn fit(mut cx: fit::Context) {
        let fit::LocalResources { estimator, executor, store, windows_out, .. } = cx.local;
        let diagnostics = cx.shared.diagnostics;
        let mut settled: Option<(Effect, Reply)> = None;
        loop {
            while let Some(window) = windows_out.dequeue() {
                let outcome = estimator.run(&window, &mut Locked(&mut cx.shared.ring), executor.profile());
                cx.shared.liveness.fit_done();
                let estimate = match outcome {
                    Ok(Some(mut estimate)) => {
                        if cx.shared.check.load(Relaxed) {
                            // Not checked yet since the window's end: now, before the next line.
                            cx.shared.urgent.store(true, Relaxed);
                            rtic::pend(DRDY);
                        }
                        qualify(&mut estimate, &window, diagnostics);
                        estimate
                    }
                    Ok(None) => continue,
                    Err(Overwritten) => {
                        diagnostics.hop_skipped();
                        continue;
                    }
                };
                post(&mut cx.shared.outbox, diagnostics, Event::Estimate(estimate));
            }
            if settled.is_none() {
                settled = take_order(&mut cx.shared.inbox, diagnostics).map(|request| {
                    let touched = cx.shared.detector.lock(|detector| detector.is_touched());
                    executor.settle(&request, touched, store)
                });
            }
            let Some((effect, reply)) = &settled else { break };
            let mut emit = |event| post(&mut cx.shared.outbox, diagnostics, event);
            let carried_out = cx.shared.detector.lock(|detector| {
                // While it was settled a window may have fallen due.
                let may = !windows_out.ready();
                if may {
                    executor.carry_out(effect, detector, estimator, &mut emit);
                }
                may
            });
            if carried_out {
                post(&mut cx.shared.outbox, diagnostics, Event::Reply(reply.clone()));
                cx.shared.restarting.store(executor.is_restarting(), Relaxed);
                settled = None;
            }
        }
    }

    /// Sleeps, measures the load, and leaves when all is done.
    #[idle(
        local = [meter: LoadMeter = LoadMeter::new(), depth: DepthMeter = DepthMeter::new()],
        shared = [outbox, &diagnostics, &finished, &sending, &restarting]
    )]
    fn idle(mut cx: idle::Context) -> ! {
        loop {
            // With interrupts masked the processor still wakes up, but serves them only after the
            // clock has been read: the sleep is measured without what follows it.
            let load = cortex_m::interrupt::free(|_| {
                let from_us = board::now_us();
                board::sleep();
                cx.local.meter.slept(from_us, board::now_us())
            });
            if let Some(load) = load {
                cx.shared.diagnostics.set_load(load);
            }
            cx.shared.diagnostics.set_stack(board::look_at_stack(cx.local.depth), board::stack_bytes());
            // Here no interrupt is pending, so no window is being fitted.
            let (finished, restarting) = (cx.shared.finished.load(Relaxed), cx.shared.restarting.load(Relaxed));
            let over = (finished || restarting) && !cx.shared.sending.load(Relaxed);
            if over && cx.shared.outbox.lock(|outbox| outbox.is_empty()) {
                if restarting {
                    // The last two bytes are still on their way, 11 us each.
                    Wait.delay_us(50);
                    board::restart();
                }
                board::leave();
            }
        }
    }

    /// The order that has come, if it is as it was sent.
    #[inline(never)]
    fn take_order(inbox: &mut impl Mutex<T = Inbox<REQUEST_WIRE_MAX>>, diagnostics: &Diagnostics) -> Option<Request> {
        let mut frame = inbox.lock(|inbox| inbox.take())?;
        let request = Request::decode(&mut frame);
        if request.is_none() {
            diagnostics.request_damaged();
        }
        request
    }

    /// Hands an event to `report`.
    #[inline(never)]
    fn post(outbox: &mut impl Mutex<T = Outbox<PACKETS>>, diagnostics: &Diagnostics, event: Event) {
        if outbox.lock(|outbox| outbox.post(event)) {
            diagnostics.message_dropped();
        }
        rtic::pend(REPORT);
    }

    /// The ring behind its lock: `detect` waits no longer than one read.
    struct Locked<'a, M>(&'a mut M);

    impl<M: Mutex<T = &'static mut Ring>> FrameSource for Locked<'_, M> {
        fn read(
            &mut self,
            first: u32,
            most: usize,
            show: &mut dyn FnMut(&[Values], &[u16]),
        ) -> Result<(), Overwritten> {
            self.0.lock(|ring| ring.read(first, most, show).ok_or(Overwritten))
        }
    }
}
