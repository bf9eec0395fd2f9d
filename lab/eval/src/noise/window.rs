//! A window that is made of parts: noise, a tone, how its speed goes, and something else.

use super::parts::{Extra, Sound, Speed, Tone, add_baseline, add_tone, add_waves, frequencies};
use super::process::{self, Covariance, Noise};
use crate::draw::Draw;
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;
use std::f64::consts::FRAC_1_SQRT_2;

/// Codes of a standard deviation of the noise: rounding to whole codes is far below it.
const CODES_PER_SIGMA: f64 = 1000.0;
/// Frequency of mains as the estimator is given it, and in truth, hertz.
const MAINS_HZ: (f64, f64) = (50.0, 49.5);
/// The rail above the level of a saturated channel, amplitudes of the tone.
const RAIL: f64 = 0.3;

#[derive(Clone, Debug, Default)]
pub struct Window {
    pub values: Vec<Values>,
    /// Step of the values' rounding.
    pub step: f32,
    /// Mean of the frequency over the window, cycles per frame; none without a tone.
    pub mean: Option<f64>,
    /// RMS of the frequency about its mean, as a share of it.
    pub wander: f64,
    /// Change of the frequency, cycles per frame, in each frame; none if it wanders.
    pub chirp: Option<f64>,
    /// A second tone, cycles per frame.
    pub second: Option<f64>,
    /// The interferer that the estimator is given, cycles per frame.
    pub interferer: Option<f64>,
    /// What the bound needs; none where there is none.
    pub truth: Option<Truth>,
}

/// What the bound of a steady tone needs, in standard deviations of the noise.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The tone's derivative by the frequency in cycles per frame.
    pub derivative: Vec<[f64; TAXELS]>,
    pub values: Vec<[f64; TAXELS]>,
    pub covariance: Covariance,
    /// Baselines beside level and slope, of an unknown size in each channel.
    pub shapes: Vec<Vec<f64>>,
    pub harmonics: usize,
    /// Variance of rounding.
    pub rounding: f64,
}

/// The parts of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    pub noise: Noise,
    pub tone: Option<Tone>,
    pub extra: Extra,
}

impl Recipe {
    /// A window of `count` frames.
    pub fn make(&self, count: usize, rate_hz: f64, draw: &mut Draw) -> Window {
        let (mut frames, covariance) = process::frames(self.noise, count, rate_hz, draw);
        let mut window = Window {
            step: 1.0,
            chirp: Some(0.0),
            ..Window::default()
        };
        // The strongest harmonic's, in standard deviations of the noise.
        let amplitude = self
            .tone
            .map_or(1.0, |tone| 10f64.powf(tone.snr_db / 20.0) / FRAC_1_SQRT_2);
        let mut derivative = Vec::new();
        if let Some(tone) = self.tone {
            let frequencies = frequencies(&tone, count, rate_hz, draw);
            let mean = frequencies.iter().sum::<f64>() / count as f64;
            window.mean = Some(mean);
            let square = frequencies
                .iter()
                .map(|f| (f / mean - 1.0).powi(2))
                .sum::<f64>()
                / count as f64;
            window.wander = square.sqrt();
            window.chirp = match tone.speed {
                Speed::Steady => Some(0.0),
                Speed::Wander(_) => None,
                Speed::Chirp(_) => frequencies.get(..2).map(|first| first[1] - first[0]),
            };
            derivative = add_tone(
                &mut frames,
                Sound {
                    frequencies: &frequencies,
                    harmonics: &tone.harmonics,
                    amplitude,
                },
                self.extra,
                draw,
            );
            let times = match self.extra {
                Extra::SecondTone => [1.25, 1.4, 1.6, 2.4, 2.6]
                    .get(draw.whole(0, 4) as usize)
                    .copied(),
                Extra::CloseTone(least, most) => {
                    Some(1.0 + draw.even(least, most) / (mean * count as f64))
                }
                _ => None,
            };
            if let Some(times) = times {
                let second: Vec<f64> = frequencies.iter().map(|f| times * f).collect();
                add_tone(
                    &mut frames,
                    Sound {
                        frequencies: &second,
                        harmonics: &tone.harmonics,
                        amplitude,
                    },
                    Extra::Nothing,
                    draw,
                );
                window.second = Some(times * mean);
            }
        }
        let shapes = add_baseline(&mut frames, self.extra, amplitude, draw);
        let gains: [f64; TAXELS] = std::array::from_fn(|c| {
            if self.extra == Extra::Gains {
                10f64.powf(4.0 * c as f64 / 15.0 - 2.0)
            } else {
                1.0
            }
        });
        let offsets: [f64; TAXELS] = std::array::from_fn(|_| draw.even(-2e5, 2e5).round());
        if let Extra::Mains(size) = self.extra {
            window.interferer = Some(MAINS_HZ.0 / rate_hz);
            add_waves(&mut frames, MAINS_HZ.1 / rate_hz, size * amplitude, draw);
        }
        let step = if let Extra::Rounded(share) = self.extra {
            (share * amplitude * CODES_PER_SIGMA).round()
        } else {
            1.0
        };
        let is_flat = |c: usize| match self.extra {
            Extra::DeadChannels => c < 3,
            Extra::Channels(alive) => c >= alive,
            Extra::Saturated => (3..5).contains(&c),
            _ => false,
        };
        let value = |frame: &[f64; TAXELS], c: usize| {
            if is_flat(c) {
                return offsets[c] as f32;
            }
            let most = if self.extra == Extra::Saturated && c < 3 {
                RAIL * amplitude
            } else {
                f64::INFINITY
            };
            let value = offsets[c] + CODES_PER_SIGMA * gains[c] * frame[c].min(most);
            ((value / step).round() * step) as f32
        };
        window.values = frames
            .iter()
            .map(|frame| std::array::from_fn(|c| value(frame, c)))
            .collect();
        window.step = step as f32;
        derivative
            .iter_mut()
            .flat_map(|frame| frame.iter_mut().enumerate())
            .for_each(|(c, value)| {
                *value = if is_flat(c) { 0.0 } else { *value };
            });
        let in_sigmas = |frame: &Values| {
            std::array::from_fn(|c| f64::from(frame[c]) / CODES_PER_SIGMA / gains[c])
        };
        let steady = self
            .tone
            .filter(|tone| tone.speed == Speed::Steady && self.extra.has_bound());
        window.truth = steady.zip(covariance).map(|(tone, covariance)| Truth {
            derivative,
            values: window.values.iter().map(in_sigmas).collect(),
            covariance,
            shapes,
            harmonics: 1 + tone
                .harmonics
                .iter()
                .rposition(|relative| *relative > 0.0)
                .unwrap_or(0),
            rounding: (step / CODES_PER_SIGMA).powi(2) / 12.0,
        });
        window
    }
}

