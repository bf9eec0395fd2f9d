//! From volts to codes of the 12-bit converter. A code is never farther from the last one than the
//! slew allows.

use super::SAMPLE_HZ;
use crate::stimulus::Actuator;

/// Maximum code (RM0090, 14.3.5: 12 bits).
pub const CODE_MAX: u16 = 4095;

/// Makes the converter's code for each sample. The code starts at 0, as the converter's does, stays
/// there until [`Self::rise`], and then rises no faster than a vibration fades in.
#[derive(Clone, Copy, Debug)]
pub struct Dac {
    code: u16,
    codes_a_volt: f32,
    /// Maximum step from one sample to the next, codes, by the actuator's slew rate.
    slew: u16,
    /// Maximum step, codes, after [`Dac::rise`] until the wanted voltage is reached, and after [`Dac::fall`].
    soft: u16,
    /// The code falls to 0 or stays there.
    is_down: bool,
    /// The code has reached the wanted voltage since [`Dac::rise`].
    has_risen: bool,
}

impl Dac {
    /// At code 0.
    pub fn new(actuator: &Actuator) -> Self {
        let codes_a_volt = f32::from(CODE_MAX) / actuator.voltage_v;
        // At least one code: a slower actuator would never move.
        let step = |v_s: f32| ((v_s / SAMPLE_HZ as f32 * codes_a_volt) as u16).clamp(1, CODE_MAX);
        // It reaches the middle of the actuator's range in the time in which a vibration fades in.
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

    /// This code and state with the limits of `actuator`.
    pub fn with(self, actuator: &Actuator) -> Self {
        Self {
            code: self.code,
            is_down: self.is_down,
            has_risen: self.has_risen,
            ..Self::new(actuator)
        }
    }

    /// From now on the code follows the wanted voltage.
    pub fn rise(&mut self) {
        self.is_down = false;
    }

    /// From now on the code falls to 0.
    pub fn fall(&mut self) {
        (self.is_down, self.has_risen) = (true, false);
    }

    /// True if the code is 0 and stays 0.
    pub const fn is_down(&self) -> bool {
        self.is_down && self.code == 0
    }

    /// The code of the next sample. `volts`: the wanted voltage, from 0 to the actuator's maximum.
    pub fn next(&mut self, volts: f32) -> u16 {
        // A NaN would become 0; the stimulus has none.
        let wanted = if self.is_down {
            0
        } else {
            (volts * self.codes_a_volt + 0.5) as u16
        };
        let wanted = wanted.min(CODE_MAX);
        let most = if self.has_risen { self.slew } else { self.soft };
        self.code = wanted
            .max(self.code.saturating_sub(most))
            .min(self.code.saturating_add(most));
        self.has_risen |= self.code == wanted && !self.is_down;
        self.code
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_rises_in_the_fade_and_falls_in_it() {
        let mut dac = Dac::new(&Actuator::PIEZO);
        assert_eq!([dac.next(75.0), dac.next(150.0)], [0, 0], "it waits");
        dac.rise();
        let codes: [u16; 250] = core::array::from_fn(|_| dac.next(75.0));
        // 20 ms are 200 samples for 2048 codes.
        assert!(
            codes.windows(2).all(|pair| pair[1] - pair[0] <= 10),
            "{codes:?}"
        );
        assert_eq!((codes[0], codes[204], codes[249]), (10, 2048, 2048));
        dac.fall();
        let codes: [u16; 250] = core::array::from_fn(|_| dac.next(140.0));
        assert!(
            codes.windows(2).all(|pair| pair[0] - pair[1] <= 10),
            "{codes:?}"
        );
        assert!(dac.is_down());
    }

    #[test]
    fn no_step_is_more_than_the_slew() {
        // 1000 V/s are 0.1 V a sample, 2.73 codes.
        let mut dac = Dac::new(&Actuator {
            slew_v_s: 1000.0,
            ..Actuator::PIEZO
        });
        dac.rise();
        let mut last = 0;
        for n in 0..20_000 {
            let code = dac.next([0.0, 150.0, 75.0, f32::NAN, 1e9, -1e9][n / 3000 % 6]);
            assert!(
                code.abs_diff(last) <= 2 && code <= CODE_MAX,
                "{n}: {last} {code}"
            );
            last = code;
        }
        let mut slow = Dac::new(&Actuator {
            slew_v_s: 1.0,
            ..Actuator::PIEZO
        });
        slow.rise();
        assert_eq!(
            [slow.next(75.0), slow.next(75.0)],
            [1, 2],
            "a code at least"
        );
    }

    #[test]
    fn codes_are_those_of_the_voltage() {
        let mut dac = Dac::new(&Actuator::PIEZO);
        dac.rise();
        for (volts, code) in [(0.0, 0), (75.0, 2048), (150.0, 4095), (10.0, 273)] {
            let settled = (0..1000).map(|_| dac.next(volts)).last();
            assert_eq!(settled, Some(code), "{volts}");
        }
    }
}
