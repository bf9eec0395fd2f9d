//! Nyquist limit and aliases.

/// Minimum distance of a line from zero and from half the frame rate, cycles per window.
const CLEAR_CYCLES: f32 = 0.5;

/// Band of frequencies, cycles per window.
#[derive(Clone, Copy, Debug)]
pub struct Nyquist {
    /// Half the frame rate.
    pub max: f32,
    /// True if frames are evenly spaced: a line above half the frame rate appears as an alias
    /// below.
    pub aliases: bool,
}

impl Nyquist {
    pub const NONE: Self = Self {
        max: 0.0,
        aliases: false,
    };

    /// Apparent frequency of a line.
    pub fn seen(&self, cycles: f32) -> f32 {
        // Below half the frame rate nothing is aliased.
        if self.aliases && cycles.abs() >= self.max {
            (cycles - 2.0 * self.max * libm::roundf(0.5 * cycles / self.max)).abs()
        } else if self.aliases {
            cycles.abs()
        } else {
            cycles
        }
    }

    /// True if a line appears clear of zero and of half the frame rate.
    pub fn is_clear(&self, cycles: f32) -> bool {
        let seen = self.seen(cycles);
        seen > CLEAR_CYCLES && seen < self.max - CLEAR_CYCLES
    }
}
