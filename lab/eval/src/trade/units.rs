//! Units of cost and of time.

/// Instructions of one pass of cosine and sine over 16 x 240 samples: the unit of costs.
pub const PASS_INSTRUCTIONS: f64 = 14_300.0;
/// Clock of the STM32F405, hertz.
pub const CLOCK_HZ: f64 = 168e6;
