//! How deep the stack has been: start-up fills it with a pattern (cortex-m-rt's `paint-stack`).

/// What start-up writes into every word of the stack.
const PAINT: u32 = 0xcccc_cccc;

unsafe extern "C" {
    /// Lowest address of the stack, from `memory.x`.
    static _stack_end: u32;
    /// Its highest, where it starts, from `memory.x`.
    static _stack_start: u32;
}

/// The most that was in use since start-up, and the stack's size, bytes.
pub fn use_bytes() -> (usize, usize) {
    let (low, high) = (&raw const _stack_end, &raw const _stack_start);
    let size = (high as usize).saturating_sub(low as usize);
    let mut word = low;
    // SAFETY: from `low` up to `high` there is RAM, aligned to words; it is read only.
    while word < high && unsafe { word.read_volatile() } == PAINT {
        word = word.wrapping_add(1);
    }
    ((high as usize).saturating_sub(word as usize), size)
}
