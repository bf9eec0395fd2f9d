//! Sets of lines: multiples 1 to 15 of a unit line.

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lines(u16);

impl Lines {
    pub const NONE: Self = Self(0);

    /// The lines 1 to `max`.
    pub fn up_to(max: usize) -> Self {
        (1..=max).fold(Self::NONE, Self::with)
    }

    pub fn with(self, number: usize) -> Self {
        Self(self.0 | 1 << (number & 15))
    }

    /// Union of two sets.
    pub fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Numbers of the lines, ascending.
    pub fn iter(self) -> impl Iterator<Item = usize> + Clone {
        let mut ahead = self.0;
        core::iter::from_fn(move || {
            let number = ahead.trailing_zeros();
            // Clear the lowest set bit.
            ahead &= ahead.checked_sub(1)?;
            Some(number as usize)
        })
    }

    pub fn count(self) -> usize {
        self.0.count_ones() as usize
    }

    pub fn has(self, number: usize) -> bool {
        number < 16 && self.0 >> number & 1 == 1
    }

    /// Index of a line in the set.
    pub fn index(self, number: usize) -> usize {
        let below = (1u32 << (number & 31)) - 1;
        (u32::from(self.0) & below).count_ones() as usize
    }

    /// Highest number; 0 if empty.
    pub fn max(self) -> usize {
        self.0.checked_ilog2().unwrap_or(0) as usize
    }

    pub fn divisor(self) -> usize {
        fn common(a: usize, b: usize) -> usize {
            if b == 0 { a } else { common(b, a % b) }
        }
        self.iter().fold(0, common)
    }

    pub fn times(self, factor: usize) -> Self {
        self.iter()
            .fold(Self::NONE, |lines, number| lines.with(number * factor))
    }

    pub fn over(self, divisor: usize) -> Self {
        self.iter().fold(Self::NONE, |lines, number| {
            lines.with(number / divisor.max(1))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_and_fourth_are_first_and_second_of_twice_the_unit() {
        let lines = Lines::NONE.with(4).with(2);
        assert_eq!((lines.count(), lines.max(), lines.divisor()), (2, 4, 2));
        assert_eq!(lines.over(2), Lines::up_to(2));
        assert_eq!((lines.index(4), lines.has(3)), (1, false));
        assert_eq!(Lines::up_to(3).divisor(), 1);
    }
}
