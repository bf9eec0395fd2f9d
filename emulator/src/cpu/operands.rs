//! Operations and operands of decoded instructions.

/// Register number that discards a result, as for compare instructions.
pub const SINK: u8 = 16;

/// Returns the value of an operand, 0 if the instruction has none.
pub fn or_zero(r: &[u32; 17], n: u8) -> u32 {
    if n == SINK { 0 } else { r[usize::from(n)] }
}

/// Operation of a data-processing instruction on `a` (the first operand) and `b`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dp {
    And,
    Bic,
    Orr,
    Orn,
    Eor,
    Add,
    Adc,
    Sbc,
    Sub,
    Rsb,
    Mov,
    Mvn,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flags {
    Keep,
    Set,
    /// Set outside an IT block only, as in 16-bit encodings.
    OutsideIt,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shift {
    Lsl,
    Lsr,
    Asr,
    Ror,
    Rrx,
}

/// Addressing mode: plain offset, pre-indexed or post-indexed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Index {
    Offset,
    Before,
    After,
}

/// Single-precision arithmetic with two operands; multiply-accumulate rounds twice (VMLA is not
/// fused).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Float2 {
    Mla,
    Mls,
    Nmla,
    Nmls,
    Mul,
    Nmul,
    Add,
    Sub,
    Div,
    Fma,
    Fms,
    Fnma,
    Fnms,
}

/// Floating-point instructions with one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Float1 {
    Mov,
    Abs,
    Neg,
    Sqrt,
}

/// Register number that stands for the constant zero.
pub const FLOAT_ZERO: u8 = 32;

/// Extracts the register number at bit `at` of a half word.
pub const fn reg(hw: u16, at: u32) -> u8 {
    (hw >> at & 15) as u8
}
