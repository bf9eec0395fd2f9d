//! The line: the board's USART, telemetry out and requests in, one byte per interrupt.

use super::Usart;
use ridgetone::tasks::line::{Lost, SerialPort};
use stm32f4xx_hal::gpio::PushPull;
use stm32f4xx_hal::gpio::alt::SerialAsync;
use stm32f4xx_hal::nb;
#[cfg(feature = "emulated")]
use stm32f4xx_hal::pac::{Interrupt, NVIC};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::serial::{Config, Rx, RxListen, Tx, TxISR, TxListen};

/// Bits per second, 8N1: 92 kB/s, ten times as much as sixteen channels at four windows a second need.
const LINE_BAUD: u32 = 921_600;

/// The USART.
pub struct SerialLine {
    tx: Tx<Usart>,
    rx: Rx<Usart>,
}

impl SerialLine {
    /// Sets the USART up. Its receiver's interrupt is on, its transmitter's off.
    pub fn new(
        usart: Usart,
        pins: (impl Into<<Usart as SerialAsync>::Tx<PushPull>>, impl Into<<Usart as SerialAsync>::Rx<PushPull>>),
        rcc: &mut Rcc,
    ) -> Self {
        #[allow(clippy::panic, reason = "at start-up, and never: both are constants")]
        let (mut tx, mut rx) = match usart.serial(pins, Config::default().baudrate(LINE_BAUD.bps()), rcc) {
            Ok(serial) => serial.split(),
            Err(_) => panic!("the USART cannot do {LINE_BAUD} baud"),
        };
        tx.unlisten();
        rx.listen();
        Self { tx, rx }
    }
}

impl SerialPort for SerialLine {
    fn receive(&mut self) -> Option<Result<u8, Lost>> {
        match self.rx.read() {
            Ok(byte) => Some(Ok(byte)),
            Err(nb::Error::WouldBlock) => None,
            Err(nb::Error::Other(_)) => Some(Err(Lost)),
        }
    }

    fn is_ready(&self) -> bool {
        // The emulator's transmitter is always empty: the bridge knows whether the line is blocked.
        #[cfg(feature = "emulated")]
        if super::is_line_blocked() {
            return false;
        }
        self.tx.is_tx_empty()
    }

    fn send(&mut self, byte: u8) {
        // Refused only if not ready.
        let _ = self.tx.write(byte);
        self.tx.listen();
        // QEMU before 8.2 has no "transmitter empty" interrupt; its transmitter is empty at once.
        #[cfg(feature = "emulated")]
        NVIC::pend(Interrupt::USART3);
    }

    fn rest(&mut self) {
        self.tx.unlisten();
    }
}
