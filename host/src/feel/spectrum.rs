//! Amplitude spectra of windows of any number of rows.

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Mean of Hamming's window, 0.54 - 0.46 cos.
const MEAN: f64 = 0.54;

/// The transform of windows of one length.
pub struct Spectrum {
    transform: Arc<dyn Fft<f64>>,
    hamming: Vec<f64>,
}

impl Spectrum {
    /// Plans the transform of `rows` rows.
    pub fn new(rows: usize) -> Self {
        let hamming = |row| MEAN - (1.0 - MEAN) * (TAU * row as f64 / rows as f64).cos();
        Self {
            transform: FftPlanner::new().plan_fft_forward(rows),
            hamming: (0..rows).map(hamming).collect(),
        }
    }

    /// The amplitudes of a window under Hamming's window and less its mean: a sine of n whole cycles
    /// has its amplitude in bin n, and bin 0 is 0.
    pub fn amplitudes(&self, values: &[f32]) -> Vec<f32> {
        let count = values.len() as f64;
        let mean = values.iter().map(|value| f64::from(*value)).sum::<f64>() / count;
        let weighted = values.iter().zip(&self.hamming);
        let mut bins: Vec<Complex<f64>> = weighted
            .map(|(value, weight)| Complex::from(weight * (f64::from(*value) - mean)))
            .collect();
        self.transform.process(&mut bins);
        bins.truncate(values.len() / 2);
        bins[0] = Complex::from(0.0);
        let scale = 2.0 / (MEAN * count);
        bins.iter().map(|bin| (scale * bin.norm()) as f32).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's run of 30,000 rows, primes, and the lengths that the chip has too.
    #[test]
    fn a_sine_has_its_amplitude_in_its_bin_at_any_length() {
        for rows in [64, 97, 150, 1024, 30_000, 30_011] {
            let cycles = rows / 8 + 1;
            let sine = |row: usize| 2.5 + 0.3 * (TAU * (cycles * row) as f64 / rows as f64).sin();
            let values: Vec<f32> = (0..rows).map(|row| sine(row) as f32).collect();
            let found = Spectrum::new(rows).amplitudes(&values);
            assert_eq!(found.len(), rows / 2);
            for (bin, amplitude) in found.iter().enumerate() {
                let expected = match bin.abs_diff(cycles) {
                    0 => 0.3,
                    1 => 0.3 * 0.23 / 0.54,
                    _ => 0.0,
                };
                assert!(
                    (amplitude - expected).abs() < 1e-6,
                    "{rows} {bin}: {amplitude}"
                );
            }
        }
    }
}
