//! Fits all harmonics of a known frequency to one channel by least squares, for display. The
//! estimator supplies the frequency; it is not searched for here.

use serde::Serialize;
use std::f64::consts::TAU;

/// Minimum fraction of a column that must be independent of the other columns; otherwise the column
/// is left out.
const FRACTION_MIN: f64 = 1e-9;

/// One harmonic in one channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Harmonic {
    pub amplitude_v: f32,
    /// Phase at the window's centre: amplitude x cos(2 pi k f t + phase).
    pub phase_rad: f32,
}

/// A channel's baseline (a straight line and a bend), harmonics and interferer.
#[derive(Clone, Debug, PartialEq)]
pub struct Harmonics {
    /// Fitted value at each time.
    pub fit_v: Vec<f32>,
    /// All harmonics, the fundamental first.
    pub harmonics: Vec<Harmonic>,
    /// RMS of the residuals, normalised by their degrees of freedom, volts.
    pub residual_v: f32,
}

/// Fits `count` harmonics of `frequency_hz`, and a line at `interferer_hz` if there is one, to the
/// known values of `volts` at `t_s` (seconds from the window's centre). Returns `None` unless there
/// are more values than unknowns.
pub fn fit(
    t_s: &[f64],
    volts: &[Option<f32>],
    frequency_hz: f64,
    count: u8,
    interferer_hz: Option<f64>,
) -> Option<Harmonics> {
    let half_s = t_s
        .iter()
        .fold(f64::MIN_POSITIVE, |max, t_s| max.max(t_s.abs()));
    let lines: Vec<f64> = (1..=count)
        .map(|k| f64::from(k) * frequency_hz)
        .chain(interferer_hz)
        .collect();
    let row = |t_s: f64| {
        let u = t_s / half_s;
        let waves = lines
            .iter()
            .flat_map(|hz| [(TAU * hz * t_s).cos(), -(TAU * hz * t_s).sin()]);
        [1.0, u, u * u, u * u * u]
            .into_iter()
            .chain(waves)
            .collect::<Vec<f64>>()
    };
    let known: Vec<(f64, f64)> = t_s
        .iter()
        .zip(volts)
        .filter_map(|(t_s, v)| Some((*t_s, f64::from((*v)?))))
        .collect();
    let rows: Vec<Vec<f64>> = known.iter().map(|(t_s, _)| row(*t_s)).collect();
    let read: Vec<f64> = known.iter().map(|(_, volts)| *volts).collect();
    let unknowns = 4 + 2 * lines.len();
    if known.len() <= unknowns {
        return None;
    }
    let (found, squares) = least_squares(&rows, read);
    let value = |t_s: &f64| {
        row(*t_s)
            .iter()
            .zip(&found)
            .map(|(a, b)| a * b)
            .sum::<f64>() as f32
    };
    let harmonic = |pair: &[f64]| Harmonic {
        amplitude_v: pair[0].hypot(pair[1]) as f32,
        phase_rad: pair[1].atan2(pair[0]) as f32,
    };
    Some(Harmonics {
        fit_v: t_s.iter().map(value).collect(),
        harmonics: found[4..]
            .chunks_exact(2)
            .take(count.into())
            .map(harmonic)
            .collect(),
        residual_v: (squares / (known.len() - unknowns) as f64).sqrt() as f32,
    })
}

/// Returns offset and slope per value of the straight line through the known values, and the sum of
/// squares about it.
pub fn straight_line(volts: &[Option<f32>]) -> ([f64; 2], f64) {
    let known = || {
        let known = volts.iter().enumerate();
        known.filter_map(|(at, v)| Some((at as f64, f64::from((*v)?))))
    };
    let rows: Vec<Vec<f64>> = known().map(|(at, _)| vec![1.0, at]).collect();
    if rows.is_empty() {
        return ([0.0; 2], 0.0);
    }
    let (line, squares) = least_squares(&rows, known().map(|(_, v)| v).collect());
    ([line[0], line[1]], squares)
}

/// Returns the sum of squares of the known values about their straight line.
pub fn about_line(volts: &[Option<f32>]) -> f64 {
    straight_line(volts).1
}

/// A value and its position along the axis.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    pub at: f64,
    pub value: f64,
}

/// Evenly spaced frequencies, in cycles per unit of the axis.
#[derive(Clone, Copy, Debug)]
pub struct Frequencies {
    pub first: f64,
    pub step: f64,
    pub count: usize,
}

