//! Converts volts to codes of the 12-bit converter, within the slew limit.

use super::SAMPLE_HZ;
use crate::stimulus::Actuator;

/// Maximum code (RM0090, 14.3.5: 12 bits).
pub const CODE_MAX: u16 = 4095;

/// Computes the converter's code for each sample. The code starts at 0, as the converter does,
/// stays there until [`Self::rise`], and then rises no faster than a vibration fades in.
#[derive(Clone, Copy, Debug)]
pub struct Dac {
    code: u16,
    codes_a_volt: f32,
    /// Maximum step between samples, codes, from the actuator's slew rate.
    slew: u16,
    /// Maximum step, codes, after [`Dac::rise`] until the wanted voltage is reached.
    soft: u16,
    /// True while the code stays at 0.
    is_down: bool,
    /// True once the code has reached the wanted voltage after [`Dac::rise`].
    has_risen: bool,
}

impl Dac {
    pub fn new(actuator: &Actuator) -> Self {
        let codes_a_volt = f32::from(CODE_MAX) / actuator.voltage_v;
        // At least one code, because a slower actuator would never move.
        let step = |v_s: f32| ((v_s / SAMPLE_HZ as f32 * codes_a_volt) as u16).clamp(1, CODE_MAX);
        // Reaches the middle of the actuator's range in the fade-in time of a vibration.
        let soft = step(actuator.slew_v_s.min(actuator.bias_v() / actuator.fade_s));
        Self {
            code: 0,
            codes_a_volt,
            slew: step(actuator.slew_v_s),
            soft,
            is_down: true,
            has_risen: false,
        }
    }

    /// Returns the same code and state with the limits of `actuator`.
    pub fn with(self, actuator: &Actuator) -> Self {
        Self {
            code: self.code,
            is_down: self.is_down,
            has_risen: self.has_risen,
            ..Self::new(actuator)
        }
    }

    /// Lets the code follow the wanted voltage from now on.
    pub fn rise(&mut self) {
        self.is_down = false;
    }

    /// Returns the code of the next sample. `volts` is the wanted voltage, from 0 to the actuator's
    /// maximum.
    pub fn next(&mut self, volts: f32) -> u16 {
        // A NaN would become 0, but the stimulus makes none.
        let wanted = if self.is_down {
            0
        } else {
            (volts * self.codes_a_volt + 0.5) as u16
        };
        let wanted = wanted.min(CODE_MAX);
        let max = if self.has_risen { self.slew } else { self.soft };
        self.code = wanted
            .max(self.code.saturating_sub(max))
            .min(self.code.saturating_add(max));
        self.has_risen |= self.code == wanted && !self.is_down;
        self.code
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_rises_in_the_fade_and_no_step_is_more_than_the_slew() {
        let mut dac = Dac::new(&Actuator::PIEZO);
        assert_eq!([dac.next(75.0), dac.next(150.0)], [0, 0], "it waits");
        dac.rise();
        let codes: [u16; 250] = core::array::from_fn(|_| dac.next(75.0));
        // 20 ms are 200 samples for 2048 codes.
        assert!(codes.windows(2).all(|pair| pair[1] - pair[0] <= 10));
        assert_eq!((codes[0], codes[204], codes[249]), (10, 2048, 2048));
        for (volts, code) in [(0.0, 0), (150.0, 4095), (10.0, 273)] {
            let settled = (0..1000).map(|_| dac.next(volts)).last();
            assert_eq!(settled, Some(code), "{volts}");
        }
        // The step is at least one code, however slow the actuator.
        let mut slow = Dac::new(&Actuator {
            slew_v_s: 1.0,
            ..Actuator::PIEZO
        });
        slow.rise();
        assert_eq!([slow.next(75.0), slow.next(75.0)], [1, 2]);
    }
}
