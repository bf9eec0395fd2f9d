//! The amplitude spectrum of a window, in place.

use core::f32::consts::TAU;

/// Longest window, samples.
pub const POINTS_MAX: usize = 1024;

/// Shortest window, samples.
const POINTS_MIN: usize = 64;

/// Hamming's window is 0.54 - 0.46 cos: its mean, and a quarter of its peak-to-peak range.
const MEAN: f32 = 0.54;
const SIDE: f32 = 0.23;

/// The longest window of at most `samples` samples; none if they are too few.
pub fn points(samples: usize) -> Option<usize> {
    let points = 1 << samples.clamp(1, POINTS_MAX).ilog2();
    (points >= POINTS_MIN).then_some(points)
}

/// The amplitude spectrum of a window of 64, 128, ... [`POINTS_MAX`] samples, under Hamming's
/// window and less its mean: a sine of n whole cycles has its amplitude in bin n. The bins take the
/// first half of the samples' memory; bin 0 is 0. None for another number of samples.
pub fn amplitude_spectrum(samples: &mut [f32]) -> Option<&mut [f32]> {
    if points(samples.len()) != Some(samples.len()) {
        return None;
    }
    subtract_mean(samples);
    transform(samples);
    // The Nyquist bin's real part is stored behind bin 0's.
    let [zero, nyquist, ..] = *samples else {
        return None;
    };
    // The window mixes each bin with its two neighbours, which needs no table of cosines.
    let half = samples.len() / 2;
    let scale = 2.0 / (MEAN * samples.len() as f32);
    let (mut left, mut here) = ([0.0; 2], [zero, 0.0]);
    for k in 0..half {
        let right = match samples.get(2 * k + 2..2 * k + 4) {
            Some(&[re, im]) => [re, im],
            _ => [nyquist, 0.0],
        };
        let ([left_re, left_im], [here_re, here_im], [right_re, right_im]) = (left, here, right);
        let re = MEAN * here_re - SIDE * (left_re + right_re);
        let im = MEAN * here_im - SIDE * (left_im + right_im);
        // Bins from k + 2 on are still to be read, and lie behind place k.
        if let Some(place) = samples.get_mut(k) {
            *place = if k == 0 {
                0.0
            } else {
                scale * libm::sqrtf(re * re + im * im)
            };
        }
        (left, here) = (here, right);
    }
    samples.get_mut(..half)
}

/// The amplitude at `cycles` cycles in the window, a whole number or not, as the spectrum has it at
/// whole ones. It costs a sine and two cosines a sample.
pub fn amplitude_at(samples: &[f32], cycles: f32) -> f32 {
    let (count, mean) = (samples.len().max(1) as f32, mean(samples));
    // Whole numbers of 2^-32 turns: a sum of angles in f32 would drift.
    let step = (f64::from(cycles) / f64::from(count) * 4_294_967_296.0) as i64 as u32;
    let (mut phase, mut re, mut im) = (0u32, 0.0, 0.0);
    for (i, sample) in samples.iter().enumerate() {
        let window = MEAN - 2.0 * SIDE * libm::cosf(TAU * i as f32 / count);
        let (sin, cos) = libm::sincosf(phase as f32 * (TAU / 4_294_967_296.0));
        let value = window * (sample - mean);
        re += value * cos;
        im += value * sin;
        phase = phase.wrapping_add(step);
    }
    2.0 / (MEAN * count) * libm::sqrtf(re * re + im * im)
}

/// Mean of the samples; that of equal ones is exact.
fn mean(samples: &[f32]) -> f32 {
    let first = samples.first().copied().unwrap_or(0.0);
    first + samples.iter().map(|sample| sample - first).sum::<f32>() / samples.len().max(1) as f32
}

fn subtract_mean(samples: &mut [f32]) {
    let mean = mean(samples);
    samples.iter_mut().for_each(|sample| *sample -= mean);
}

/// The transform of real samples in their place, as real and imaginary parts.
fn transform(samples: &mut [f32]) {
    macro_rules! transform {
        ($($points:literal $name:ident),*) => {
            match samples.len() {
                $($points => if let Ok(samples) = <&mut [f32; $points]>::try_from(samples) {
                    let _ = microfft::real::$name(samples);
                },)*
                _ => {}
            }
        };
    }
    transform!(64 rfft_64, 128 rfft_128, 256 rfft_256, 512 rfft_512, 1024 rfft_1024);
}
