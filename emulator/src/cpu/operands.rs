//! The kinds of operations and operands in a decoded instruction.

/// The register number that swallows a result: compare instructions write it.
pub const SINK: u8 = 16;

/// The operand of an instruction that may have none.
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

/// Whether an instruction sets the flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flags {
    Keep,
    Set,
    /// 16-bit encodings set them outside an IT block only.
    OutsideIt,
}

/// Kind of shift of an operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shift {
    Lsl,
    Lsr,
    Asr,
    Ror,
    Rrx,
}

/// When the address register takes the offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Index {
    Offset,
    Before,
    After,
}

/// Single-precision arithmetic with two operands; those that accumulate round twice (VMLA is not
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

/// Instead of a register's number: the constant zero.
pub const FLOAT_ZERO: u8 = 32;

/// The register number at this place of a half word.
pub const fn reg(hw: u16, at: u32) -> u8 {
    (hw >> at & 15) as u8
}
