//! `idle`: measures the load and the stack, and detects the end of the run.

use super::outbox::Outbox;
use super::shared::Shared;
use core::sync::atomic::Ordering::Relaxed;
use ridgetone_proto::telemetry::Events;
use rtic_core::Mutex;

/// Period of the load measurement, microseconds: one second, as for `health`.
const PERIOD_US: u32 = 1_000_000;
/// Pattern that start-up writes into every word of the stack (cortex-m-rt's `paint-stack`). The
/// lowest word without it marks the greatest depth.
pub const PAINT: u32 = 0xcccc_cccc;
/// Number of words searched per step, in about 40 instructions. At one step per conversion, 32 KiB
/// take a fifth of a second.
const STEP_WORDS: usize = 8;

/// Next action of the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Next {
    /// Sleep until the next interrupt.
    Sleep,
    /// Reset because of a request. The last two bytes are still being sent.
    Restart,
    /// The signal is over, and all its events have been sent.
    Leave,
}

/// A sleep, by the microsecond counter.
#[derive(Clone, Copy, Debug)]
pub struct Slept {
    /// Start of the sleep.
    pub from_us: u32,
    /// End of the sleep.
    pub until_us: u32,
}

/// Size and content of the stack, for the meter.
pub struct Stack<F> {
    /// Size, in words.
    pub words: usize,
    /// Reads a word by its number, counted from the far end.
    pub word: F,
}

/// State that only this task uses.
#[derive(Debug, Default)]
pub struct Idle {
    load: LoadMeter,
    depth: DepthMeter,
}

impl Idle {
    /// Starts without measurements.
    pub const fn new() -> Self {
        Self {
            load: LoadMeter {
                began_us: 0,
                asleep_us: 0,
            },
            depth: DepthMeter::new(),
        }
    }

    /// Runs after each sleep. Returns the board's next action.
    pub fn run<P, E: Events>(
        &mut self,
        slept: Slept,
        stack: Stack<impl Fn(usize) -> u32>,
        outbox: &mut impl Mutex<T = Outbox<E>>,
        shared: &Shared<P>,
    ) -> Next {
        let diagnostics = &shared.diagnostics;
        if let Some(load) = self.load.slept(slept.from_us, slept.until_us) {
            diagnostics.load_bits.store(load.to_bits(), Relaxed);
        }
        let [used_bytes, size_bytes] = &diagnostics.stack;
        used_bytes.store(self.depth.step(stack.words, stack.word), Relaxed);
        size_bytes.store(4 * stack.words as u32, Relaxed);
        // No interrupt is pending here, so no window is being fitted.
        let next = match (shared.is_restarting(), shared.finished.load(Relaxed)) {
            (true, _) => Next::Restart,
            (false, true) => Next::Leave,
            (false, false) => return Next::Sleep,
        };
        let is_silent = !shared.sending.load(Relaxed) && outbox.lock(|outbox| outbox.is_empty());
        if is_silent { next } else { Next::Sleep }
    }
}

/// Adds up sleep and turns it into a load. The first period begins when the microsecond counter
/// starts.
#[derive(Debug, Default)]
struct LoadMeter {
    began_us: u32,
    asleep_us: u32,
}

impl LoadMeter {
    /// Adds a sleep from `from_us` to `to_us` on the wrapping microsecond counter. If a period is
    /// over, returns its load, 0 to 1.
    fn slept(&mut self, from_us: u32, to_us: u32) -> Option<f32> {
        self.asleep_us += to_us.wrapping_sub(from_us);
        let elapsed_us = to_us.wrapping_sub(self.began_us);
        if elapsed_us < PERIOD_US {
            return None;
        }
        let load = 1.0 - self.asleep_us as f32 / elapsed_us as f32;
        *self = Self {
            began_us: to_us,
            asleep_us: 0,
        };
        Some(load.clamp(0.0, 1.0))
    }
}

/// Searches a painted stack, a few words at a time.
#[derive(Debug, Default)]
pub struct DepthMeter {
    /// Next word, from the stack's far end.
    next: usize,
    /// Number of words never used, from the last complete search.
    free: Option<usize>,
}

impl DepthMeter {
    /// Starts at the far end.
    pub const fn new() -> Self {
        Self {
            next: 0,
            free: None,
        }
    }

    /// Searches the next few of `words` words, which `word` reads by number from the far end.
    /// Returns the maximum number of bytes in use since start-up, from the last complete search;
    /// zero before that.
    pub fn step(&mut self, words: usize, word: impl Fn(usize) -> u32) -> u32 {
        // A used word stays used, so it is not searched again.
        let free = self.free.unwrap_or(words);
        let until = free.min(self.next.saturating_add(STEP_WORDS));
        match (self.next..until).find(|at| word(*at) != PAINT) {
            Some(used) => (self.free, self.next) = (Some(used), 0),
            None if until == free => (self.free, self.next) = (Some(free), 0),
            None => self.next = until,
        }
        self.free
            .map_or(0, |free| 4 * words.saturating_sub(free) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn load_is_the_share_of_time_awake() {
        let mut meter = LoadMeter::default();
        assert_eq!(meter.slept(100_000, 500_000), None);
        assert_eq!(meter.slept(650_000, 1_000_000), Some(0.25));
        assert_eq!(meter.slept(1_000_000, 1_500_000), None);
        assert_eq!(meter.slept(2_000_000, 2_000_000), Some(0.5));
    }

    #[test]
    fn the_counter_may_wrap() {
        let mut meter = LoadMeter {
            began_us: u32::MAX - 499_999,
            asleep_us: 0,
        };
        assert_eq!(meter.slept(u32::MAX, 499_999), None);
        assert_eq!(meter.slept(500_000, 500_000), Some(0.5));
    }

    /// Returns the bytes in use after a complete search.
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
        assert_eq!(
            search(&mut DepthMeter::new(), &stack),
            4000,
            "by one that has seen nothing before"
        );
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
