//! The SPI bus: one `SpiDevice` transaction is one CS-framed transaction.

use super::{Bench, Rig};
use core::convert::Infallible;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};

/// The chip's SPI port; never fails.
#[derive(Clone)]
pub struct RigSpi {
    rig: Rig,
}

impl RigSpi {
    pub(super) fn new(rig: Rig) -> Self {
        Self { rig }
    }
}

impl Bench {
    fn exchange(&mut self, din: u8) -> u8 {
        let first_ns = self.now_ns;
        let byte_ns = if self.sclk_hz == 0 { 0 } else { 8_000_000_000 / u64::from(self.sclk_hz) };
        let last_ns = first_ns.saturating_add(byte_ns);
        let dout = self.chip.exchange(first_ns, last_ns, din);
        self.now_ns = last_ns;
        dout
    }
}

impl ErrorType for RigSpi {
    type Error = Infallible;
}

impl SpiDevice<u8> for RigSpi {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let mut bench = self.rig.lock();
        let (fill, now_ns) = (bench.read_fill, bench.now_ns);
        bench.chip.select(now_ns);
        for operation in operations {
            match operation {
                Operation::Read(words) => words.iter_mut().for_each(|word| *word = bench.exchange(fill)),
                Operation::Write(words) => words.iter().for_each(|word| {
                    bench.exchange(*word);
                }),
                Operation::Transfer(read, write) => {
                    for i in 0..read.len().max(write.len()) {
                        let dout = bench.exchange(write.get(i).copied().unwrap_or(fill));
                        if let Some(word) = read.get_mut(i) {
                            *word = dout;
                        }
                    }
                }
                Operation::TransferInPlace(words) => {
                    words.iter_mut().for_each(|word| *word = bench.exchange(*word));
                }
                Operation::DelayNs(ns) => bench.advance_by(u64::from(*ns)),
            }
        }
        let now_ns = bench.now_ns;
        bench.chip.deselect(now_ns);
        Ok(())
    }
}
