//! The vibration under a hand that nobody moves, as samples.

use super::hand::Hand;
use super::output::Output;
use anyhow::Result;
use ridgetone_stimulus::{Delay, Texture};

/// Samples a second.
pub const RATE_HZ: u32 = 48_000;

/// Reports of the hand a second.
const REPORTS_HZ: u32 = 1000;

/// What is to be made.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    pub hand: Hand,
    pub delay: Delay,
    /// Frequency of a tone whose amplitude is the texture, hertz; none: the texture itself.
    pub carrier_hz: Option<f32>,
    pub seconds: f64,
}

/// Samples from -1 to 1, and what a haptic file needs of them.
#[derive(Clone, Debug)]
pub struct Rendered {
    pub samples: Vec<f32>,
    /// Amplitude over the greatest one, by sample.
    pub amplitudes: Vec<f32>,
}

/// Renders a texture. The vibration comes and goes within the actuator's fade, so that the last
/// sample is silent.
pub fn render(texture: &Texture, output: &Output, run: &Run) -> Result<Rendered> {
    let mut vibration = output.vibration(RATE_HZ as f32)?;
    vibration.set_texture(&output.counted(texture))?;
    vibration.set_delay(run.delay, 0.0)?;
    vibration.set_carrier(run.carrier_hz)?;
    let rate_hz = f64::from(RATE_HZ);
    let count = (run.seconds * rate_hz).round() as usize;
    // The slew may hold the end back; half of the fade more.
    let lifted = count.saturating_sub((1.5 * f64::from(output.actuator.fade_s) * rate_hz) as usize);
    let mut rendered = Rendered {
        samples: Vec::with_capacity(count),
        amplitudes: Vec::with_capacity(count),
    };
    vibration.down(0.0, run.hand.place_mm(0.0));
    for n in 0..count {
        let t_s = n as f64 / rate_hz;
        if n % (RATE_HZ / REPORTS_HZ) as usize == 0 {
            let ahead_s = t_s + 1.0 / f64::from(REPORTS_HZ);
            vibration.moved(ahead_s, run.hand.place_mm(ahead_s));
        }
        if n == lifted {
            vibration.lift();
        }
        rendered.samples.push(vibration.next(t_s));
        rendered.amplitudes.push(vibration.amplitude());
    }
    Ok(rendered)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_stimulus::Actuator;
    use std::f64::consts::TAU;

    fn rendered(hand: Hand, delay_s: f32) -> Rendered {
        let output = Output::new(Actuator::PIEZO, None).expect("an output");
        let run = Run {
            hand,
            delay: Delay::new(delay_s, 0.0, 1).expect("a delay"),
            carrier_hz: None,
            seconds: 2.0,
        };
        render(&Texture::new(1.4), &output, &run).expect("samples")
    }

    /// Equation 5 in f64, and equation 6 with its delay.
    #[test]
    fn samples_are_the_papers_equations() {
        let x = 1.4f64;
        let polynomial = 30770.0 * x.powi(4) - 162_663.0 * x.powi(3) + 309_743.0 * x * x
            - 248_938.0 * x
            + 72298.0;
        for delay_s in [0.0, 0.12] {
            let found = rendered(Hand::OKAMOTO, delay_s).samples;
            let mut worst = 0.0f64;
            for (n, y) in found.iter().enumerate().skip(9600).take(76_800) {
                let place_mm = Hand::OKAMOTO.place_mm(n as f64 / 48_000.0 - f64::from(delay_s));
                worst = worst
                    .max((f64::from(*y) - polynomial / 6000.0 * (TAU * place_mm / x).sin()).abs());
            }
            assert!(worst < 0.02, "{delay_s}: {worst}");
        }
    }

    #[test]
    fn it_begins_and_ends_softly() {
        let Rendered {
            samples,
            amplitudes,
        } = rendered(
            Hand {
                speed_mm_s: 140.0,
                turns_hz: 0.0,
            },
            0.0,
        );
        assert_eq!((samples.len(), amplitudes.len()), (96_000, 96_000));
        assert!(
            samples[..10]
                .iter()
                .chain(&samples[95_990..])
                .all(|y| y.abs() < 0.01)
        );
        let slew = Actuator::PIEZO.slew_v_s / 75.0 / 48_000.0;
        assert!(
            samples
                .windows(2)
                .all(|pair| (pair[1] - pair[0]).abs() <= slew + 1e-6)
        );
    }
}
