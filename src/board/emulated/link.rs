//! The bridge's firmware end: records to the simulated chip, and the alarm that stands for DRDY.
//!
//! Every reply holds the time of DRDY's next edge. SysTick, which can be set for one shot, pends
//! EXTI4 then, as the pin would. While no edge is known the chip is polled every [`POLL_US`].

use super::kept::KEPT;
use super::log;
use super::semihost::{self, Exit, File, Mode};
use crate::board::clock::now_us;
use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use cortex_m_rt::exception;
use critical_section::Mutex;
use hal_mock::bridge::{
    Crash, NEVER, Operation, PAYLOAD_MAX, REPLY_BYTES, REQUEST_BYTES, Reply, Request,
};
use ridgetone_finger::tasks::DrdyPin;
use ridgetone_finger::tasks::WATCHDOG_S;
use ridgetone_proto::boot::ResetCause;
use stm32f4xx_hal::pac::{Interrupt, NVIC};

/// From one poll of the chip to the next, microseconds.
const POLL_US: u32 = 10_000;

/// SysTick counts the emulated processor's clock, 168 MHz whatever `-icount` says.
const TICKS_PER_US: u32 = 168;

/// Period of the interrupt TIM4, microseconds: half a second, as on the board.
const HEARTBEAT_US: u32 = 500_000;

/// Period of the watchdog, microseconds.
const WATCHDOG_US: u32 = WATCHDOG_S * 1_000_000;

static LINK: Mutex<RefCell<Option<Link>>> = Mutex::new(RefCell::new(None));
static ENDED: AtomicBool = AtomicBool::new(false);
static LINE_BLOCKED: AtomicBool = AtomicBool::new(false);

/// Time of a byte on the line, microseconds: 10 bits at 921,600 baud. The emulator's transmitter
/// takes none.
const BYTE_US: u32 = 11;

/// Bytes that the line can have taken by the time of the latest exchange, and whether one waits for
/// the next exchange.
static LINE_BYTES: AtomicU32 = AtomicU32::new(0);
static LINE_WAITS: AtomicBool = AtomicBool::new(false);

/// The PC has requested a crash: after it the board resets instead of leaving.
static RESTARTS: AtomicBool = AtomicBool::new(false);

/// When the watchdog was fed last. The emulator has none; the link checks the time with every
/// exchange.
static FED_US: AtomicU32 = AtomicU32::new(0);

struct Link {
    alarm: SYST,
    /// Whether the alarm is set to an edge of DRDY, not to the next poll.
    edge_ahead: bool,
    /// DRDY has fallen, and its data were not read yet.
    edge_pending: bool,
    /// Edges are ignored.
    muted: bool,
    /// The chip's time of the latest edge.
    edge_us: u32,
    /// When TIM4 was pended last.
    heartbeat_us: u32,
    /// Up to when the line's time is given to bytes.
    line_us: u32,
}

/// Opens the log and the two FIFOs `spi.request` and `spi.reply` in the emulator's working
/// directory, if a reset has not kept them, and takes SysTick for the alarm. Waits until the PC has
/// opened its ends.
pub fn open(mut alarm: SYST, are_kept: bool) {
    alarm.set_clock_source(SystClkSource::Core);
    alarm.enable_interrupt();
    if !are_kept {
        // First: when the bridge is open, the PC removes their names.
        log::open();
        let files =
            File::open(c"spi.request", Mode::Write).zip(File::open(c"spi.reply", Mode::Read));
        let Some((request, reply)) = files else {
            semihost::print(format_args!("cannot open spi.request and spi.reply"));
            semihost::exit(Exit::Bridge)
        };
        KEPT.request.store(request.0, Relaxed);
        KEPT.reply.store(reply.0, Relaxed);
    }
    let now_us = now_us();
    FED_US.store(now_us, Relaxed);
    let (edge_ahead, edge_pending, muted) = (false, false, false);
    let link = Link {
        alarm,
        edge_ahead,
        edge_pending,
        muted,
        edge_us: 0,
        heartbeat_us: now_us,
        line_us: now_us,
    };
    // Not borrowed yet.
    let _ = critical_section::with(|cs| {
        LINK.borrow(cs)
            .try_borrow_mut()
            .map(|mut place| *place = Some(link))
    });
}

