//! START, RESET, DRDY and delays.

use super::Rig;
use core::convert::Infallible;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};

/// One handle type per pin; none ever fails.
macro_rules! pin {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone)]
        pub struct $name {
            rig: Rig,
        }

        impl $name {
            pub(super) fn new(rig: Rig) -> Self {
                Self { rig }
            }
        }

        impl ErrorType for $name {
            type Error = Infallible;
        }
    };
}

pin!(
    /// The chip's START pin.
    StartPin
);
pin!(
    /// The chip's RESET pin (low resets).
    ResetPin
);
pin!(
    /// The chip's DRDY pin.
    DrdyPin
);

impl OutputPin for StartPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        let mut bench = self.rig.lock();
        let now_ns = bench.now_ns;
        bench.chip.set_start(now_ns, false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        let mut bench = self.rig.lock();
        let now_ns = bench.now_ns;
        bench.chip.set_start(now_ns, true);
        Ok(())
    }
}

impl OutputPin for ResetPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        let mut bench = self.rig.lock();
        let now_ns = bench.now_ns;
        bench.chip.set_reset(now_ns, false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        let mut bench = self.rig.lock();
        let now_ns = bench.now_ns;
        bench.chip.set_reset(now_ns, true);
        Ok(())
    }
}

impl InputPin for DrdyPin {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        let mut bench = self.rig.lock();
        let now_ns = bench.now_ns;
        let high = bench.chip.drdy_high(now_ns);
        let poll_ns = bench.poll_ns;
        bench.advance_by(poll_ns);
        Ok(high)
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}

/// Delays in virtual time: they cost nothing and are exact.
#[derive(Clone)]
pub struct RigDelay {
    rig: Rig,
}

impl RigDelay {
    pub(super) fn new(rig: Rig) -> Self {
        Self { rig }
    }
}

impl DelayNs for RigDelay {
    fn delay_ns(&mut self, ns: u32) {
        self.rig.advance_ns(u64::from(ns));
    }
}
