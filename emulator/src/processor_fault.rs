//! Faults that a test injects into the processor, to check how the firmware recovers.

/// Kind of the fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProcessorFault {
    /// Sets the program counter: an address without memory causes a HardFault.
    JumpTo(u32),
    /// Sets the stack pointer: near the stack's end it overflows.
    StackPointer(u32),
    /// Sets the microsecond counter, TIM2.
    Microseconds(u32),
    /// Masks an interrupt, so that its task hangs.
    Mask(u16),
    /// Unmasks an interrupt.
    Unmask(u16),
    /// Sets DBGMCU_CR, as a debugger does.
    Debugger(u32),
    /// The external oscillator does not start after the next reset.
    OscillatorDies,
    /// The external oscillator stops now, and does not start again. Without the clock security
    /// system a processor that runs from it stops until the watchdog expires.
    OscillatorStops,
}
