//! The stack's greatest depth. Start-up paints the stack (cortex-m-rt's `paint-stack`); the lowest word that has lost its
//! paint is the depth.

/// What start-up writes into every word of the stack.
pub const PAINT: u32 = 0xcccc_cccc;

/// Words in one step, about 40 instructions: 32 KiB take 1024 steps, a fifth of a second at one step for each conversion.
/// Interrupts need not be masked.
const STEP_WORDS: usize = 8;

/// Searches a painted stack, some words at a time.
#[derive(Debug, Default)]
pub struct DepthMeter {
    /// Next word, from the stack's far end.
    next: usize,
    /// Words at the far end that were never used, by the last complete search.
    free: Option<usize>,
}

impl DepthMeter {
    /// Nothing searched.
    pub const fn new() -> Self {
        Self { next: 0, free: None }
    }

    /// Searches the next few of `words` words, which `word` reads by their number from the far end. Gives the most bytes
    /// that were in use since start-up, by the last complete search; zero before that.
    pub fn step(&mut self, words: usize, word: impl Fn(usize) -> u32) -> u32 {
        // A used word stays used, so it is not searched again.
        let free = self.free.unwrap_or(words);
        let until = free.min(self.next.saturating_add(STEP_WORDS));
        match (self.next..until).find(|at| word(*at) != PAINT) {
            Some(used) => (self.free, self.next) = (Some(used), 0),
            None if until == free => (self.free, self.next) = (Some(free), 0),
            None => self.next = until,
        }
        self.free.map_or(0, |free| 4 * words.saturating_sub(free) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes in use after a complete search.
    fn search(meter: &mut DepthMeter, stack: &[u32]) -> u32 {
        let mut used_bytes = 0;
        for _ in 0..2 * stack.len() / STEP_WORDS + 2 {
            used_bytes = meter.step(stack.len(), |at| stack[at]);
        }
        used_bytes
    }

    #[test]
    fn the_deepest_word_counts_and_not_the_gaps_above_it() {
        let mut stack = [PAINT; 1000];
        let mut meter = DepthMeter::new();
        assert_eq!(search(&mut meter, &stack), 0);
        for (deepest, used_bytes) in [(999, 4), (600, 1600), (601, 1600), (77, 3692), (0, 4000)] {
            stack[deepest] = 0;
            assert_eq!(search(&mut meter, &stack), used_bytes);
        }
        assert_eq!(search(&mut DepthMeter::new(), &stack), 4000, "by one that has seen nothing before");
    }

    #[test]
    fn a_step_is_short_and_a_depth_once_seen_stays() {
        let mut stack = [PAINT; 1000];
        stack[500] = 1;
        let (mut meter, looks) = (DepthMeter::new(), core::cell::Cell::new(0));
        let mut before = 0;
        for _ in 0..1000 {
            looks.set(0);
            let used_bytes = meter.step(stack.len(), |at| {
                looks.set(looks.get() + 1);
                stack[at]
            });
            assert!(looks.get() <= STEP_WORDS && used_bytes >= before);
            before = used_bytes;
        }
        assert_eq!(before, 2000);
    }

    #[test]
    fn a_stack_of_no_words_is_none() {
        assert_eq!(DepthMeter::new().step(0, |_| unreachable!()), 0);
    }
}
