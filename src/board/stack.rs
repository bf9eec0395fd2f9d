//! Position of the stack in memory; start-up fills the stack with a pattern (cortex-m-rt's
//! `paint-stack`).

unsafe extern "C" {
    /// Lowest address of the stack, from `memory.x`.
    static _stack_end: u32;
    /// Address above the stack, where it starts, from `memory.x`.
    static _stack_start: u32;
}

/// Lowest address of the stack, and the first address above it.
fn bounds() -> (usize, usize) {
    (
        &raw const _stack_end as usize,
        &raw const _stack_start as usize,
    )
}

pub fn words() -> usize {
    let (low, high) = bounds();
    high.saturating_sub(low) / 4
}

/// Reads a word of the stack, counted from the lowest address. Returns zero beyond the stack.
pub fn word(at: usize) -> u32 {
    if at >= words() {
        return 0;
    }
    // SAFETY: this many words from `_stack_end` on are aligned RAM; they are only read.
    unsafe { (&raw const _stack_end).add(at).read_volatile() }
}

/// True if the whole value at `place` is within the stack.
pub fn holds<T>(place: *const T) -> bool {
    let (low, high) = bounds();
    (low..=high.saturating_sub(size_of::<T>())).contains(&(place as usize)) && place.is_aligned()
}
