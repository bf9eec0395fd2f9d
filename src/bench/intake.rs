//! What DRDY's interrupt does with a conversion, from a chip in memory: the same function as in the firmware. What
//! the interrupt's entry and a board's SPI take comes on top.

use crate::machine::Counter;
use ads1258::Ads1258;
use core::convert::Infallible;
use core::hint::black_box;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use heapless::spsc::Queue;
use ridgetone::frame::TimedConversion;
use ridgetone::intake::take_in;
use ridgetone::tally::Tally;
use ridgetone::workload::{CONVERSION_BYTES, decode_conversion};

/// Places of the firmware's queue.
const SAMPLES: usize = 128;

/// Conversions that are taken in: the queue's end is among them.
const TAKEN: u32 = 3 * SAMPLES as u32;

/// The chip: every transaction gives the next code.
struct Chip(u32);

impl ErrorType for Chip {
    type Error = Infallible;
}

impl SpiDevice for Chip {
    // A board's transaction is a call too, with a length that is not known before.
    #[inline(never)]
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        self.0 = self.0.wrapping_add(1);
        for operation in operations {
            if let Operation::TransferInPlace(bytes) = operation {
                for (place, byte) in bytes.iter_mut().zip(black_box(answer(self.0))) {
                    *place = byte;
                }
            }
        }
        Ok(())
    }
}

/// What the chip answers to the command: a byte without meaning, the status of AIN0, a code.
fn answer(count: u32) -> [u8; 5] {
    let [_, high, middle, low] = count.to_be_bytes();
    [0, 0x88, high, middle, low]
}

/// Takes conversions in; most instructions of one. None if one was lost or changed.
pub fn measure(counter: &Counter) -> Option<u32> {
    let mut queue = Queue::<TimedConversion, SAMPLES>::new();
    let (mut samples, mut out) = queue.split();
    let (mut adc, tally) = (Ads1258::new(Chip(0)), Tally::new());
    let mut most = 0;
    for count in 1..=TAKEN {
        let (instructions, ()) = counter.measure(|| take_in(&mut adc, || black_box(count), &mut samples, &tally));
        most = most.max(instructions);
        let mut bytes = [0; CONVERSION_BYTES];
        let (time, conversion) = bytes.split_first_chunk_mut::<4>()?;
        *time = count.to_le_bytes();
        conversion.copy_from_slice(answer(count).get(1..)?);
        if out.dequeue()? != decode_conversion(&bytes) {
            return None;
        }
    }
    Some(most)
}
