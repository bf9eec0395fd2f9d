//! The chip on a simulated board: its pins as embedded-hal 1.0 traits on one virtual clock. Pin
//! operations cannot fail.

use crate::chip::{Ads1258, Options};
use crate::scene::Scene;
use core::convert::Infallible;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{self, InputPin, OutputPin, PinState};
use embedded_hal::spi::{self, Operation, SpiDevice};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A simulated chip and the virtual clock that all its pins share. Clones share one chip and clock.
#[derive(Clone)]
pub struct SimulatedBoard(Arc<Mutex<State>>);

struct State {
    chip: Ads1258,
    now_ns: u64,
    /// SPI clock in hertz; at 0, SPI bytes take no time.
    sclk_hz: u32,
    read_fill: u8,
    poll_ns: u64,
}

/// The chip's SPI port with its CS.
#[derive(Clone)]
pub struct ChipSpi(SimulatedBoard);

/// A pin that the board drives, and the chip's method that takes its level.
#[derive(Clone)]
pub struct ChipPin(SimulatedBoard, fn(&mut Ads1258, u64, bool));

/// The chip's START pin.
pub type StartPin = ChipPin;

/// The chip's RESET pin (low resets).
pub type ResetPin = ChipPin;

/// The chip's DRDY pin.
#[derive(Clone)]
pub struct DrdyPin(SimulatedBoard);

/// Exact delays in virtual time, without real waiting.
#[derive(Clone)]
pub struct VirtualDelay(SimulatedBoard);

impl SimulatedBoard {
    /// Creates a board at time 0, with a chip in its power-up state that samples `scene`.
    pub fn new(scene: impl Scene + 'static, options: Options) -> Self {
        let chip = Ads1258::new(Box::new(scene), options);
        Self(Arc::new(Mutex::new(State {
            chip,
            now_ns: 0,
            sclk_hz: 0,
            read_fill: 0x00,
            poll_ns: 0,
        })))
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // If a test panicked elsewhere, the state is still valid: every change is complete before
        // anything can panic.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The SPI bus with the chip's CS.
    pub fn spi(&self) -> ChipSpi {
        ChipSpi(self.clone())
    }

    /// The START pin, low at first.
    pub fn start_pin(&self) -> StartPin {
        ChipPin(self.clone(), Ads1258::set_start)
    }

    /// The RESET pin, high at first.
    pub fn reset_pin(&self) -> ResetPin {
        ChipPin(self.clone(), Ads1258::set_reset)
    }

    /// The DRDY pin.
    pub fn drdy_pin(&self) -> DrdyPin {
        DrdyPin(self.clone())
    }

    /// Delays that advance the virtual clock.
    pub fn delay(&self) -> VirtualDelay {
        VirtualDelay(self.clone())
    }

    /// Sets SCLK in hertz: each SPI byte takes 8 cycles (rounded down to nanoseconds). With 0, the
    /// default, it takes no time.
    pub fn set_sclk_hz(&self, sclk_hz: u32) {
        self.lock().sclk_hz = sclk_hz;
    }

    /// Sets the byte on DIN while a driver only reads, which embedded-hal leaves to the
    /// implementation. Default 00h.
    pub fn set_read_fill(&self, byte: u8) {
        self.lock().read_fill = byte;
    }

    /// Sets how far virtual time advances after each read of the DRDY pin, in nanoseconds. Default
    /// 0; a driver that polls without a delay needs more, or virtual time stands still.
    pub fn set_poll_ns(&self, ns: u64) {
        self.lock().poll_ns = ns;
    }

    /// Virtual time in nanoseconds since the board was built.
    pub fn now_ns(&self) -> u64 {
        self.lock().now_ns
    }

    /// Lets `ns` nanoseconds pass.
    pub fn advance_ns(&self, ns: u64) {
        self.lock().advance_by(ns);
    }

    /// Moves time to the next falling edge of DRDY (strictly later than now) and returns its time
    /// in nanoseconds. Returns `None` and leaves the time unchanged if the scene has ended or no
    /// conversion runs.
    pub fn wait_for_drdy(&self) -> Option<u64> {
        let mut state = self.lock();
        if state.chip.ended() {
            return None;
        }
        let edge_ns = state.chip.next_drdy_fall_ns()?;
        state.now_ns = edge_ns;
        state.chip.advance_to(edge_ns);
        Some(edge_ns)
    }

    /// Calls `f` with the chip while the board is locked. Read [`now_ns`](Self::now_ns) before the
    /// call: inside `f` it would deadlock.
    pub fn with_chip<R>(&self, f: impl FnOnce(&mut Ads1258) -> R) -> R {
        f(&mut self.lock().chip)
    }
}

impl State {
    fn advance_by(&mut self, ns: u64) {
        self.now_ns = self.now_ns.saturating_add(ns);
        self.chip.advance_to(self.now_ns);
    }

