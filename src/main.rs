//! The firmware: binds the tasks of [`ridgetone_finger::tasks`] to interrupts, and locks what they
//! share. The board's file maps each task to an interrupt of its chip.
//!
//! | task | priority | runs |
//! |---|---|---|
//! | `line` | 5 | transmitter empty, or reception pauses (USART idle); pended by `report` |
//! | `drdy` | 4 | DRDY's falling edge, or the end of a frame; pended by `watch` and `fit` |
//! | `detect` | 3 | pended by `drdy` when a scan is over or interrupted |
//! | `report` | 2 | receive buffer (DMA) half full or full; pended by `detect`, `fit` and `line` |
//! | `watch` | 2 | TIM4, twice a second |
//! | `fit` | 1 | pended by `detect` and `report` |
//! | `idle` | 0 | |
//!
//! `line` is above `drdy` because it is short, and a byte of telemetry takes 10.9 us, while `drdy`
//! runs for 15 to 48 us. Requests can wait in the DMA's buffer for at least 1.4 ms.
//!
//! Only software pends `detect`, `report` and `fit`. Unlike a spawn of a task that is already
//! queued, pending an interrupt while its handler runs is not lost, so no conversion is left
//! waiting in a queue.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::unreachable, clippy::todo, clippy::unimplemented)]

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod log;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("This is the firmware. `cargo feather` and `cargo nucleo` flash a board with it");
    std::process::exit(2);
}

#[cfg(target_os = "none")]
#[rtic::app(device = crate::board::device, peripherals = true)]
mod app {
    use crate::board;
    use crate::board::device::Interrupt;
    use crate::board::{Board, Converter, POWER_UP_US, Wait};
    use core::hint::black_box;
    use embedded_hal::delay::DelayNs;
    use heapless::spsc::Queue;
    use ridgetone_finger::Acquisition;
    use ridgetone_finger::Detector;
    use ridgetone_finger::Estimator;
    use ridgetone_finger::Ring;
    use ridgetone_finger::SampleQueue;
    use ridgetone_finger::Window;
    use ridgetone_finger::converter::Converter as _;
    use ridgetone_finger::tasks::Detect;
    use ridgetone_finger::tasks::Drdy;
    use ridgetone_finger::tasks::Fit;
    use ridgetone_finger::tasks::Report;
    use ridgetone_finger::tasks::Requests;
    use ridgetone_finger::tasks::WatchdogPolicy;
    use ridgetone_finger::tasks::{BYTES, Platform, Samples, Shared, Task, WINDOWS};
    use ridgetone_finger::tasks::{Idle, Next, Slept, Stack};
    use ridgetone_finger::tasks::{Mail, Outbox};
    use ridgetone_finger::tasks::{RequestInbox, SerialLine, receive_all};
    use ridgetone_proto::boot::Record;
    use ridgetone_proto::settings::Settings;
    use ridgetone_proto::store::{FlashStore, Store};
    use ridgetone_proto::telemetry::Headline;
    use ridgetone_tone::Fitter;

    defmt::timestamp!("{=u32:us}", board::now_us());

    /// The platform: RTIC runs the tasks.
    pub struct Rtic;

    impl Platform for Rtic {
        #[inline(always)]
        fn pend(_: &Shared<Self>, task: Task) {
            rtic::pend(match task {
                Task::Drdy => Interrupt::DRDY,
                Task::SerialLine => Interrupt::LINE,
                Task::Detect => Interrupt::DETECT,
                Task::Report => Interrupt::REPORT,
                Task::Fit => Interrupt::FIT,
            });
        }

        #[inline(always)]
        fn now_us(&self) -> u32 {
            board::now_us()
        }

        fn has_ended(&self) -> bool {
            false
        }

        fn log(&self, headline: Headline) {
            crate::log::log(headline);
        }
    }

    #[shared]
    struct Resources {
        ring: &'static mut Ring,
        detector: &'static mut Detector,
        inbox: RequestInbox,
        outbox: Outbox,
        shared: Shared<Rtic>,
    }

    #[local]
    struct Local {
        drdy: Drdy<'static, Converter, board::Drdy>,
        line: SerialLine<'static, board::SerialLine>,
        receiver: board::LineReceiver,
        detect: Detect<'static>,
        report: Report<'static>,
        fit: Fit<'static, FlashStore<board::SettingsFlash>>,
    }

