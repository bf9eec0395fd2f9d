//! Both estimators on a recording.

use super::recording::Recording;
use ridgetone_estimator as new;
use ridgetone_tone as old;

/// Harmonics that a fit may use.
const HARMONICS: u8 = 4;

/// Which one.
#[derive(Clone, Copy, Debug)]
pub enum Estimator {
    Old,
    New,
}

/// What it says.
#[derive(Clone, Debug)]
pub struct Answer {
    pub status: String,
    pub is_good: bool,
    pub frequency: f64,
    pub sigma: f64,
}

impl Estimator {
    pub const BOTH: [Self; 2] = [Self::Old, Self::New];

    /// Fits a recording by its abscissa.
    pub fn fit(self, recording: &Recording) -> Answer {
        let channels = recording.channels();
        let first = recording.values.first().cloned().unwrap_or_default();
        let row = |row: &Vec<f64>| {
            let values = row
                .iter()
                .zip(&first)
                .map(|(value, first)| (value - first) as f32);
            values.collect::<Vec<_>>()
        };
        let values: Vec<f32> = recording.values.iter().flat_map(row).collect();
        let start = recording.abscissa.first().copied().unwrap_or(0.0);
        let place = |frame: u32| {
            let x = recording.abscissa.get(frame as usize);
            x.map_or(f32::NAN, |x| (x - start) as f32)
        };
        let count = recording.rows() as u32;
        match self {
            Self::Old => {
                let frames = old::Frames::new(&values, channels);
                let fitted = frames.and_then(|mut frames| {
                    let span = old::FrameSpan::new(&mut frames, 0, count);
                    old::Fitter::new(HARMONICS)
                        .fit(&mut span.along(&place)?)
                        .ok()
                });
                fitted.map_or_else(Answer::none, |fit| {
                    let is_good = fit.status == old::Status::Good;
                    Answer::new(
                        format!("{:?}", fit.status),
                        is_good,
                        fit.frequency,
                        fit.sigma,
                    )
                })
            }
            Self::New => {
                let frames = new::Frames::new(&values, channels);
                let fitted = frames.and_then(|mut frames| {
                    let span = new::FrameSpan::new(&mut frames, 0, count);
                    let scene = new::Scene {
                        harmonics: HARMONICS,
                        ..new::Scene::DEFAULT
                    };
                    new::Fitter::new()
                        .fit(&mut span.along(&place)?, &scene)
                        .ok()
                });
                fitted.map_or_else(Answer::none, |fit| {
                    let is_good = fit.status == new::Status::Good;
                    Answer::new(
                        format!("{:?}", fit.status),
                        is_good,
                        fit.frequency,
                        fit.sigma,
                    )
                })
            }
        }
    }
}

impl std::fmt::Display for Estimator {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Self::Old => "`ridgetone-tone`",
            Self::New => "`ridgetone-estimator`",
        })
    }
}

impl Answer {
    fn new(status: String, is_good: bool, frequency: f32, sigma: f32) -> Self {
        Self {
            status,
            is_good,
            frequency: frequency.into(),
            sigma: sigma.into(),
        }
    }

    fn none() -> Self {
        Self::new("None".to_owned(), false, 0.0, 0.0)
    }
}

impl std::fmt::Display for Answer {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(
            f,
            "{:.4} ± {:.4} {}",
            self.frequency, self.sigma, self.status
        )
    }
}

/// The highest bin of the channels' periodogram, each less its line, in units of its own power: what
/// an FFT gives, whose bins are a cycle a window apart.
pub fn periodogram(recording: &Recording) -> f64 {
    let rows = recording.rows();
    let mut powers = vec![0.0; rows / 2];
    for channel in 0..recording.channels() {
        let u = |i: usize| 2.0 * (i as f64 + 0.5) / rows as f64 - 1.0;
        let value = |i: usize| recording.values[i][channel];
        let mean = (0..rows).map(value).sum::<f64>() / rows as f64;
        let spread = (0..rows).map(|i| u(i).powi(2)).sum::<f64>();
        let slope = (0..rows).map(|i| u(i) * (value(i) - mean)).sum::<f64>() / spread;
        let left: Vec<f64> = (0..rows).map(|i| value(i) - mean - slope * u(i)).collect();
        let all = left
            .iter()
            .map(|x| x * x)
            .sum::<f64>()
            .max(f64::MIN_POSITIVE);
        for (bin, power) in powers.iter_mut().enumerate().skip(1) {
            let (mut re, mut im) = (0.0, 0.0);
            for (i, x) in left.iter().enumerate() {
                let angle = std::f64::consts::TAU * (bin * i) as f64 / rows as f64;
                re += x * angle.cos();
                im += x * angle.sin();
            }
            *power += (re * re + im * im) / all;
        }
    }
    let best = (1..powers.len())
        .max_by(|a, b| powers[*a].total_cmp(&powers[*b]))
        .unwrap_or(0);
    best as f64 / recording.length() * (rows as f64 - 1.0) / rows as f64
}