/// Returns the periodogram: power of the values at each frequency.
pub fn powers(readings: impl Iterator<Item = Reading>, frequencies: Frequencies) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); frequencies.count];
    for Reading { at, value } in readings {
        let (sin, cos) = (TAU * frequencies.first * at).sin_cos();
        let mut wave = (value * cos, value * sin);
        // From each frequency to the next the wave turns by the same angle.
        let (sin, cos) = (TAU * frequencies.step * at).sin_cos();
        for sum in &mut sums {
            sum.0 += wave.0;
            sum.1 += wave.1;
            wave = (wave.0 * cos - wave.1 * sin, wave.0 * sin + wave.1 * cos);
        }
    }
    sums.into_iter().map(|(re, im)| re * re + im * im).collect()
}

/// Returns the unknowns and the sum of squared residuals, by the modified Gram-Schmidt process
/// (Björck, "Solving linear least squares problems by Gram-Schmidt orthogonalization", BIT 7,
/// 1967).
fn least_squares(rows: &[Vec<f64>], mut residual: Vec<f64>) -> (Vec<f64>, f64) {
    let size = rows[0].len();
    let mut columns: Vec<Vec<f64>> = (0..size)
        .map(|at| rows.iter().map(|row| row[at]).collect())
        .collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (mut upper, mut found) = (vec![vec![0.0; size]; size], vec![0.0; size]);
    let full: Vec<f64> = columns.iter().map(|column| dot(column, column)).collect();
    for at in 0..size {
        let this = columns[at].clone();
        let square = dot(&this, &this);
        if square < FRACTION_MIN * full[at] {
            columns[at].fill(0.0);
            continue;
        }
        upper[at][at] = square;
        found[at] = dot(&this, &residual) / square;
        residual
            .iter_mut()
            .zip(&this)
            .for_each(|(residual, value)| *residual -= found[at] * value);
        for later in at + 1..size {
            let fraction = dot(&this, &columns[later]) / square;
            upper[at][later] = fraction;
            columns[later]
                .iter_mut()
                .zip(&this)
                .for_each(|(later, value)| *later -= fraction * value);
        }
    }
    for at in (0..size).rev() {
        if upper[at][at] == 0.0 {
            found[at] = 0.0;
            continue;
        }
        found[at] -= (at + 1..size)
            .map(|later| upper[at][later] * found[later])
            .sum::<f64>();
    }
    let squares = dot(&residual, &residual);
    (found, squares)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_put_in_comes_out() {
        let t_s: Vec<f64> = (0..241)
            .map(|at| (f64::from(at) - 120.0) / 241.14)
            .collect();
        let wave = |t_s: f64, k: f64, amplitude: f64, phase: f64| {
            amplitude * (TAU * 4.17 * k * t_s + phase).cos()
        };
        let truth = |t_s: f64| {
            0.1 + 0.02 * t_s
                + wave(t_s, 1.0, 3e-3, 0.5)
                + wave(t_s, 2.0, 1e-3, -2.0)
                + 5e-4 * (TAU * 50.0 * t_s).cos()
        };
        let mut volts: Vec<Option<f32>> = t_s.iter().map(|t_s| Some(truth(*t_s) as f32)).collect();
        volts[17] = None;
        let found = fit(&t_s, &volts, 4.17, 2, Some(50.0)).unwrap();
        for (found, (amplitude_v, phase_rad)) in
            found.harmonics.iter().zip([(3e-3, 0.5), (1e-3, -2.0)])
        {
            assert!(
                (f64::from(found.amplitude_v) / amplitude_v - 1.0).abs() < 1e-4,
                "{found:?}"
            );
            assert!(
                (f64::from(found.phase_rad) - phase_rad).abs() < 1e-4,
                "{found:?}"
            );
        }
        assert_eq!(found.harmonics.len(), 2);
        assert!(found.residual_v < 1e-7, "{}", found.residual_v);
        // The fit also has a value at the missing sample.
        assert!((f64::from(found.fit_v[17]) - truth(t_s[17])).abs() < 1e-7);
        let without = fit(&t_s, &volts, 4.17, 1, Some(50.0)).unwrap();
        assert!(
            (f64::from(without.residual_v) * 2f64.sqrt() / 1e-3 - 1.0).abs() < 0.05,
            "{}",
            without.residual_v
        );
        assert_eq!(fit(&t_s[..8], &volts[..8], 4.17, 2, None), None);
    }
}
