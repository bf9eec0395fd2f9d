//! The line: the board's USART, telemetry out and requests in, one byte per interrupt.

use ridgetone_finger::tasks::{Received, SerialPort};
use stm32f4xx_hal::gpio::PushPull;
use stm32f4xx_hal::pac::usart1::RegisterBlock;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::serial::{Config, Instance, RxListen, SerialExt, Tx, TxISR, TxListen};

/// Bits per second, 8N1: 92 kB/s, ten times as much as sixteen channels at four windows a second
/// need.
const LINE_BAUD: u32 = 921_600;

/// The line's USART.
pub struct SerialLine<Usart: Instance> {
    tx: Tx<Usart>,
}

impl<Usart: Instance + SerialExt> SerialLine<Usart> {
    /// Sets the USART up. Its receiver's interrupt is on, its transmitter's off.
    pub fn new(
        usart: Usart,
        tx: impl Into<Usart::Tx<PushPull>>,
        rx: impl Into<Usart::Rx<PushPull>>,
        rcc: &mut Rcc,
    ) -> Self {
        #[allow(clippy::panic, reason = "at start-up, and never: both are constants")]
        let (mut tx, mut rx) =
            match usart.serial((tx, rx), Config::default().baudrate(LINE_BAUD.bps()), rcc) {
                Ok(serial) => serial.split(),
                Err(_) => panic!("the USART cannot do {LINE_BAUD} baud"),
            };
        tx.unlisten();
        rx.listen();
        Self { tx }
    }
}

impl<Usart: Instance<RB = RegisterBlock>> SerialPort for SerialLine<Usart> {
    /// Not by the HAL (0.23), which drops the byte in the data register if the one after it was
    /// lost.
    fn receive(&mut self) -> Option<Received> {
        // SAFETY: nothing else receives. Its status, then its data, clears the flags (RM0090,
        // 30.6.1).
        let usart = unsafe { &*Usart::ptr() };
        let status = usart.sr().read();
        if status.rxne().bit_is_clear() && status.ore().bit_is_clear() {
            return None;
        }
        let byte = usart.dr().read().bits() as u8;
        let is_whole =
            status.rxne().bit_is_set() && status.fe().bit_is_clear() && status.nf().bit_is_clear();
        // An overrun without a byte: the byte before was read, and the next one lost, between the reads
        // of status and data of the last call.
        Some(match (is_whole, status.ore().bit_is_set()) {
            (true, false) => Received::Byte(byte),
            (true, true) => Received::Overrun(byte),
            (false, false) => Received::Damaged,
            (false, true) => Received::Lost,
        })
    }

    fn is_ready(&self) -> bool {
        self.tx.is_tx_empty()
    }

    fn send(&mut self, byte: u8) {
        // Refused only if not ready.
        let _ = self.tx.write(byte);
        self.tx.listen();
    }

    fn stop_transmitting(&mut self) {
        self.tx.unlisten();
    }
}
