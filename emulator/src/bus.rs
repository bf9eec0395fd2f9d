//! Everything that the processor reaches: memory, peripherals, time. The pins end at the simulated
//! ADC and the serial line.

mod access;
mod events;
mod own_adc;
mod registers;
mod state;
#[cfg(test)]
mod tests;
mod wires;

pub(crate) use state::Bus;
