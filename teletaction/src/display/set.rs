//! A set of pins, a bit each: words that a 32-bit processor can shift.

/// Words of a set: 128 pins.
const WORDS: usize = 4;
/// Pins of a word.
const BITS: usize = u32::BITS as usize;

/// Some pins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Set([u32; WORDS]);

impl Set {
    pub(crate) const NONE: Self = Self([0; WORDS]);

    /// Those of the first `pins` pins for which `is_in` holds.
    pub(crate) fn of(pins: usize, is_in: impl Fn(usize) -> bool) -> Self {
        let mut set = Self::NONE;
        for pin in (0..pins).filter(|pin| is_in(*pin)) {
            set.flip(pin);
        }
        set
    }

    pub(crate) const fn has(&self, pin: usize) -> bool {
        self.0[pin / BITS % WORDS] >> (pin % BITS) & 1 != 0
    }

    /// Puts a pin in, or takes it out.
    pub(crate) const fn flip(&mut self, pin: usize) {
        self.0[pin / BITS % WORDS] ^= 1 << (pin % BITS);
    }

    /// Flips all pins of another set.
    pub(crate) fn flip_all(&mut self, pins: &Self) {
        self.0
            .iter_mut()
            .zip(pins.0)
            .for_each(|(word, pins)| *word ^= pins);
    }

    /// Takes all out but the one with the lowest number.
    pub(crate) fn keep_first(&mut self) {
        let mut keep = u32::MAX;
        for word in &mut self.0 {
            // Its lowest bit.
            *word &= word.wrapping_neg() & keep;
            if *word != 0 {
                keep = 0;
            }
        }
    }

    pub(crate) fn count(&self) -> usize {
        self.0.iter().map(|word| word.count_ones() as usize).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pins_go_in_and_out() {
        let mut set = Set::of(100, |pin| pin % 33 == 0);
        assert_eq!(
            (0..128)
                .filter(|pin| set.has(*pin))
                .collect::<std::vec::Vec<_>>(),
            [0, 33, 66, 99]
        );
        set.flip(33);
        set.flip(127);
        assert_eq!((set.has(33), set.has(127), set.count()), (false, true, 4));
        set.flip_all(&Set::of(128, |pin| pin == 127 || pin == 1));
        assert_eq!((set.has(127), set.has(1), set.count()), (false, true, 4));
        assert_eq!(Set::of(100, |_| true).count(), 100);
        for first in [0, 31, 32, 99, 127] {
            let mut set = Set::of(128, |pin| pin == first || pin > first + 20);
            set.keep_first();
            assert_eq!(set, Set::of(128, |pin| pin == first));
        }
    }
}
