//! The stack's place in memory: start-up fills it with a pattern (cortex-m-rt's `paint-stack`).

unsafe extern "C" {
    /// Lowest address of the stack, from `memory.x`.
    static _stack_end: u32;
    /// Highest, where it starts, from `memory.x`.
    static _stack_start: u32;
}

/// Lowest address, and the first behind the highest.
fn bounds() -> (usize, usize) {
    (
        &raw const _stack_end as usize,
        &raw const _stack_start as usize,
    )
}

/// The stack's size in words.
pub fn words() -> usize {
    let (low, high) = bounds();
    high.saturating_sub(low) / 4
}

/// A word of the stack, by its number from the lowest address; zero beyond the stack.
pub fn word(at: usize) -> u32 {
    if at >= words() {
        return 0;
    }
    // SAFETY: from `_stack_end` on that many words are RAM, aligned; they are read only.
    unsafe { (&raw const _stack_end).add(at).read_volatile() }
}

/// True if the whole value behind `place` lies in the stack.
pub fn holds<T>(place: *const T) -> bool {
    let (low, high) = bounds();
    (low..=high.saturating_sub(size_of::<T>())).contains(&(place as usize)) && place.is_aligned()
}
