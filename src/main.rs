//! The firmware: an RTIC app of four tasks, no arithmetic.
//!
//! | task | priority | interrupt | does |
//! |---|---|---|---|
//! | `drdy` | 5 | EXTI4, DRDY's falling edge | reads one conversion, queues it |
//! | `line` | 4 | USART3, transmitter empty | sends one byte of telemetry |
//! | `detect` | 3 | CAN1_RX0, pended by `drdy` | frames, contact, windows |
//! | `report` | 2 | CAN1_TX, pended by whoever has news | encodes packets |
//! | `fit` | 1 | CAN1_RX1, pended by `detect` | spectrum and sine fit |
//! | `idle` | 0 | | sleeps and measures the load |
//!
//! `detect`, `report` and `fit` are interrupts that only software pends. Unlike a spawned task a
//! pended interrupt cannot be lost while its handler runs, so no conversion is left lying in a queue.
//!
//! What is big lives in statics from the start: nothing of the kind is ever built on the stack.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(all(target_os = "none", feature = "feather-f405", feature = "emulated"))]
compile_error!("choose one board: the feature `feather-f405` or the feature `emulated`, not both");
#[cfg(all(target_os = "none", not(any(feature = "feather-f405", feature = "emulated"))))]
compile_error!("choose a board: the feature `feather-f405` or the feature `emulated`");

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod load;
#[cfg(target_os = "none")]
mod outbox;
#[cfg(target_os = "none")]
mod tally;
#[cfg(target_os = "none")]
use ridgetone::{pipeline, telemetry};

/// On a PC there is nothing to run.
#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("This is the firmware; build it for thumbv7em-none-eabihf: cargo xtask firmware");
    std::process::exit(2);
}

#[cfg(target_os = "none")]
#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use crate::board::{self, Board};
    use crate::load::LoadMeter;
    use crate::outbox::Outbox;
    use crate::tally::Tally;
    use ads1258::{Ads1258, Config};
    use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
    use heapless::spsc::{Consumer, Producer, Queue};
    use ridgetone::frame::TimedConversion;
    use ridgetone::pipeline::{Detector, Estimator};
    use ridgetone::settings::{Settings, SlideRule};
    use ridgetone::telemetry::{self, Event, Span, WIRE_MAX};
    use ridgetone::window::{FrameSource, Ring, Window};
    use rtic::Mutex;
    use stm32f4xx_hal::pac::Interrupt;

    const SETTINGS: Settings =
        Settings { window_s: 1.0, hop_s: 0.25, harmonics: 3, vref_v: 4.096, slide: SlideRule::Found };

    /// Conversions between `drdy` and `detect`: 25 ms of them at 5064 a second.
    const SAMPLES: usize = 128;
    /// Windows between `detect` and `fit`: one hop may wait, the other places are for whole slides.
    const WINDOWS: usize = 4;
    /// Packets between `detect`, `fit` and `report`.
    const PACKETS: usize = 8;
    /// Bytes between `report` and `line`: a packet is sent while the next is encoded.
    const BYTES: usize = 1024;
    /// With no more than this many bytes waiting the longest packet still fits (a queue holds one
    /// less than its size).
    const LOW_WATER: usize = BYTES - 1 - WIRE_MAX;
    /// How often the chip is asked to answer before the firmware gives up on it.
    const SETUP_ATTEMPTS: u32 = 10;

    const DETECT: Interrupt = Interrupt::CAN1_RX0;
    const REPORT: Interrupt = Interrupt::CAN1_TX;
    const FIT: Interrupt = Interrupt::CAN1_RX1;
    const LINE: Interrupt = Interrupt::USART3;

    defmt::timestamp!("{=u32:us}", board::now_us());

    #[shared]
    struct Shared {
        ring: &'static mut Ring,
        outbox: Outbox<PACKETS>,
        tally: Tally,
        /// The signal is over and the last window is in the queue.
        finished: AtomicBool,
        /// Bytes are waiting for the line.
        sending: AtomicBool,
    }

    #[local]
    struct Local {
        adc: Ads1258<Spi>,
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
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let Board { spi, mut start, mut reset, drdy, line } = board::init(cx.device, cx.core);
        let mut adc = Ads1258::new(spi);
        set_up(&mut adc, &mut start, &mut reset);

        let (samples_in, samples_out) = cx.local.samples.split();
        let (windows_in, windows_out) = cx.local.windows.split();
        let (bytes_in, bytes_out) = cx.local.bytes.split();
        // The greeting goes out even if the chip does not answer.
        rtic::pend(DETECT);
        (
            Shared {
                ring: cx.local.ring,
                outbox: Outbox::new(),
                tally: Tally::new(),
                finished: AtomicBool::new(false),
                sending: AtomicBool::new(false),
            },
            Local { adc, drdy, line, samples_in, samples_out, windows_in, windows_out, bytes_in, bytes_out },
        )
    }
}