/// Puts off the reset by the watchdog.
pub fn feed_watchdog() {
    FED_US.store(now_us(), Relaxed);
}

/// Resets the processor; the bridge and the time go on.
pub fn restart(cause: ResetCause) -> ! {
    KEPT.put(now_us(), cause);
    SCB::sys_reset()
}

/// Crashes if the PC has requested it.
pub fn restart_if_requested(cause: ResetCause) {
    if RESTARTS.load(Relaxed) {
        restart(cause);
    }
}

fn crash_as_requested(crash: Crash) {
    RESTARTS.store(true, Relaxed);
    match crash {
        #[allow(clippy::panic)]
        Crash::Panic => panic!("as the PC has requested"),
        Crash::HardFault => cortex_m::asm::udf(),
        Crash::StackOverflow => {
            deepen(0);
        }
        Crash::Hang => NVIC::mask(Interrupt::OTG_HS_EP1_OUT),
        Crash::Restart => restart(ResetCause::Software),
    }
}

/// Takes 256 bytes of the stack, again and again.
#[allow(unconditional_recursion)]
fn deepen(depth: u32) -> u32 {
    let bytes = core::hint::black_box([depth; 64]);
    deepen(depth.wrapping_add(1)).wrapping_add(core::hint::black_box(bytes)[0])
}

/// Does something to the chip. A transfer's payload is replaced by what DOUT carries.
pub fn exchange(operation: Operation, level: bool, payload: &mut [u8]) {
    with_link(|link| {
        // The last result too may be read more than once.
        if !ended() || operation == Operation::Transfer {
            link.exchange(operation, level, payload);
        }
    });
}

/// The falling edge of DRDY.
pub struct Drdy;

impl DrdyPin for Drdy {
    #[inline(always)]
    fn acknowledge(&mut self) -> Option<bool> {
        with_link(|link| core::mem::take(&mut link.edge_pending)).then_some(true)
    }

    /// The chip's own time of the edge: it does not depend on the speed of the emulated processor.
    fn edge_us(&self) -> u32 {
        with_link(|link| link.edge_us)
    }

    fn mute(&mut self) {
        with_link(|link| link.muted = true);
    }

    fn unmute(&mut self) {
        with_link(|link| link.muted = false);
    }
}

/// Whether the scene is over. From then on only the last result is read.
pub fn ended() -> bool {
    ENDED.load(Relaxed)
}

/// Whether the telemetry line takes no more bytes. When it does again, USART3 is pended.
pub fn is_line_blocked() -> bool {
    let is_full = LINE_BYTES.load(Relaxed) == 0;
    if is_full {
        LINE_WAITS.store(true, Relaxed);
    }
    is_full || LINE_BLOCKED.load(Relaxed)
}

/// A byte is on the line.
pub fn take_line_byte() {
    LINE_BYTES.store(LINE_BYTES.load(Relaxed).saturating_sub(1), Relaxed);
}

fn with_link<R: Default>(action: impl FnOnce(&mut Link) -> R) -> R {
    critical_section::with(|cs| {
        // Never borrowed twice: everything here runs with interrupts masked and calls nothing back.
        let mut link = LINK.borrow(cs).try_borrow_mut().ok();
        link.as_deref_mut()
            .and_then(Option::as_mut)
            .map(action)
            .unwrap_or_default()
    })
}

