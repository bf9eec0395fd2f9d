//! The processor's state: registers, flags and the cache of decoded instructions.

use super::op::Op;

/// First address of the main flash (RM0090 and RM0390, memory map).
pub(crate) const FLASH: u32 = 0x0800_0000;

/// Cache entry that is not decoded yet: its size is zero bytes, which no instruction has.
pub const UNKNOWN: (Op, u8) = (Op::Nop, 0);

pub(crate) struct Cpu {
    /// R0 to R15, and a register that discards results. While an instruction runs, R15 is its
    /// address plus 4.
    pub r: [u32; 17],
    /// S0 to S31, and a constant zero.
    pub s: [u32; 33],
    pub n: bool,
    pub z: bool,
    pub c: bool,
    pub v: bool,
    pub q: bool,
    /// IT state: the condition of the next instruction in bits 7 to 4.
    pub it: u8,
    pub primask: bool,
    pub faultmask: bool,
    pub basepri: u8,
    /// CONTROL.FPCA: the floating-point unit holds state of this context.
    pub fpca: bool,
    pub fpscr: u32,
    /// Number of the running exception, 0 in a thread.
    pub ipsr: u16,
    /// Address marked by LDREX.
    pub exclusive: Option<u32>,
    /// Address of the next instruction.
    pub pc: u32,
    pub is_asleep: bool,
    pub instructions: u64,
    /// Decoded instructions with their size in bytes, one per half word of the flash.
    pub cache: Vec<(Op, u8)>,
}

impl Cpu {
    /// Creates a processor that has not started, for a flash of this size.
    pub fn new(flash_bytes: usize) -> Self {
        Self {
            r: [0; 17],
            s: [0; 33],
            n: false,
            z: false,
            c: false,
            v: false,
            q: false,
            it: 0,
            primask: false,
            faultmask: false,
            basepri: 0,
            fpca: false,
            fpscr: 0,
            ipsr: 0,
            exclusive: None,
            pc: 0,
            is_asleep: false,
            instructions: 0,
            cache: vec![UNKNOWN; flash_bytes / 2],
        }
    }

    pub fn holds(&self, condition: u8) -> bool {
        let base = match condition >> 1 {
            0 => self.z,
            1 => self.c,
            2 => self.n,
            3 => self.v,
            4 => self.c && !self.z,
            5 => self.n == self.v,
            6 => self.n == self.v && !self.z,
            _ => return true,
        };
        base != (condition & 1 != 0)
    }
}

/// Value of `it` while the last instruction of a block runs: bits 3 to 0 are zero, and no block has
/// this condition.
pub const LAST_OF_IT: u8 = 0xF0;
