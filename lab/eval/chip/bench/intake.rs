//! What DRDY's interrupt does with a conversion, from a chip in memory: the same function as in the
//! firmware. What the interrupt's entry and a board's SPI take comes on top.

use crate::machine::Counter;
use ads1258::Ads1258;
use core::convert::Infallible;
use core::hint::black_box;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use heapless::spsc::Queue;
use ridgetone_eval::workload::conversion;
use ridgetone_finger::Acquisition;
use ridgetone_finger::Diagnostics;
use ridgetone_finger::SLOTS;
use ridgetone_finger::TimedConversion;
use ridgetone_finger::converter::WiredAds1258;
use ridgetone_proto::plan::Plan;

/// Places of the firmware's queue.
const SAMPLES: usize = ridgetone_finger::tasks::SAMPLES;

/// Conversions that are taken in: the queue's end is among them.
const TAKEN: u32 = 3 * SAMPLES as u32;

/// The chip: every second transaction gives the next code, the others the same once more, with NEW
/// cleared.
struct Chip(u32);

impl ErrorType for Chip {
    type Error = Infallible;
}

impl SpiDevice for Chip {
    // A board's transaction is a call too, with a length that is not known before.
    #[inline(never)]
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        for operation in operations {
            if let Operation::TransferInPlace(bytes) = operation {
                for (place, byte) in bytes.iter_mut().zip(black_box(answer(self.0))) {
                    *place = byte;
                }
            }
        }
        self.0 = self.0.wrapping_add(1);
        Ok(())
    }
}

/// A pin that goes nowhere.
struct Pin;

impl digital::ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// What the chip answers to a command: a byte without meaning, the status, a code.
fn answer(transaction: u32) -> [u8; 5] {
    let count = transaction / 2;
    let [_, high, middle, low] = count.to_be_bytes();
    // AIN0 to AIN15 have the ids 8 to 23, OFFSET 24, VCC to REF 26 to 29 (SBAS297G).
    let slot = (count % SLOTS) as u8;
    let id = if slot < 17 { 8 + slot } else { 9 + slot };
    let new = if transaction.is_multiple_of(2) {
        0x80
    } else {
        0
    };
    [0, new | id, high, middle, low]
}

/// Takes conversions in; most instructions of one. None if one was lost or changed.
pub fn measure(counter: &Counter) -> Option<u32> {
    let mut queue = Queue::<TimedConversion, SAMPLES>::new();
    let (mut samples, mut out) = queue.split();
    let converter = WiredAds1258::new(Ads1258::new(Chip(0)), Pin, Pin);
    let mut acquisition = Acquisition::new(converter, Plan::PAPER);
    let diagnostics = Diagnostics::new();
    let mut most = 0;
    for count in 0..TAKEN {
        let mut edge = || acquisition.edge(|| black_box(count), &mut samples, &diagnostics);
        let (instructions, _) = counter.measure(|| black_box(edge()));
        most = most.max(instructions);
        let [_, bytes @ ..] = answer(2 * count);
        if out.dequeue()? != conversion(count, bytes) {
            return None;
        }
    }
    Some(most)
}
