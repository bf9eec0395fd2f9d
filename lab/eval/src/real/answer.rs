//! The estimator on a recording, and an FFT beside it.

use super::recording::Recording;
use ridgetone_host::digits::uncertain;
use ridgetone_tone::{Fitter, FrameSpan, Frames, Scene, Status};

/// What it says.
#[derive(Clone, Debug)]
pub struct Answer {
    pub status: String,
    pub is_good: bool,
    pub frequency: f64,
    pub sigma: f64,
}

impl Answer {
    /// Fits a recording by its abscissa.
    pub fn of(recording: &Recording) -> Self {
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
        let mut fitter = Box::new(Fitter::new());
        let fitted = Frames::new(&values, recording.channels()).and_then(|mut frames| {
            let span = FrameSpan::new(&mut frames, 0, recording.rows() as u32);
            let span = &mut span.along(&place)?;
            fitter.fit(span, &Scene::DEFAULT).ok()
        });
        fitted.map_or_else(Self::none, |fit| Self {
            status: format!("{:?}", fit.status),
            is_good: fit.status == Status::Good,
            frequency: fit.frequency.into(),
            sigma: fit.sigma.into(),
        })
    }

    fn none() -> Self {
        Self {
            status: "none".to_owned(),
            is_good: false,
            frequency: 0.0,
            sigma: 0.0,
        }
    }
}

impl std::fmt::Display for Answer {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(
            f,
            "{} {}",
            uncertain(self.frequency, self.sigma),
            self.status
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
