//! Faults that a test injects into the processor, to see how the firmware recovers.

/// Kind of the fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProcessorFault {
    /// The program counter jumps: to an address without memory it is a HardFault.
    JumpTo(u32),
    /// The stack pointer has this value now: near the stack's end it overflows.
    StackPointer(u32),
    /// The microsecond counter, TIM2, has this value now.
    Microseconds(u32),
    /// An interrupt is masked: its task hangs.
    Mask(u16),
    /// The contrary.
    Unmask(u16),
    /// A debugger has put this value into DBGMCU_CR.
    Debugger(u32),
    /// The external oscillator does not start after the next reset.
    OscillatorDies,
    /// The external oscillator stops now, and does not start again. Without the clock security system
    /// a processor that runs from it stands still until the watchdog bites.
    OscillatorStops,
}
