//! The paper's way from a recording to a frequency: contact, cut, first guess, least squares; and
//! our own fit beside it.

use super::paper::{DELAY_S, LENGTH_MM, SPIKE_BEFORE_S};
use super::taken::Taken;
use crate::baselines::{Method, Scratch};
use anyhow::{Context, Result};
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_tone::{Fitter, FrameSpan, Scene, Status, Table};
use std::f64::consts::TAU;
use std::ops::Range;

/// The part of a run that the paper's equations 2 to 5 cut out.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// The taxel with the clearest spike.
    pub taxel: usize,
    pub spike_s: f64,
    /// From the slide's start to its end, seconds.
    pub slide_s: (f64, f64),
    pub frames: Range<usize>,
}

/// Finds the contact spike in two channels and cuts the slide out (equations 2 to 5). None in a
/// shorter recording.
pub fn cut(taken: &Taken, taxels: [usize; 2], speed_mm_s: f64) -> Option<Cut> {
    let spikes = taxels.iter().filter_map(|&taxel| {
        let head = &taken.volts(taxel)[..taken.frame_at(taxel, SPIKE_BEFORE_S)];
        let (spike_s, most) = head.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let mut levels: Vec<f64> = head.iter().map(|(_, volts)| *volts).collect();
        levels.sort_by(f64::total_cmp);
        Some((most - levels[levels.len() / 2], taxel, spike_s))
    });
    let (_, taxel, spike_s) = spikes.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let start_s = spike_s + DELAY_S;
    let end_s = start_s + LENGTH_MM / speed_mm_s;
    let frames = taken.frame_at(taxels[0], start_s)..taken.frame_at(taxels[0], end_s);
    (frames.end < taken.codes.len() && !frames.is_empty()).then_some(Cut {
        taxel,
        spike_s,
        slide_s: (start_s, end_s),
        frames,
    })
}

/// Power of the lines 1 to n / 2 of n samples less their mean: the square of each line's amplitude,
/// in the samples' unit squared. Line k is at k / n cycles per sample; nothing is padded, as in the
/// paper (equation 6).
fn periodogram(samples: &[f64]) -> Vec<f64> {
    let count = samples.len();
    let mean = samples.iter().sum::<f64>() / count as f64;
    let table: Vec<(f64, f64)> = (0..count)
        .map(|n| (TAU * n as f64 / count as f64).sin_cos())
        .collect();
    let line = |k: usize| {
        let turned = samples
            .iter()
            .enumerate()
            .map(|(n, x)| ((x - mean), table[n * k % count]));
        let (cos, sin) = turned.fold((0.0, 0.0), |(c, s), (x, (sin, cos))| {
            (c + x * cos, s + x * sin)
        });
        4.0 * (cos * cos + sin * sin) / (count * count) as f64
    };
    (1..=count / 2).map(line).collect()
}

/// The highest line of a power spectrum, cycles per sample; `count` samples made it.
fn highest(power: &[f64], count: usize) -> Option<f64> {
    let most = power.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
    Some((most.0 + 1) as f64 / count as f64)
}

/// Naive Fourier analysis: the highest line of each channel by itself, and their mean, hertz.
pub fn fft_hz(taken: &Taken, taxels: &[usize], frames: &Range<usize>) -> Option<f64> {
    let lines = taxels
        .iter()
        .map(|taxel| highest(&periodogram(&taken.samples(*taxel, frames)), frames.len()));
    let lines: Option<Vec<f64>> = lines.collect();
    lines.map(|lines| taken.rate_hz * lines.iter().sum::<f64>() / taxels.len() as f64)
}

/// The paper's least squares: gradient descent on seven parameters of two channels (equation 9),
/// hertz.
pub fn least_squares_hz(
    taken: &Taken,
    taxels: [usize; 2],
    frames: &Range<usize>,
    scratch: &mut Scratch,
) -> Option<f64> {
    let pair = |codes: &[f32; TAXELS]| {
        let mut frame = [0.0; TAXELS];
        frame[0] = codes[taxels[0]];
        frame[1] = codes[taxels[1]];
        frame
    };
    let values: Vec<[f32; TAXELS]> = taken.codes.get(frames.clone())?.iter().map(pair).collect();
    let frequency = Method::Oddo2009.estimate(&values, taxels.len(), scratch)?;
    Some(f64::from(frequency) * taken.rate_hz)
}

/// Our fit of all channels with the firmware's harmonics: frequency and sigma, hertz. None without
/// a single tone.
pub fn joint_hz(taken: &Taken, frames: &Range<usize>) -> Result<Option<(f64, f64)>> {
    let Some(part) = taken
        .codes
        .get(frames.clone())
        .filter(|part| !part.is_empty())
    else {
        return Ok(None);
    };
    let zero = part[0];
    let values: Vec<[f32; TAXELS]> = part
        .iter()
        .map(|codes| std::array::from_fn(|taxel| codes[taxel] - zero[taxel]))
        .collect();
    let valid = vec![u16::MAX; values.len()];
    let mut table = Table {
        values: &values,
        valid: &valid,
    };
    let mut span = FrameSpan::new(&mut table, 0, valid.len() as u32).with_quantization(1.0);
    let scene = Scene::with_harmonics(Settings::DEFAULT.harmonics);
    let fit = Fitter::new().fit(&mut span, &scene);
    let fit = fit.context("a table loses no frames")?;
    // The stimulator's speed has a ripple: the mean counts.
    let single = matches!(fit.status, Status::Good | Status::Unsteady);
    Ok(single.then(|| {
        (
            f64::from(fit.frequency) * taken.rate_hz,
            f64::from(fit.sigma) * taken.rate_hz,
        )
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_the_periodogram_is_a_tones_amplitude_squared() {
        let samples: Vec<f64> = (0..90)
            .map(|n| 5.0 + 3.0 * (TAU * 7.0 * f64::from(n) / 90.0 + 0.4).cos())
            .collect();
        let power = periodogram(&samples);
        assert_eq!(power.len(), 45);
        assert!((power[6] - 9.0).abs() < 1e-9 && power.iter().sum::<f64>() - power[6] < 1e-9);
        assert_eq!(highest(&power, 90), Some(7.0 / 90.0));
    }
}
