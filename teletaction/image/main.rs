//! The stylus's firmware: connects the decisions of [`ridgetone_stylus`] and the finger's line to
//! interrupts.
//!
//! | task | priority | interrupt |
//! |---|---|---|
//! | `line` | 5 | USART3, transmitter empty or line idle; pended by `report` |
//! | `sample` | 4 | TIM6, 10,000 times a second |
//! | `report` | 2 | OTG_HS_EP1_IN, pended by `requests`, `line` and the line's DMA (half buffer) |
//! | `watch` | 2 | TIM4, twice a second |
//! | `requests` | 1 | OTG_HS_WKUP, pended by `report`, and by `sample` every 4 ms |
//! | `idle` | 0 | |
//!
//! `line` is above `sample` because it is short and a byte of telemetry lasts 10.9 us. The
//! converter outputs a sample when its timer triggers, so delaying `sample` by nearly a period has
//! no effect.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::unreachable, clippy::todo, clippy::unimplemented)]

#[cfg(target_os = "none")]
mod board;

/// The firmware does not run on a PC.
#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("This is the stylus's firmware; build it: cargo xtask firmware --board stylus-f405");
    std::process::exit(2);
}

#[cfg(target_os = "none")]
#[rtic::app(device = crate::board::device, peripherals = true)]
mod app {
    use crate::board;
    use crate::board::device::Interrupt;
    use crate::board::{Board, Samples};
    use heapless::spsc::Queue;
    use ridgetone_finger::tasks::Outbox;
    use ridgetone_finger::tasks::Report;
    use ridgetone_finger::tasks::WatchdogPolicy;
    use ridgetone_finger::tasks::{BYTES, Platform, Shared, Task};
    use ridgetone_finger::tasks::{Idle, Next, Slept, Stack};
    use ridgetone_finger::tasks::{RequestInbox, SerialLine, receive_all};
    use ridgetone_proto::boot::Record;
    use ridgetone_proto::plan::Plan;
    use ridgetone_teletaction::stylus::message::{Event, Mark};
    use ridgetone_teletaction::stylus::reports::Reports;
    use ridgetone_teletaction::stylus::sampler::Sampler;

    defmt::timestamp!("{=u32:us}", board::now_us());

    /// RTIC runs the tasks.
    pub struct Rtic;

    impl Platform for Rtic {
        #[inline(always)]
        fn pend(_: &Shared<Self>, task: Task) {
            rtic::pend(match task {
                Task::SerialLine => Interrupt::LINE,
                Task::Report => Interrupt::REPORT,
                // A complete request: `fit` handles it in the finger, `requests` here.
                Task::Fit => Interrupt::REQUESTS,
                // Tasks of the finger only.
                Task::Drdy | Task::Detect => return,
            });
        }

        #[inline(always)]
        fn now_us(&self) -> u32 {
            board::now_us()
        }

        fn has_ended(&self) -> bool {
            false
        }
    }

    #[shared]
    struct Resources {
        sampler: Sampler,
        inbox: RequestInbox,
        outbox: Outbox<Mark<Event>>,
        shared: Shared<Rtic>,
    }

    #[local]
    struct Local {
        samples: Samples,
        line: SerialLine<'static, board::SerialLine>,
        receiver: board::LineReceiver,
        report: Report<'static>,
        reports: Reports,
    }

    #[init(local = [bytes: Queue<u8, BYTES> = Queue::new()])]
    fn init(cx: init::Context) -> (Resources, Local) {
        let Board {
            samples,
            line: (line, receiver),
            boot,
        } = board::init(cx.device);
        if let Some(Record { file, line, pc, .. }) = &boot.record {
            defmt::error!(
                "the run before died at {=str}:{=u32}, {=u32:#010x}",
                file.as_str(),
                *line,
                *pc
            );
        }
        let (bytes_in, bytes_out) = cx.local.bytes.split();
        (
            Resources {
                sampler: Sampler::new(),
                inbox: RequestInbox::new(),
                outbox: Outbox::new(),
                // The plan is unused, because a stylus does not scan.
                shared: Shared::new(Rtic, Plan::PAPER),
            },
            Local {
                samples,
                line: SerialLine {
                    port: line,
                    bytes: bytes_out,
                },
                receiver,
                report: Report::new(bytes_in),
                reports: Reports::new(boot),
            },
        )
    }

    #[task(binds = LINE, priority = 5, local = [line], shared = [&shared])]
    fn line(cx: line::Context) {
        cx.local.line.run(cx.shared.shared);
    }

    // No task of higher priority takes this lock, so locking masks nothing.
    #[task(binds = SAMPLE, priority = 4, local = [samples], shared = [sampler])]
    fn sample(mut cx: sample::Context) {
        let (counter, now_us, late_us) = cx.local.samples.read();
        let is_due = cx.shared.sampler.lock(|sampler| {
            let code = sampler.next(now_us, late_us, counter);
            sampler.written(cx.local.samples.write(code))
        });
        if is_due {
            rtic::pend(Interrupt::REQUESTS);
        }
    }

    #[task(binds = REPORT, priority = 2, local = [receiver, report], shared = [inbox, outbox, &shared])]
    fn report(mut cx: report::Context) {
        receive_all(cx.local.receiver, &mut cx.shared.inbox, cx.shared.shared);
        cx.local.report.run(&mut cx.shared.outbox, cx.shared.shared);
    }

    #[task(binds = TIM4, priority = 2, local = [policy: WatchdogPolicy = WatchdogPolicy::new()], shared = [&shared])]
    fn watch(cx: watch::Context) {
        board::acknowledge_heartbeat();
        if cx.local.policy.feeds(&cx.shared.shared.liveness) {
            board::feed_watchdog();
        }
    }

    #[task(binds = REQUESTS, priority = 1, local = [reports], shared = [sampler, inbox, outbox, &shared])]
    fn requests(cx: requests::Context) {
        let requests::SharedResources {
            mut sampler,
            mut inbox,
            mut outbox,
            shared,
            ..
        } = cx.shared;
        cx.local
            .reports
            .run(&mut sampler, &mut inbox, &mut outbox, shared);
    }

    #[idle(local = [idle: Idle = Idle::new()], shared = [outbox, &shared])]
    fn idle(mut cx: idle::Context) -> ! {
        loop {
            // Masked for the reason given in the finger's `idle`.
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
                    // The last two bytes take 11 us each.
                    cortex_m::asm::delay(10_000);
                    board::restart();
                }
                // Only simulated signals end.
                Next::Leave => {}
            }
        }
    }
}