    #[init(local = [
        ring: Ring = Ring::new(),
        samples: Samples = Samples::new(),
        windows: Queue<Window, WINDOWS> = Queue::new(),
        bytes: Queue<u8, BYTES> = Queue::new(),
        detector: Detector = Detector::wired(Settings::DEFAULT, board::WIRING),
        fitter: Fitter = Fitter::new(),
    ])]
    fn init(cx: init::Context) -> (Resources, Local) {
        let Board {
            converter,
            drdy,
            line: (line, receiver),
            boot,
            flash,
        } = board::init(cx.device, cx.core);
        if let Some(Record { file, line, pc, .. }) = &boot.record {
            defmt::error!(
                "the run before died at {=str}:{=u32}, {=u32:#010x}",
                file.as_str(),
                *line,
                *pc
            );
        }
        // Load settings before the chip scans: searching blank sectors takes milliseconds, and
        // would lose conversions.
        let mut store = FlashStore::new(flash);
        let (settings, source) = store.load();
        let settings = board::WIRING.converter.fitting(settings);
        // Hide the addresses from the compiler, which would otherwise rebuild the address of every
        // field, at a cost of 3 kB of flash and 1 % of the instructions.
        let ring = black_box(cx.local.ring);
        let detector = black_box(cx.local.detector);
        let fitter = black_box(cx.local.fitter);
        detector.boot(settings, source, boot);
        let shared = Shared::new(Rtic, settings.plan);
        let mut acquisition = Acquisition::new(converter, settings.plan);
        // Wait for the rest of the power-up time: the counter started with the clocks.
        Wait.delay_us(POWER_UP_US.saturating_sub(board::now_us()));
        if acquisition.set_up(&shared.diagnostics, &mut Wait) {
            defmt::info!("the {=str} is set up and scans", Converter::NAME);
        } else {
            defmt::error!(
                "the {=str} does not answer as it should; trying on. Check supply, clock and wiring",
                Converter::NAME
            );
        }

        let samples: &'static SampleQueue = cx.local.samples;
        let (windows_in, windows_out) = cx.local.windows.split();
        let (bytes_in, bytes_out) = cx.local.bytes.split();
        // The greeting is sent even if the chip is silent.
        rtic::pend(Interrupt::DETECT);
        (
            Resources {
                ring,
                detector,
                inbox: RequestInbox::new(),
                outbox: Outbox::new(),
                shared,
            },
            Local {
                drdy: Drdy::new(acquisition, drdy, samples),
                line: SerialLine {
                    port: line,
                    bytes: bytes_out,
                },
                receiver,
                detect: Detect::new(samples, windows_in),
                report: Report::new(bytes_in),
                fit: Fit {
                    estimator: Estimator::new(settings),
                    fitter,
                    windows: windows_out,
                    requests: Requests::new(store),
                },
            },
        )
    }

    #[task(binds = LINE, priority = 5, local = [line], shared = [&shared])]
    fn line(cx: line::Context) {
        cx.local.line.run(cx.shared.shared);
    }

    #[task(binds = DRDY, priority = 4, local = [drdy], shared = [&shared])]
    fn drdy(cx: drdy::Context) {
        cx.local.drdy.run(cx.shared.shared, &mut Wait);
    }

    // No higher-priority task takes these locks, so they mask nothing.
    #[task(binds = DETECT, priority = 3, local = [detect], shared = [ring, detector, outbox, &shared])]
    fn detect(cx: detect::Context) {
        let detect::SharedResources {
            ring,
            detector,
            outbox,
            shared,
            ..
        } = cx.shared;
        let detect = cx.local.detect;
        (ring, detector, outbox).lock(|ring, detector, outbox| {
            detect.run(detector, ring, outbox, shared);
        });
    }

    #[task(binds = REPORT, priority = 2, local = [receiver, report], shared = [inbox, outbox, &shared])]
    fn report(mut cx: report::Context) {
        receive_all(cx.local.receiver, &mut cx.shared.inbox, cx.shared.shared);
        cx.local.report.run(&mut cx.shared.outbox, cx.shared.shared);
    }

    #[task(binds = TIM4, priority = 2, local = [policy: WatchdogPolicy = WatchdogPolicy::new()], shared = [&shared])]
    fn watch(cx: watch::Context) {
        board::acknowledge_heartbeat();
        if cx.local.policy.run(cx.shared.shared) {
            board::feed_watchdog();
        }
    }

    #[task(binds = FIT, priority = 1, local = [fit], shared = [ring, detector, inbox, outbox, &shared])]
    fn fit(cx: fit::Context) {
        let fit::SharedResources {
            mut ring,
            mut detector,
            mut inbox,
            mut outbox,
            shared,
            ..
        } = cx.shared;
        let mail = Mail {
            inbox: &mut inbox,
            outbox: &mut outbox,
        };
        cx.local.fit.run(&mut ring, &mut detector, mail, shared);
    }

    #[idle(local = [idle: Idle = Idle::new()], shared = [outbox, &shared])]
    fn idle(mut cx: idle::Context) -> ! {
        loop {
            // With interrupts masked the processor still wakes up, but serves them only after the
            // clock has been read. So the measured sleep excludes the interrupt that ends it.
            let slept = cortex_m::interrupt::free(|_| {
                let from_us = board::now_us();
                board::sleep();
                Slept {
                    from_us,
                    until_us: board::now_us(),
                }
            });
            let stack = Stack {
                words: board::stack_words(),
                word: board::stack_word,
            };
            let outbox = &mut cx.shared.outbox;
            match cx.local.idle.run(slept, stack, outbox, cx.shared.shared) {
                Next::Sleep => {}
                Next::Restart => {
                    // Let the last two bytes leave: 11 us each.
                    Wait.delay_us(50);
                    board::restart();
                }
                // Only a simulated signal ends.
                Next::Leave => {}
            }
        }
    }
}
