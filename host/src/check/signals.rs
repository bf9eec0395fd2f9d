//! Statistics of inputs and time stamps from raw frames.

use ridgetone_proto::settings::{FRAME_RATE_HZ, TAXELS};
use ridgetone_proto::telemetry::Raw;
use std::f64::consts::TAU;

/// The ends of the scale, codes (SBAS297G, data format).
const SCALE: (i32, i32) = (-0x80_0000, 0x7f_ffff);

/// Frames in each part over which a line is measured: two seconds. The mains frequency is steady
/// for that long, and 120 Hz is resolved from its alias at 121.1 Hz at 241.14 frames per second.
const LINE_FRAMES: usize = (2.0 * FRAME_RATE_HZ) as usize;

/// Frames in a straight-line fit of the time stamps: ten seconds, in which crystals drift by less
/// than a microsecond.
const CLOCK_FRAMES: usize = (10.0 * FRAME_RATE_HZ) as usize;

/// Returns the codes of one input in consecutive frames.
fn codes(frames: &[Raw], input: usize) -> impl Iterator<Item = f64> {
    frames
        .iter()
        .filter(move |frame| frame.present >> input & 1 != 0)
        .map(move |frame| f64::from(frame.codes[input]))
}

/// Returns masks of the inputs whose code never changes, and of those at an end of the scale in at
/// least 1 % of the frames.
pub fn dead_and_railed(frames: &[Raw]) -> (u16, u16) {
    let (mut dead, mut railed) = (0, 0);
    for input in 0..TAXELS {
        let present = || {
            frames
                .iter()
                .filter(|frame| frame.present >> input & 1 != 0)
                .map(|frame| frame.codes[input])
        };
        let at_rail = present()
            .filter(|code| *code <= SCALE.0 || *code >= SCALE.1)
            .count();
        let count = present().count();
        let is_railed = at_rail > 0 && 100 * at_rail >= count;
        let is_dead = count > 1 && !is_railed && present().min() == present().max();
        dead |= u16::from(is_dead) << input;
        railed |= u16::from(is_railed) << input;
    }
    (dead, railed)
}

/// Returns the noise of an input (codes rms) from differences between neighbouring frames, so that
/// drifts do not count.
pub fn noise(runs: &[&[Raw]], input: usize) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0u32);
    for run in runs {
        let codes: Vec<f64> = codes(run, input).collect();
        for pair in codes.windows(2) {
            (sum, count) = (sum + (pair[1] - pair[0]).powi(2), count + 1);
        }
    }
    (count > 0).then(|| (sum / (2.0 * f64::from(count))).sqrt())
}

/// Returns the line at `frequency_hz` in an input (codes rms), from the mean power of parts of two
/// seconds with a Hann window, which rejects tones and drifts 2 Hz away. `None` without a whole
/// part.
pub fn line(runs: &[&[Raw]], input: usize, frequency_hz: f64, frame_rate_hz: f64) -> Option<f64> {
    let (mut power, mut parts) = (0.0, 0u32);
    for part in runs.iter().flat_map(|run| run.chunks_exact(LINE_FRAMES)) {
        let codes: Vec<f64> = codes(part, input).collect();
        if codes.len() < LINE_FRAMES {
            continue;
        }
        let mean = codes.iter().sum::<f64>() / LINE_FRAMES as f64;
        let (mut re, mut im) = (0.0, 0.0);
        for (code, at) in codes.iter().zip(0u32..) {
            let window = 1.0 - (TAU * (f64::from(at) + 0.5) / LINE_FRAMES as f64).cos();
            let (sin, cos) = (TAU * frequency_hz / frame_rate_hz * f64::from(at)).sin_cos();
            (re, im) = (
                re + window * (code - mean) * cos,
                im + window * (code - mean) * sin,
            );
        }
        // The window's mean is 1. The mean square of a tone is half its squared amplitude.
        let amplitude = 2.0 * re.hypot(im) / LINE_FRAMES as f64;
        (power, parts) = (power + amplitude.powi(2) / 2.0, parts + 1);
    }
    (parts > 0).then(|| (power / f64::from(parts)).sqrt())
}

/// Time stamps of frames compared with straight lines.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    pub frame_rate_hz: f64,
    pub jitter_rms_us: f64,
    pub jitter_worst_us: f64,
}

impl Clock {
    /// Fits a clock to the frames; `None` for less than a second of frames.
    pub fn of(frames: &[Raw]) -> Option<Self> {
        let (first, last) = (frames.first()?, frames.last()?);
        let count = last
            .number
            .checked_sub(first.number)
            .filter(|count| *count as f32 >= FRAME_RATE_HZ)?;
        let passed_us = last
            .t_us
            .checked_sub(first.t_us)
            .filter(|passed_us| *passed_us > 0)?;
        let (mut sum, mut worst) = (0.0, 0.0f64);
        for part in frames.chunks(CLOCK_FRAMES) {
            for residual_us in residuals_us(part) {
                (sum, worst) = (sum + residual_us.powi(2), worst.max(residual_us.abs()));
            }
        }
        Some(Self {
            frame_rate_hz: f64::from(count) * 1e6 / passed_us as f64,
            jitter_rms_us: (sum / frames.len() as f64).sqrt(),
            jitter_worst_us: worst,
        })
    }
}

/// Returns the residuals of a least-squares line of time against frame number.
fn residuals_us(frames: &[Raw]) -> Vec<f64> {
    let Some(first) = frames.first() else {
        return Vec::new();
    };
    let points = frames.iter().map(|frame| {
        // Use differences, so that f64 stays exact after weeks.
        (
            f64::from(frame.number.wrapping_sub(first.number)),
            frame.t_us.wrapping_sub(first.t_us) as f64,
        )
    });
    let points: Vec<(f64, f64)> = points.collect();
    let n = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x_mean, y_mean) = (mean(|p| p.0), mean(|p| p.1));
    let sxx: f64 = points.iter().map(|(x, _)| (x - x_mean).powi(2)).sum();
    let sxy: f64 = points
        .iter()
        .map(|(x, y)| (x - x_mean) * (y - y_mean))
        .sum();
    let slope = if sxx > 0.0 { sxy / sxx } else { 0.0 };
    points
        .iter()
        .map(|(x, y)| y - y_mean - slope * (x - x_mean))
        .collect()
}