    fn exchange(&mut self, din: u8) -> u8 {
        let first_ns = self.now_ns;
        let byte_ns = 8_000_000_000_u64
            .checked_div(u64::from(self.sclk_hz))
            .unwrap_or(0);
        self.now_ns = first_ns.saturating_add(byte_ns);
        self.chip.exchange(first_ns, self.now_ns, din)
    }
}

impl spi::ErrorType for ChipSpi {
    type Error = Infallible;
}

/// CS stays low for the whole transaction.
impl SpiDevice for ChipSpi {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let mut state = self.0.lock();
        let (fill, now_ns) = (state.read_fill, state.now_ns);
        state.chip.select(now_ns);
        for operation in operations {
            match operation {
                Operation::Read(words) => words
                    .iter_mut()
                    .for_each(|word| *word = state.exchange(fill)),
                Operation::Write(words) => words.iter().for_each(|word| {
                    state.exchange(*word);
                }),
                Operation::Transfer(read, write) => {
                    for i in 0..read.len().max(write.len()) {
                        let dout = state.exchange(write.get(i).copied().unwrap_or(fill));
                        if let Some(word) = read.get_mut(i) {
                            *word = dout;
                        }
                    }
                }
                Operation::TransferInPlace(words) => words
                    .iter_mut()
                    .for_each(|word| *word = state.exchange(*word)),
                Operation::DelayNs(ns) => state.advance_by(u64::from(*ns)),
            }
        }
        let now_ns = state.now_ns;
        state.chip.deselect(now_ns);
        Ok(())
    }
}

impl digital::ErrorType for ChipPin {
    type Error = Infallible;
}

impl OutputPin for ChipPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.set_state(PinState::Low)
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.set_state(PinState::High)
    }

    fn set_state(&mut self, state: PinState) -> Result<(), Infallible> {
        let now_ns = self.0.now_ns();
        self.0
            .with_chip(|chip| (self.1)(chip, now_ns, state == PinState::High));
        Ok(())
    }
}

impl digital::ErrorType for DrdyPin {
    type Error = Infallible;
}

impl InputPin for DrdyPin {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        let mut state = self.0.lock();
        let (now_ns, poll_ns) = (state.now_ns, state.poll_ns);
        let high = state.chip.drdy_high(now_ns);
        state.advance_by(poll_ns);
        Ok(high)
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}

impl DelayNs for VirtualDelay {
    fn delay_ns(&mut self, ns: u32) {
        self.0.advance_ns(u64::from(ns));
    }
}

#[cfg(feature = "async")]
impl embedded_hal_async::spi::SpiDevice for ChipSpi {
    async fn transaction(
        &mut self,
        operations: &mut [Operation<'_, u8>],
    ) -> Result<(), Infallible> {
        SpiDevice::transaction(self, operations)
    }
}

/// Waiting for a falling edge moves virtual time to the edge. Waiting for DRDY to rise stays
/// pending, because no driver does so.
#[cfg(feature = "async")]
impl embedded_hal_async::digital::Wait for DrdyPin {
    async fn wait_for_high(&mut self) -> Result<(), Infallible> {
        if self.is_high()? {
            Ok(())
        } else {
            core::future::pending().await
        }
    }

    async fn wait_for_low(&mut self) -> Result<(), Infallible> {
        if self.is_low()? {
            Ok(())
        } else {
            self.wait_for_falling_edge().await
        }
    }

    async fn wait_for_rising_edge(&mut self) -> Result<(), Infallible> {
        core::future::pending().await
    }

    async fn wait_for_falling_edge(&mut self) -> Result<(), Infallible> {
        if self.0.wait_for_drdy().is_some() {
            Ok(())
        } else {
            core::future::pending().await
        }
    }

    async fn wait_for_any_edge(&mut self) -> Result<(), Infallible> {
        self.wait_for_falling_edge().await
    }
}
