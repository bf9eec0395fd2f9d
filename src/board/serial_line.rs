//! The line: the board's USART. Telemetry is sent with an interrupt per byte; the DMA writes
//! requests into a buffer, even while the flash is written and the processor stalls.

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

/// Bits per second, 8N1: 92 kB/s, ten times as much as sixteen channels need at four windows a
/// second.
const LINE_BAUD: u32 = 921_600;

/// Size of the receive buffer, 2.8 ms of bytes, and of its halves, which interrupt when full. A
/// half has room for the longest request, so none is lost if the reader is late.
const BUFFER_BYTES: usize = 2 * HALF_BYTES;
const HALF_BYTES: usize = 128;

static BUFFER: [AtomicU8; BUFFER_BYTES] = [const { AtomicU8::new(0) }; BUFFER_BYTES];

/// A USART with the stream of DMA1 for its receiver, on channel 4 (RM0090, table 42).
pub trait Line: Instance<RB = RegisterBlock> + SerialExt {
    type Stream: Stream + ReadFlags<Flag = DmaFlag> + ClearFlags<Flag = DmaFlag>;
    const INTERRUPT: Interrupt;

    fn stream(streams: StreamsTuple<DMA1>) -> Self::Stream;
}

/// Makes a USART the board's line, given the number of the stream of DMA1 for its receiver. The
/// stream's interrupt, at the end of each half of the buffer, is forwarded to the task `REPORT`.
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
            // SAFETY: the task's own interrupt cannot run at the same time: see
            // `LineReceiver::new`.
            unsafe { REPORT() }
        }
    };
}

/// Transmitter of the USART, and detector of pauses in the received bytes.
pub struct SerialLine<Usart: Line> {
    tx: Tx<Usart>,
}

impl<Usart: Line> SerialLine<Usart> {
    /// Sets up the USART and the DMA. The transmitter's interrupt is off.
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
    /// Clears the flag by reading the data register. This loses no byte: the DMA fetched the byte
    /// before the pause 10.9 us ago, and the first byte after it takes just as long to arrive.
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
        // Fails only if the transmitter is not ready.
        let _ = self.tx.write(byte);
        self.tx.listen();
    }

    fn stop_transmitting(&mut self) {
        self.tx.unlisten();
    }
}

/// Reader of the bytes that the DMA has received. Counts wrap.
pub struct LineReceiver<Usart: Line> {
    stream: Usart::Stream,
    /// Number of halves that the DMA has filled.
    halves: u32,
    /// Bytes received up to the latest call of `look`, and bytes read.
    received: u32,
    read: u32,
    /// True if unread bytes may have been overwritten.
    is_overrun: bool,
}

impl<Usart: Line> LineReceiver<Usart> {
    /// Starts the stream and enables its interrupt, at the priority of the task to which it is
    /// forwarded.
    fn new(mut stream: Usart::Stream) -> Self {
        stream.clear_all_flags();
        stream.set_channel(DmaChannel::Channel4);
        stream.set_direction(DmaDirection::PeripheralToMemory);
        // SAFETY: only the address is taken.
        stream.set_peripheral_address(unsafe { &*Usart::ptr() }.dr().as_ptr() as u32);
        stream.set_memory_address(BUFFER.as_ptr() as u32);
        stream.set_number_of_transfers(BUFFER_BYTES as u16);
        // SAFETY: both sides are bytes: DR's eight bits, and the buffer's elements.
        unsafe {
            stream.set_memory_size(DmaDataSize::Byte);
            stream.set_peripheral_size(DmaDataSize::Byte);
        }
        stream.set_memory_increment(true);
        stream.set_circular_mode(true);
        stream.set_priority(Priority::VeryHigh);
        stream.listen_half_transfer();
        stream.listen_transfer_complete();
        // SAFETY: the buffer is a static of atomics, which may be written at any time. Neither
        // interrupt preempts the other: RTIC has set the priority before it calls `init`, and
        // serves no interrupt until `init` has ended.
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

    /// Counts received bytes. Returns false if the DMA has passed the ends of both halves since the
    /// last call, because more bytes may then have arrived than are counted.
    fn count(&mut self) -> bool {
        let (mut ends, mut position) = (0, 0);
        // Retry: the DMA may pass an end between the reads of flags and position.
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

/// Half of the buffer that contains a position. The position after the end counts as the first
/// half.
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
        // Check after reading the byte, because the DMA may have overwritten it meanwhile.
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
