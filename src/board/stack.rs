//! The stack's place in memory: start-up fills it with a pattern (cortex-m-rt's `paint-stack`).

use ridgetone::tasks::stack_depth::DepthMeter;

unsafe extern "C" {
    /// Lowest address of the stack, from `memory.x`.
    static _stack_end: u32;
    /// Its highest, where it starts, from `memory.x`.
    static _stack_start: u32;
}

/// Lowest address, and the first behind the highest.
fn bounds() -> (usize, usize) {
    (&raw const _stack_end as usize, &raw const _stack_start as usize)
}

/// The stack's size, bytes.
pub fn size_bytes() -> u32 {
    let (low, high) = bounds();
    high.saturating_sub(low) as u32
}

/// Looks at a few more words of it; gives the most that was in use since start-up, bytes, as far as it is known.
pub fn look(meter: &mut DepthMeter) -> u32 {
    let words = size_bytes() as usize / 4;
    // SAFETY: `at` is less than `words`, and from `_stack_end` on that many words are RAM, aligned; they are read only.
    meter.step(words, |at| unsafe { (&raw const _stack_end).add(at).read_volatile() })
}

/// Whether all of what `place` points to lies in it.
pub fn holds<T>(place: *const T) -> bool {
    let (low, high) = bounds();
    (low..=high.saturating_sub(size_of::<T>())).contains(&(place as usize)) && place.is_aligned()
}

/// The most that was in use since start-up, bytes: all of it looked at, at once.
#[cfg(feature = "emulated")]
pub fn use_bytes() -> u32 {
    let mut meter = DepthMeter::new();
    (0..size_bytes()).fold(0, |_, _| look(&mut meter))
}
