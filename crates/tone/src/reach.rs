//! Which frequencies frames tell apart.

/// Minimum distance of a line from zero and from half the frame rate, cycles per window.
const CLEAR_CYCLES: f32 = 0.5;

/// Band of frequencies, cycles per window.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Half the frame rate.
    pub most: f32,
    /// True if frames are evenly spaced: a line above half their rate is seen as one below.
    pub folds: bool,
}

impl Reach {
    /// Zeros.
    pub const NONE: Self = Self {
        most: 0.0,
        folds: false,
    };

    /// Apparent frequency of a line.
    pub fn seen(&self, cycles: f32) -> f32 {
        // Nothing is folded below half the frame rate.
        if self.folds && cycles.abs() >= self.most {
            (cycles - 2.0 * self.most * libm::roundf(0.5 * cycles / self.most)).abs()
        } else if self.folds {
            cycles.abs()
        } else {
            cycles
        }
    }

    /// True if a line is seen clear of zero and of half the frame rate.
    pub fn is_clear(&self, cycles: f32) -> bool {
        let seen = self.seen(cycles);
        seen > CLEAR_CYCLES && seen < self.most - CLEAR_CYCLES
    }
}
