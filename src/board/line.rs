//! The line: USART3, telemetry out and orders in, one byte per interrupt.

use stm32f4xx_hal::nb;
use stm32f4xx_hal::pac::USART3;
#[cfg(feature = "emulated")]
use stm32f4xx_hal::pac::{Interrupt, NVIC};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::serial::{Rx, RxListen, Serial, Tx, TxISR, TxListen};

/// Bits per second, 8N1: 92 kB/s, ten times what sixteen channels at four windows a second need.
pub const LINE_BAUD: u32 = 921_600;

/// USART3.
pub struct Line {
    tx: Tx<USART3>,
    rx: Rx<USART3>,
}

/// A byte was lost: it came too fast, or noise was on the line.
pub struct Lost;

impl Line {
    /// Takes over the configured USART. Its receiver's interrupt is on, its transmitter's off.
    pub fn new(serial: Serial<USART3>) -> Self {
        let (mut tx, mut rx) = serial.split();
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
