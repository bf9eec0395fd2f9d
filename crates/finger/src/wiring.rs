//! What a board's wiring adds to its settings. It does not travel: the board's file says it.

use crate::converter::{Ads1258Plan, Facts};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;

/// What a board's wiring adds to its settings.
#[derive(Clone, Copy, Debug)]
pub struct Wiring {
    /// The converter.
    pub converter: &'static Facts,
    /// Low-pass before each input.
    pub low_pass: LowPass,
}

/// A low-pass of first order. A robot's places are to be those of its delay earlier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass {
    /// Delay of slow tones, seconds: its resistance times its capacitance.
    pub delay_s: f32,
    /// Standard deviation of the delay as a share of it.
    pub delay_sigma: f32,
}

impl LowPass {
    /// No low-pass.
    pub const NONE: Self = Self {
        delay_s: 0.0,
        delay_sigma: 0.0,
    };

    /// A resistance, and a capacitance that is anywhere within a share of the printed one: an even
    /// distribution, whose standard deviation is that share over the root of three.
    pub const fn of_parts(resistance_ohm: f32, capacitance_f: f32, tolerance: f32) -> Self {
        Self {
            delay_s: resistance_ohm * capacitance_f,
            delay_sigma: 0.58 * tolerance,
        }
    }

    /// Standard deviation of the delay, seconds.
    pub const fn sigma_s(self) -> f32 {
        self.delay_s * self.delay_sigma
    }
}

impl Wiring {
    /// The wiring of the guide: an ADS1258 behind the paper's bridges, 820 ohm beside 820 ohm, and
    /// 1 uF within 10 %.
    pub const GUIDE: Self = Self {
        converter: &Facts {
            name: "ADS1258",
            plan: Plan::PAPER,
            vref_v: Settings::DEFAULT.vref_v,
            check: Ads1258Plan::check,
        },
        low_pass: LowPass::of_parts(0.5 * 820.0, 1e-6, 0.1),
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_guides_low_pass_is_that_of_its_parts() {
        let LowPass {
            delay_s,
            delay_sigma,
        } = Wiring::GUIDE.low_pass;
        assert!((delay_s - 0.41e-3).abs() < 1e-9);
        assert!((delay_sigma - 0.1 / 3f32.sqrt()).abs() < 5e-4);
    }
}
