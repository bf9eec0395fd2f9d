//! A simulated network delay, to let a person feel its effect.

use super::error::{Error, within};

/// Time between draws of a varying delay, seconds (Okamoto et al., section V-B).
const REDRAWN_S: f64 = 0.2;

/// A delay: constant, or redrawn every 200 ms from a normal distribution truncated at 0 and at six
/// standard deviations.
#[derive(Clone, Copy, Debug)]
pub struct Delay {
    mean_s: f64,
    sigma_s: f64,
    state: u64,
    now_s: f64,
    drawn_s: Option<f64>,
}

impl Delay {
    /// Creates a delay with a mean of 0 to 1 s and a standard deviation of 0 to 0.5 s; the paper
    /// uses 0.12 s, and 0.12 +- 0.04 s. The same seed gives the same delays.
    pub fn new(mean_s: f32, sigma_s: f32, seed: u32) -> Result<Self, Error> {
        within("delay mean_s", mean_s, 0.0, 1.0)?;
        within("delay sigma_s", sigma_s, 0.0, 0.5)?;
        let state = (u64::from(seed) << 1 | 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        Ok(Self {
            mean_s: mean_s.into(),
            sigma_s: sigma_s.into(),
            state,
            now_s: mean_s.into(),
            drawn_s: None,
        })
    }

    /// Delay at `t_s`, seconds. Times must not decrease.
    pub fn at_s(&mut self, t_s: f64) -> f64 {
        if self.sigma_s > 0.0
            && !self
                .drawn_s
                .is_some_and(|drawn_s| t_s - drawn_s < REDRAWN_S)
        {
            self.drawn_s = Some(t_s);
            self.now_s = (self.mean_s + self.sigma_s * self.normal()).max(0.0);
        }
        self.now_s
    }

    /// Draws a nearly normal number: the sum of twelve uniform ones (variance 1/12 each), minus its
    /// mean.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.even()).sum::<f64>() - 6.0
    }

    /// Draws a uniform number from 0 to 1 with xorshift64* (Vigna, *An experimental exploration of
    /// Marsaglia's xorshift generators, scrambled*, 2016).
    fn even(&mut self) -> f64 {
        self.state ^= self.state >> 12;
        self.state ^= self.state << 25;
        self.state ^= self.state >> 27;
        (self.state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 40) as f64 / f64::from(1u32 << 24)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_have_their_mean_and_spread_and_hold_for_200_ms() {
        let mut constant = Delay::new(0.12, 0.0, 1).expect("a delay");
        assert!((0..9).all(|n| constant.at_s(f64::from(n)) == f64::from(0.12f32)));
        let mut delay = Delay::new(0.12, 0.04, 7).expect("a delay");
        let drawn: [f64; 4000] =
            core::array::from_fn(|n| delay.at_s(0.2 * n as f64 + 1e-6 * n as f64));
        let mean = drawn.iter().sum::<f64>() / 4000.0;
        let variance = drawn.iter().map(|d| (d - mean) * (d - mean)).sum::<f64>() / 4000.0;
        // The standard errors are 0.6 ms for the mean and 1.1 % for the spread.
        assert!(
            (mean - 0.12).abs() < 0.003 && (variance / 0.0016 - 1.0).abs() < 0.1,
            "{mean} {variance}"
        );
        let held = delay.at_s(9000.0);
        assert!(delay.at_s(9000.199) == held && delay.at_s(9000.201) != held);
        for (mean_s, sigma_s) in [
            (-0.1, 0.0),
            (f32::NAN, 0.0),
            (2.0, 0.0),
            (0.1, f32::NAN),
            (0.1, 0.6),
        ] {
            assert!(Delay::new(mean_s, sigma_s, 1).is_err());
        }
    }
}