impl Extra {
    /// Whether what it adds is linear in unknowns, so that the bound counts it.
    fn has_bound(self) -> bool {
        use Extra::{Channels, DeadChannels, Gains, LogCreep, Nothing, Relaxations, Rounded};
        matches!(
            self,
            Nothing
                | Relaxations(..)
                | LogCreep(_)
                | Rounded(_)
                | Gains
                | DeadChannels
                | Channels(_)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TONE: Tone = Tone {
        cycles: (4.0, 4.0),
        harmonics: [1.0, 0.0, 0.0, 0.0, 0.0],
        snr_db: 20.0,
        speed: Speed::Steady,
    };

    /// Channel power in squared standard deviations of the noise.
    fn power(recipe: Recipe) -> f64 {
        let window = recipe.make(480, 241.14, &mut Draw::new(9));
        let sum = |c: usize| {
            let mean = window.values.iter().map(|v| f64::from(v[c])).sum::<f64>() / 480.0;
            window
                .values
                .iter()
                .map(|v| ((f64::from(v[c]) - mean) / CODES_PER_SIGMA).powi(2))
                .sum::<f64>()
                / 480.0
        };
        (0..TAXELS).map(sum).sum::<f64>() / TAXELS as f64
    }

    #[test]
    fn a_tone_has_the_power_that_its_decibels_say() {
        let recipe = Recipe {
            noise: Noise::White,
            tone: Some(TONE),
            extra: Extra::Nothing,
        };
        // Gains of 0.5 to 1.5 have a mean square of 13 / 12.
        let relative = (power(recipe) - 1.0) / (100.0 * 13.0 / 12.0);
        assert!((0.8..1.2).contains(&relative), "{relative}");
        let noise = power(Recipe {
            tone: None,
            ..recipe
        });
        assert!((0.9..1.1).contains(&noise), "{noise}");
    }

    #[test]
    fn the_means_of_a_chirp_and_of_a_wander_are_those_of_its_frequencies() {
        let speed = Speed::Chirp(0.1);
        let recipe = Recipe {
            noise: Noise::White,
            tone: Some(Tone { speed, ..TONE }),
            extra: Extra::Nothing,
        };
        let window = recipe.make(480, 241.14, &mut Draw::new(2));
        let mean = window.mean.expect("a tone");
        assert!((mean * 480.0 / 4.0 - 1.0).abs() < 2e-4, "{mean}");
        let speed = Speed::Wander(0.05);
        let wander = Recipe {
            tone: Some(Tone { speed, ..TONE }),
            ..recipe
        }
        .make(480, 241.14, &mut Draw::new(2));
        let off = wander.mean.expect("a tone") * 480.0 / 4.0 - 1.0;
        assert!(off.abs() > 1e-4 && off.abs() < 0.1, "{off}");
    }
}
