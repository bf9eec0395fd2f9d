//! The two usual estimators, for comparison. Both return cycles per frame.

use core::f32::consts::TAU;
use libm::{cosf, logf, sinf};
use ridgetone_tone::Values;

/// Number of points in the longest transform, eight times 1024.
const POINTS: usize = 8192;

/// Lowest frequency searched, cycles per frame: 1 Hz.
const LOWEST: f32 = 1.0 / 241.14;

/// Correction in cycles per window below which the iterations of IEEE 1057 stop: a hundredth of the
/// CRB of one channel at 40 dB and 241 frames.
const ENOUGH: f32 = 3e-6;

/// Cosine and sine of a linearly growing angle, by one rotation per step instead of two function
/// calls.
struct Rotation {
    now: (f32, f32),
    step: (f32, f32),
}

impl Rotation {
    fn new(from: f32, step: f32) -> Self {
        let unit = |cycles: f32| (cosf(TAU * cycles), sinf(TAU * cycles));
        Self {
            now: unit(from),
            step: unit(step),
        }
    }

    fn next(&mut self) -> (f32, f32) {
        let ((c, s), (dc, ds)) = (self.now, self.step);
        self.now = (c * dc - s * ds, c * ds + s * dc);
        (c, s)
    }
}

pub struct Scratch {
    points: [f32; POINTS],
    power: [f32; POINTS / 2],
}

impl Scratch {
    pub const EMPTY: Self = Self {
        points: [0.0; POINTS],
        power: [0.0; POINTS / 2],
    };
}

/// Returns one channel without its linear trend, padded with zeros.
fn detrended<'s>(frames: &[Values], channel: usize, points: &'s mut [f32]) -> &'s mut [f32] {
    let (n, middle) = (frames.len() as f32, 0.5 * (frames.len() as f32 - 1.0));
    let (mut sum, mut moment) = (0.0, 0.0);
    for (k, values) in frames.iter().enumerate() {
        sum += values[channel];
        moment += values[channel] * (k as f32 - middle);
    }
    let slope = moment / (n * (n * n - 1.0) / 12.0);
    points.fill(0.0);
    for (k, (point, values)) in points.iter_mut().zip(frames).enumerate() {
        *point = values[channel] - sum / n - slope * (k as f32 - middle);
    }
    points
}

/// Detrends, applies a Hann window, zero-pads by 8, sums the power over 16 channels, and
/// interpolates the logarithm of the peak by a parabola.
pub fn hann(frames: &[Values], scratch: &mut Scratch) -> Option<f32> {
    let points = 8 * frames.len().next_power_of_two();
    let power = &mut scratch.power[..points / 2];
    power.fill(0.0);
    let last = (frames.len() - 1) as f32;
    for channel in 0..16 {
        let all = detrended(frames, channel, &mut scratch.points[..points]);
        let mut angle = Rotation::new(0.0, 1.0 / last);
        for point in all.iter_mut().take(frames.len()) {
            *point *= 0.5 - 0.5 * angle.next().0;
        }
        let transform: &[microfft::Complex32] = match points {
            512 => microfft::real::rfft_512(all.first_chunk_mut()?),
            1024 => microfft::real::rfft_1024(all.first_chunk_mut()?),
            2048 => microfft::real::rfft_2048(all.first_chunk_mut()?),
            _ => microfft::real::rfft_8192(all.first_chunk_mut()?),
        };
        for (sum, value) in power.iter_mut().zip(transform) {
            *sum += value.re * value.re + value.im * value.im;
        }
    }
    let from = (2.0_f32).max(LOWEST * points as f32) as usize;
    let higher = |a: &usize, b: &usize| power[*a].total_cmp(&power[*b]);
    let peak = (from..power.len() - 1).max_by(higher).unwrap_or(from);
    let [a, b, c] = [peak - 1, peak, peak + 1].map(|k| logf(power[k]));
    Some((peak as f32 + 0.5 * (a - c) / (a - 2.0 * b + c)) / points as f32)
}

/// Fits the four-parameter sine of IEEE Std 1057 in each channel, starting at the Hann FFT's peak.
/// Returns the mean frequency, weighted by the channels' power.
pub fn ieee1057(frames: &[Values], scratch: &mut Scratch) -> Option<f32> {
    let guess = hann(frames, scratch)?;
    let (mut sum, mut weights) = (0.0, 0.0);
    for channel in 0..16 {
        let points = &mut scratch.points[..frames.len()];
        if let Some((frequency, weight)) = fit(detrended(frames, channel, points), guess) {
            sum += weight * frequency;
            weights += weight;
        }
    }
    (weights > 0.0).then(|| sum / weights)
}

/// Fits one channel and returns its frequency and squared amplitude. Returns `None` if the
/// iterations diverge from the guess.
fn fit(points: &[f32], guess: f32) -> Option<(f32, f32)> {
    let middle = 0.5 * (points.len() as f32 - 1.0);
    let (mut frequency, mut cosine, mut sine) = (guess, 0.0, 0.0);
    for pass in 0..12 {
        let mut normal = [[0.0; 5]; 4];
        let mut angle = Rotation::new(-frequency * middle, frequency);
        for (k, point) in points.iter().enumerate() {
            let t = k as f32 - middle;
            let (c, s) = angle.next();
            // The fourth column is the derivative with respect to the frequency. The first pass
            // omits it, because the amplitudes are unknown.
            let along = (t / middle) * (sine * c - cosine * s);
            let row = [c, s, 1.0, if pass == 0 { 0.0 } else { along }, *point];
            for (i, sums) in normal.iter_mut().enumerate() {
                for (sum, value) in sums.iter_mut().zip(row) {
                    *sum += row[i] * value;
                }
            }
        }
        if pass == 0 {
            normal[3] = [0.0, 0.0, 0.0, 1.0, 0.0];
        }
        let solution = solve(normal)?;
        (cosine, sine) = (solution[0], solution[1]);
        let correction = solution[3] / (TAU * middle);
        frequency += correction;
        let off = (frequency - guess).abs() * points.len() as f32;
        if off.is_nan() || off > 1.0 {
            return None;
        }
        if pass > 0 && correction.abs() * (points.len() as f32) < ENOUGH {
            break;
        }
    }
    Some((frequency, cosine * cosine + sine * sine))
}

fn solve(mut rows: [[f32; 5]; 4]) -> Option<[f32; 4]> {
    for k in 0..4 {
        let own = rows[k];
        if own[k] == 0.0 {
            return None;
        }
        for (_, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = row[k] / own[k];
            for (value, from) in row.iter_mut().zip(own) {
                *value -= factor * from;
            }
        }
    }
    Some(core::array::from_fn(|k| rows[k][4] / rows[k][k]))
}
