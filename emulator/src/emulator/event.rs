//! Events that a run can wait for.

use super::run::Emulator;
use crate::board::Pin;
use crate::stop::Failure;

/// An event that ends [`Emulator::run_to`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// A byte has left on the serial line.
    Byte,
    /// A pin driven by the firmware changes, or is no longer driven.
    Pin(Pin),
    /// The chip is reset.
    Reset,
    /// A rule is broken at an instruction that did not break it before.
    Finding,
    /// The instruction at this address is next: see [`Image::function`](crate::Image::function).
    Address(u32),
}

impl Emulator {
    /// Runs until an event, but no longer than `limit_ns`. Returns true if the event has happened.
    pub fn run_to(&mut self, event: Until, limit_ns: u64) -> Result<bool, Box<Failure>> {
        let end_ns = self.now_ns() + limit_ns;
        if let Until::Address(address) = event {
            return self.run_to_address(address & !1, end_ns);
        }
        let before = self.mark(event);
        while self.now_ns() < end_ns {
            self.run_once(end_ns)?;
            if self.mark(event) != before {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Returns a number that changes whenever the event happens.
    fn mark(&self, event: Until) -> u64 {
        match event {
            Until::Byte => self.bus.usart.sent.len() as u64,
            Until::Pin(pin) => self.pin(pin).map_or(2, u64::from),
            Until::Reset => self.resets().len() as u64,
            Until::Finding => self.findings().len() as u64,
            Until::Address(_) => 0,
        }
    }

    fn run_to_address(&mut self, address: u32, end_ns: u64) -> Result<bool, Box<Failure>> {
        // The instruction may already be next: skip it.
        if self.cpu.pc == address {
            self.run_ns(1)?;
        }
        self.stops_at = Some(address);
        let mut outcome = Ok(false);
        while self.now_ns() < end_ns && matches!(outcome, Ok(false)) {
            outcome = self.run_once(end_ns).map(|()| self.cpu.pc == address);
        }
        self.stops_at = None;
        // The next run may end at a different time, so poll again.
        self.bus.attend();
        outcome
    }
}
