//! The line: the board's USART, telemetry out and orders in, one byte per interrupt.

use super::Usart;
use stm32f4xx_hal::gpio::PushPull;
use stm32f4xx_hal::gpio::alt::SerialAsync;
use stm32f4xx_hal::nb;
#[cfg(feature = "emulated")]
use stm32f4xx_hal::pac::{Interrupt, NVIC};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::serial::{Config, Rx, RxListen, Tx, TxISR, TxListen};

/// Bits per second, 8N1: 92 kB/s, ten times what sixteen channels at four windows a second need.
const LINE_BAUD: u32 = 921_600;

/// The USART.
pub struct Line {
    tx: Tx<Usart>,
    rx: Rx<Usart>,
}

/// A byte was lost: it came too fast, or noise was on the line.
pub struct Lost;

impl Line {
    /// Sets the USART up. Its receiver's interrupt is on, its transmitter's off.
    pub fn new(
        usart: Usart,
        pins: (impl Into<<Usart as SerialAsync>::Tx<PushPull>>, impl Into<<Usart as SerialAsync>::Rx<PushPull>>),
        rcc: &mut Rcc,
    ) -> Self {
        #[allow(clippy::panic, reason = "at start-up, and never: both are constants")]
        let (mut tx, mut rx) = match usart.serial(pins, Config::default().baudrate(LINE_BAUD.bps()), rcc) {
            Ok(serial) => serial.split(),
            // Not met at run time: the divider of a fixed baud rate from a fixed clock.
            Err(_) => panic!("the USART cannot do {LINE_BAUD} baud"),
        };
        tx.unlisten();
        rx.listen();
        Self { tx, rx }
    }

    /// The byte that has come, if one has.
    pub fn receive(&mut self) -> Option<Result<u8, Lost>> {
        match self.rx.read() {
            Ok(byte) => Some(Ok(byte)),
            Err(nb::Error::WouldBlock) => None,
            Err(nb::Error::Other(_)) => Some(Err(Lost)),
        }
    }

    /// Whether a byte can be taken. False while one is on its way and [`Line::send`]'s interrupt is due.
    pub fn ready(&self) -> bool {
        // The emulator's transmitter is always empty: the bridge says whether the line is blocked.
        #[cfg(feature = "emulated")]
        if super::link::is_line_blocked() {
            return false;
        }
        self.tx.is_tx_empty()
    }

    /// Sends a byte if [`Line::ready`]; the interrupt USART3 comes when the next one can be taken.
    pub fn send(&mut self, byte: u8) {
        // Refused only if not ready, which the caller has asked.
        let _ = self.tx.write(byte);
        self.tx.listen();
        // QEMU before 8.2 has no "transmitter empty" interrupt; its transmitter is empty at once.
        #[cfg(feature = "emulated")]
        NVIC::pend(Interrupt::USART3);
    }

    /// Nothing to send: no more interrupts until the next byte.
    pub fn rest(&mut self) {
        self.tx.unlisten();
    }
}
