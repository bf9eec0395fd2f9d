//! The line: the board's USART. Telemetry leaves with an interrupt for each byte; the DMA puts requests
//! into a buffer, also while the flash is written and the processor stands still.

use super::device::Interrupt as Task;
use core::sync::atomic::{AtomicU8, Ordering::Relaxed};
use cortex_m::peripheral::NVIC;
use ridgetone_finger::tasks::{Received, Receiver, SerialPort};
use stm32f4xx_hal::dma::StreamsTuple;
use stm32f4xx_hal::dma::config::Priority;
use stm32f4xx_hal::dma::traits::Stream;
use stm32f4xx_hal::dma::{DmaChannel, DmaDataSize, DmaDirection, DmaFlag};
use stm32f4xx_hal::gpio::PushPull;
use stm32f4xx_hal::pac::usart1::RegisterBlock;
use stm32f4xx_hal::pac::{DMA1, Interrupt};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::serial::config::DmaConfig;
use stm32f4xx_hal::serial::{Config, Instance, RxListen, SerialExt, Tx, TxISR, TxListen};
use stm32f4xx_hal::{ClearFlags, ReadFlags};

/// Bits per second, 8N1: 92 kB/s, ten times as much as sixteen channels at four windows a second
/// need.
const LINE_BAUD: u32 = 921_600;

/// Bytes of the receiver's buffer, 2.8 ms of them, and of each half, whose end is an interrupt. A half
/// holds the longest request that there is, so that a reader that is late loses none.
const BUFFER_BYTES: usize = 2 * HALF_BYTES;
const HALF_BYTES: usize = 128;

static BUFFER: [AtomicU8; BUFFER_BYTES] = [const { AtomicU8::new(0) }; BUFFER_BYTES];

/// A USART with the stream of DMA1 that receives for it, both on channel 4 (RM0090, table 42).
pub trait Line: Instance<RB = RegisterBlock> + SerialExt {
    type Stream: Stream + ReadFlags<Flag = DmaFlag> + ClearFlags<Flag = DmaFlag>;
    const INTERRUPT: Interrupt;

    fn stream(streams: StreamsTuple<DMA1>) -> Self::Stream;
}

/// Makes a USART the board's line, with the number of the stream of DMA1 that receives for it and that
/// stream's interrupt, which is forwarded to the task `REPORT`: the end of a half of the buffer.
macro_rules! line {
    ($usart:ident: $stream:ident, $number:tt, $interrupt:ident) => {
        impl $crate::board::serial_line::Line for stm32f4xx_hal::pac::$usart {
            type Stream = stm32f4xx_hal::dma::$stream<stm32f4xx_hal::pac::DMA1>;
            const INTERRUPT: stm32f4xx_hal::pac::Interrupt =
                stm32f4xx_hal::pac::Interrupt::$interrupt;

            fn stream(
                streams: stm32f4xx_hal::dma::StreamsTuple<stm32f4xx_hal::pac::DMA1>,
            ) -> Self::Stream {
                streams.$number
            }
        }

        #[unsafe(no_mangle)]
        extern "C" fn $interrupt() {
            // RTIC defines its handlers with Rust's ABI.
            unsafe extern "Rust" {
                fn REPORT();
            }
            // SAFETY: the task's own interrupt cannot run at the same time: see `LineReceiver::new`.
            unsafe { REPORT() }
        }
    };
}

/// The USART's transmitter, and the end of what it receives.
pub struct SerialLine<Usart: Line> {
    tx: Tx<Usart>,
}

impl<Usart: Line> SerialLine<Usart> {
    /// Sets the USART and the DMA up. The transmitter's interrupt is off.
    pub fn new(
        usart: Usart,
        tx: impl Into<Usart::Tx<PushPull>>,
        rx: impl Into<Usart::Rx<PushPull>>,
        dma: DMA1,
        rcc: &mut Rcc,
    ) -> (Self, LineReceiver<Usart>) {
        let config = Config::default()
            .baudrate(LINE_BAUD.bps())
            .dma(DmaConfig::Rx);
        #[allow(clippy::panic, reason = "at start-up, and never: both are constants")]
        let (mut tx, mut rx) = match usart.serial((tx, rx), config, rcc) {
            Ok(serial) => serial.split(),
            Err(_) => panic!("the USART cannot do {LINE_BAUD} baud"),
        };
        let receiver = LineReceiver::new(Usart::stream(StreamsTuple::new(dma, rcc)));
        tx.unlisten();
        rx.listen_idle();
        (Self { tx }, receiver)
    }
}

