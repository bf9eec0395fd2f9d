//! Reasons for an instruction to end early.

use std::fmt;

/// Failure that ends the run: the image has used something that is not modelled, or the processor
/// has locked up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// Description of the missing register or instruction.
    pub what: String,
    /// Address of the access.
    pub address: u32,
    /// Address of the instruction.
    pub pc: u32,
    /// Virtual time, nanoseconds since power-up.
    pub at_ns: u64,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            what,
            address,
            pc,
            at_ns,
        } = self;
        write!(
            f,
            "{what} at {address:#010x}: instruction {pc:#010x}, {:.6} s",
            *at_ns as f64 * 1e-9
        )
    }
}

impl std::error::Error for Failure {}

/// Usage faults, with their bits in CFSR (DDI 0403E, B3.2.15).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Usage {
    Undefined = 1 << 16,
    State = 1 << 17,
    NoCoprocessor = 1 << 19,
    Unaligned = 1 << 24,
}

/// Reason why an instruction ends early.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Stop {
    /// No memory at this address.
    Bus(u32),
    /// A usage fault.
    Usage(Usage),
    /// The run is over.
    Failed(Box<Failure>),
}
