//! The chip on a bench: its pins as embedded-hal 1.0 traits on one shared virtual clock.

mod bus;
mod pins;

pub use bus::RigSpi;
pub use pins::{DrdyPin, ResetPin, RigDelay, StartPin};

use crate::chip::{Ads1258, Options};
use crate::scene::Scene;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A simulated chip and the virtual clock that all its pins share. Clones are handles to the same one.
#[derive(Clone)]
pub struct Rig {
    bench: Arc<Mutex<Bench>>,
}

/// The shared state behind every handle.
pub(crate) struct Bench {
    pub(crate) chip: Ads1258,
    pub(crate) now_ns: u64,
    /// 0: SPI bytes take no time.
    pub(crate) sclk_hz: u32,
    pub(crate) read_fill: u8,
    pub(crate) poll_ns: u64,
}

impl Bench {
    pub(crate) fn advance_by(&mut self, ns: u64) {
        self.now_ns = self.now_ns.saturating_add(ns);
        self.chip.advance_to(self.now_ns);
    }
}

impl Rig {
    /// A chip in its power-up state in front of `scene`, at time 0.
    pub fn new(scene: impl Scene + 'static, options: Options) -> Self {
        let chip = Ads1258::new(Box::new(scene), options);
        Self { bench: Arc::new(Mutex::new(Bench { chip, now_ns: 0, sclk_hz: 0, read_fill: 0x00, poll_ns: 0 })) }
    }

    pub(crate) fn lock(&self) -> MutexGuard<'_, Bench> {
        // A panic in a test elsewhere leaves the state whole: every change is complete before anything can panic.
        self.bench.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The SPI bus with the chip's CS.
    pub fn spi(&self) -> RigSpi {
        RigSpi::new(self.clone())
    }

    /// The START pin, low at first.
    pub fn start_pin(&self) -> StartPin {
        StartPin::new(self.clone())
    }

    /// The RESET pin, high at first.
    pub fn reset_pin(&self) -> ResetPin {
        ResetPin::new(self.clone())
    }

    /// The DRDY pin.
    pub fn drdy_pin(&self) -> DrdyPin {
        DrdyPin::new(self.clone())
    }

    /// Delays that advance the virtual clock.
    pub fn delay(&self) -> RigDelay {
        RigDelay::new(self.clone())
    }

    /// SCLK in hertz: each SPI byte takes 8 of its cycles (rounded down to nanoseconds). 0, the default: no time.
    pub fn set_sclk_hz(&self, sclk_hz: u32) {
        self.lock().sclk_hz = sclk_hz;
    }

    /// What DIN carries while a driver only reads; embedded-hal leaves it to the implementation. Default 00h.
    pub fn set_read_fill(&self, byte: u8) {
        self.lock().read_fill = byte;
    }

    /// Nanoseconds that each look at the DRDY pin takes, after it. Default 0; a driver that polls without a delay
    /// needs more, or virtual time stands still.
    pub fn set_poll_ns(&self, ns: u64) {
        self.lock().poll_ns = ns;
    }

    /// Virtual time in nanoseconds since the rig was built.
    pub fn now_ns(&self) -> u64 {
        self.lock().now_ns
    }

    /// Lets `ns` nanoseconds pass.
    pub fn advance_ns(&self, ns: u64) {
        self.lock().advance_by(ns);
    }

    /// Moves time to the next falling edge of DRDY (strictly later than now) and returns its time in nanoseconds.
    /// `None`, and time stands still, when the scene has ended or no conversion is under way.
    pub fn wait_for_drdy(&self) -> Option<u64> {
        let mut bench = self.lock();
        if bench.chip.ended() {
            return None;
        }
        let edge_ns = bench.chip.next_drdy_fall_ns()?;
        bench.now_ns = edge_ns;
        bench.chip.advance_to(edge_ns);
        Some(edge_ns)
    }

    /// Access to the chip itself, for inspection and faults. Pass [`now_ns`](Self::now_ns) where it wants the time, but
    /// read that before: the rig is locked inside.
    pub fn with_chip<R>(&self, f: impl FnOnce(&mut Ads1258) -> R) -> R {
        f(&mut self.lock().chip)
    }
}
