//! The HardFault handler: records the fault and resets the board.

use super::clock::now_us;
use super::stack;
use super::stm32f4::die;
use cortex_m_rt::ExceptionFrame;
use ridgetone_proto::boot::Record;

/// Entry of a HardFault. If less than 1 KiB of the stack is left, moves the stack pointer to the
/// top of the stack. The processor's frame is then at the other end, where the handler does not
/// overwrite it.
#[unsafe(naked)]
#[unsafe(export_name = "HardFault")]
unsafe extern "C" fn enter_hard_fault() -> ! {
    core::arch::naked_asm!(
        "mrs r0, msp",
        "movw r1, #:lower16:_stack_end",
        "movt r1, #:upper16:_stack_end",
        "add r1, r1, #1024",
        "cmp r0, r1",
        "bhs 2f",
        "movw r1, #:lower16:_stack_start",
        "movt r1, #:upper16:_stack_start",
        "msr msp, r1",
        // Cancel lazy stacking of the FPU's registers: without memory for them it would fault again
        // (Armv7-M, FPCCR.LSPACT).
        "2:",
        "movw r2, #0xef34",
        "movt r2, #0xe000",
        "ldr r3, [r2]",
        "bic r3, r3, #1",
        "str r3, [r2]",
        "b {handle}",
        handle = sym handle_hard_fault,
    )
}

/// Handles a HardFault. `frame` is the address where the processor has stored its registers, or
/// would have if the stack had not overflowed.
unsafe extern "C" fn handle_hard_fault(frame: *const ExceptionFrame) -> ! {
    let (pc, lr) = if stack::holds(frame) {
        // SAFETY: the frame is in the stack, where the processor has stored it, and has not been
        // overwritten.
        unsafe { ((*frame).pc(), (*frame).lr()) }
    } else {
        (0, 0)
    };
    die(&Record::of_hard_fault(now_us(), pc, lr))
}
