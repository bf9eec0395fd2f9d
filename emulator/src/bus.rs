//! Everything that the processor can access: memory, peripherals, time. The pins lead to the
//! simulated ADC and the serial line.

mod access;
mod events;
mod own_adc;
mod registers;
mod state;
#[cfg(test)]
mod tests;
mod wires;

pub(crate) use state::Bus;