impl<Usart: Line> SerialPort for SerialLine<Usart> {
    /// Clears the flag, which takes a read of the data register. The DMA has fetched the byte before the
    /// pause 10.9 us ago, and the first byte after it takes as long to arrive.
    fn has_paused(&mut self) -> bool {
        // SAFETY: reading the status, then the data, clears the flag (RM0090, 30.6.1).
        let usart = unsafe { &*Usart::ptr() };
        let has_paused = usart.sr().read().idle().bit_is_set();
        if has_paused {
            let _ = usart.dr().read();
        }
        has_paused
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

/// Bytes that the DMA has received. Counts wrap.
pub struct LineReceiver<Usart: Line> {
    stream: Usart::Stream,
    /// Ends of a half that the DMA has passed.
    halves: u32,
    /// Bytes received, as far as was looked, and bytes read.
    received: u32,
    read: u32,
    /// Unread bytes may have been overwritten.
    is_overrun: bool,
}

impl<Usart: Line> LineReceiver<Usart> {
    /// Starts the stream, and lets its interrupt come, at the priority of the task that it becomes part
    /// of.
    fn new(mut stream: Usart::Stream) -> Self {
        stream.clear_all_flags();
        stream.set_channel(DmaChannel::Channel4);
        stream.set_direction(DmaDirection::PeripheralToMemory);
        // SAFETY: the address alone is taken.
        stream.set_peripheral_address(unsafe { &*Usart::ptr() }.dr().as_ptr() as u32);
        stream.set_memory_address(BUFFER.as_ptr() as u32);
        stream.set_number_of_transfers(BUFFER_BYTES as u16);
        // SAFETY: both are bytes: DR's eight bits, and the buffer's elements.
        unsafe {
            stream.set_memory_size(DmaDataSize::Byte);
            stream.set_peripheral_size(DmaDataSize::Byte);
        }
        stream.set_memory_increment(true);
        stream.set_circular_mode(true);
        stream.set_priority(Priority::VeryHigh);
        stream.listen_half_transfer();
        stream.listen_transfer_complete();
        // SAFETY: the buffer is a static of atomics, which anybody may write at any time. Neither
        // interrupt interrupts the other; RTIC has set the priority before it called `init`, and serves
        // no interrupt before the end of it.
        unsafe {
            stream.enable();
            let priority = NVIC::get_priority(Task::REPORT);
            let mut core = cortex_m::Peripherals::steal();
            core.NVIC.set_priority(Usart::INTERRUPT, priority);
            NVIC::unmask(Usart::INTERRUPT);
        }
        Self {
            stream,
            halves: 0,
            received: 0,
            read: 0,
            is_overrun: false,
        }
    }

    /// Counts what has arrived. False if the ends of both halves have passed since the last look: then
    /// more may have arrived than is known.
    fn count(&mut self) -> bool {
        let (mut ends, mut position) = (0, 0);
        // An end may pass between the reads of flags and position.
        for _ in 0..3 {
            let flags = self.stream.flags() & (DmaFlag::HalfTransfer | DmaFlag::TransferComplete);
            self.stream.clear_flags(flags);
            ends += flags.bits().count_ones();
            position =
                (BUFFER_BYTES as u32).saturating_sub(self.stream.number_of_transfers().into());
            let is_exact = ends < 2 && self.halves.wrapping_add(ends) % 2 == half_of(position);
            if is_exact {
                self.passed(ends, position);
                return true;
            }
        }
        self.passed(2 + (self.halves ^ half_of(position)) % 2, position);
        false
    }

    fn passed(&mut self, ends: u32, position: u32) {
        self.halves = self.halves.wrapping_add(ends);
        let whole = self.halves.wrapping_mul(HALF_BYTES as u32);
        self.received = whole.wrapping_add(position % HALF_BYTES as u32);
    }
}

/// Half of the buffer that holds a position. The position behind the end counts as the first half.
const fn half_of(position: u32) -> u32 {
    position / HALF_BYTES as u32 % 2
}

impl<Usart: Line> Receiver for LineReceiver<Usart> {
    fn look(&mut self) {
        self.is_overrun |= !self.count();
    }

    fn receive(&mut self) -> Option<Received> {
        if self.received == self.read {
            self.look();
        }
        if self.received == self.read && !self.is_overrun {
            return None;
        }
        let byte = BUFFER.get(self.read as usize % BUFFER_BYTES)?.load(Relaxed);
        // After the byte was read: the DMA may have written another over it.
        self.look();
        let unread = self.received.wrapping_sub(self.read);
        if self.is_overrun || unread as usize > BUFFER_BYTES {
            self.is_overrun = false;
            self.read = self.received;
            Some(Received::Lost(unread))
        } else {
            self.read = self.read.wrapping_add(1);
            Some(Received::Byte(byte))
        }
    }
}