impl Link {
    fn exchange(&mut self, operation: Operation, level: bool, payload: &mut [u8]) {
        let now_us = now_us();
        let request = Request {
            operation,
            level,
            length: payload.len() as u8,
            now_us,
        };
        let Some(reply) = carry(&request, payload) else {
            semihost::print(format_args!(
                "the bridge to the simulated chip broke at {now_us} us"
            ));
            semihost::exit(Exit::Bridge)
        };
        self.edge_us = reply.drdy_us;
        if now_us.wrapping_sub(self.heartbeat_us) >= HEARTBEAT_US {
            self.heartbeat_us = now_us;
            NVIC::pend(Interrupt::TIM4);
        }
        // The line's time passes between two exchanges, and is not saved up.
        let bytes = now_us.wrapping_sub(self.line_us) / BYTE_US;
        if bytes > 0 || reply.ended {
            self.line_us = self.line_us.wrapping_add(bytes.wrapping_mul(BYTE_US));
            LINE_BYTES.store(if reply.ended { u32::MAX } else { bytes }, Relaxed);
            if LINE_WAITS.swap(false, Relaxed) {
                NVIC::pend(Interrupt::USART3);
            }
        }
        if now_us.wrapping_sub(FED_US.load(Relaxed)) >= WATCHDOG_US {
            restart_if_requested(ResetCause::Watchdog);
            semihost::print(format_args!(
                "the watchdog bit at {now_us} us: a task stood still"
            ));
            semihost::exit(Exit::Watchdog);
        }
        if let Some(crash) = reply.crash {
            crash_as_requested(crash);
        }
        if reply.ended {
            ENDED.store(true, Relaxed);
        }
        if LINE_BLOCKED.swap(reply.line_blocked, Relaxed) && !reply.line_blocked {
            NVIC::pend(Interrupt::USART3);
        }
        // A transfer takes the data away; after anything else a low DRDY is an edge not yet served.
        if !reply.drdy_high && operation != Operation::Transfer && !self.muted {
            self.edge();
        }
        if reply.ended {
            NVIC::pend(Interrupt::EXTI4);
        }
        self.edge_ahead = reply.next_drdy_us <= POLL_US;
        self.arm(if reply.next_drdy_us == NEVER {
            POLL_US
        } else {
            reply.next_drdy_us.min(POLL_US)
        });
    }

    /// Sets the alarm, one microsecond later: it must not ring before the edge.
    fn arm(&mut self, delay_us: u32) {
        self.alarm.disable_counter();
        self.alarm
            .set_reload(delay_us.saturating_add(1).saturating_mul(TICKS_PER_US));
        self.alarm.clear_current();
        // An alarm that has rung meanwhile belongs to the past.
        SCB::clear_pendst();
        self.alarm.enable_counter();
        while SYST::get_current() == 0 {}
        // Loaded; a reload value of zero stops the counter when it gets there. It must not start
        // over: while the processor sleeps, the emulator would then skip two periods instead of
        // one.
        self.alarm.set_reload(0);
    }

    fn edge(&mut self) {
        self.edge_pending = true;
        NVIC::pend(Interrupt::EXTI4);
    }

    fn ring(&mut self) {
        self.alarm.disable_counter();
        if ended() {
            // The chip is not polled any more; the idle task still wakes up by this.
            self.arm(POLL_US);
        } else if self.edge_ahead && !self.muted {
            self.edge_ahead = false;
            self.edge();
        } else {
            self.exchange(Operation::Poll, false, &mut []);
        }
    }
}

/// Sends a request over the bridge's two files; the reply's payload replaces the request's.
fn carry(request: &Request, payload: &mut [u8]) -> Option<Reply> {
    let mut record = [0; REQUEST_BYTES + PAYLOAD_MAX];
    let (header, rest) = record.split_first_chunk_mut::<REQUEST_BYTES>()?;
    *header = request.encode();
    rest.get_mut(..payload.len())?.copy_from_slice(payload);
    let sent =
        File(KEPT.request.load(Relaxed)).write_all(record.get(..REQUEST_BYTES + payload.len())?);

    let mut record = [0; REPLY_BYTES + PAYLOAD_MAX];
    let answer = record.get_mut(..REPLY_BYTES + payload.len())?;
    if !sent || !File(KEPT.reply.load(Relaxed)).read_exact(answer) {
        return None;
    }
    let (header, received) = answer.split_first_chunk::<REPLY_BYTES>()?;
    payload.copy_from_slice(received);
    Reply::decode(header).filter(|reply| reply.length == request.length)
}

#[exception]
fn SysTick() {
    with_link(Link::ring);
}
