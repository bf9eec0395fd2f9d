//! From the chip into the queue: what DRDY's interrupt does with every conversion.

use crate::frame::TimedConversion;
use crate::tally::Tally;
use ads1258::Ads1258;
use embedded_hal::spi::SpiDevice;
use heapless::spsc::Producer;

/// Reads one conversion, stamps it with the time of its edge of DRDY, microseconds, and queues it; counts it
/// if the read fails or the queue is full. `edge_us` is asked after the read.
#[inline]
pub fn take_in<SPI: SpiDevice>(
    adc: &mut Ads1258<SPI>,
    edge_us: impl FnOnce() -> u32,
    samples: &mut Producer<'_, TimedConversion>,
    tally: &Tally,
) {
    let queued = adc.read().is_ok_and(|conversion| {
        let timed = TimedConversion { t_us: edge_us(), conversion };
        samples.enqueue(timed).is_ok()
    });
    if !queued {
        tally.overrun();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal::spi::{ErrorKind, ErrorType, Operation};
    use heapless::spsc::Queue;

    /// A chip that gives one conversion after the other, and fails every third read.
    struct Chip(u8);

    impl ErrorType for Chip {
        type Error = ErrorKind;
    }

    impl SpiDevice for Chip {
        fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
            self.0 += 1;
            let [Operation::TransferInPlace(bytes)] = operations else { return Err(ErrorKind::Other) };
            assert_eq!(bytes[0], 0x30, "the command that reads a conversion");
            bytes.copy_from_slice(&[0, 0x88, 0, 0, self.0]);
            if self.0.is_multiple_of(3) { Err(ErrorKind::Other) } else { Ok(()) }
        }
    }

    #[test]
    fn what_is_read_is_queued_and_what_is_lost_is_counted() {
        let mut queue = Queue::<TimedConversion, 4>::new();
        let (mut samples, mut out) = queue.split();
        let (mut adc, tally) = (Ads1258::new(Chip(0)), Tally::new());
        for t_us in 0..5 {
            take_in(&mut adc, || t_us, &mut samples, &tally);
        }
        // The third read failed, and the queue has no room for the fourth of the others.
        let found: heapless::Vec<_, 4> = core::iter::from_fn(|| out.dequeue()).collect();
        let told = found.iter().map(|timed| (timed.t_us, timed.conversion.code));
        assert!(told.eq([(0, 1), (1, 2), (3, 4)]), "{found:?}");
        assert_eq!(tally.counters().overruns, 2);
    }
}
