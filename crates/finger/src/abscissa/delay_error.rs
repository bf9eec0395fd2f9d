//! The error of a wavenumber whose places are late, where the speed changes.

use core::f32::consts::PI;

/// Parts of a way by which its speeds are measured.
const PARTS: usize = 16;

/// A window's way.
pub struct Way<'a> {
    /// Place of a frame, millimetres.
    pub place_mm: &'a dyn Fn(u32) -> f32,
    /// Its last frame.
    pub last: u32,
    /// Frames a second.
    pub frame_rate_hz: f32,
}

/// Errors of a wavenumber whose places are late, as shares of it. At a constant speed there are
/// none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelayError {
    /// If all places are late by a second; not negative.
    pub per_s: f32,
    /// Because the low-pass is quicker with fast tones: their delay at f hertz is atan(2 pi f t) /
    /// (2 pi f), t for slow ones.
    pub by_low_pass: f32,
}

impl DelayError {
    /// On a way, for a low-pass that makes slow tones late by `low_pass_s` seconds, and a tone of
    /// some cycles a millimetre. Overtones are those of a fit, over the fundamental. Errors of
    /// places change the wavenumber by the slope of the error over the place (least squares).
    pub fn new(way: Way<'_>, low_pass_s: f32, per_mm: f32, overtones: &[[f32; 2]]) -> Self {
        let Way {
            place_mm,
            last,
            frame_rate_hz,
        } = way;
        // Each part's frames, which may differ by one, its middle, and the speed there.
        let mut parts = [(0.0, 0.0, 0.0); PARTS];
        let (mut from, mut from_mm, mut sum_mm) = (0, place_mm(0), 0.0);
        for (at, (frames, middle_mm, mm_s)) in (1u32..).zip(&mut parts) {
            let until = last * at / PARTS as u32;
            let until_mm = place_mm(until);
            *frames = (until - from) as f32;
            *middle_mm = 0.5 * (from_mm + until_mm);
            *mm_s = (until_mm - from_mm) / frames.max(1.0) * frame_rate_hz;
            sum_mm += *frames * *middle_mm;
            (from, from_mm) = (until, until_mm);
        }
        let mean_mm = sum_mm / last as f32;
        let slope = |late_mm: &dyn Fn(f32) -> f32| {
            let (mut along, mut squares) = (0.0, 0.0);
            for (frames, middle_mm, mm_s) in parts {
                let from_mean = frames * (middle_mm - mean_mm);
                along += from_mean * late_mm(mm_s);
                squares += from_mean * (middle_mm - mean_mm);
            }
            along / squares
        };
        let per_s = slope(&|mm_s| mm_s);
        // Each harmonic has its own delay. It weighs as much as its power times the square of its
        // order.
        let (mut quicker, mut weights, mut number) = (0.0, 0.0, 1.0);
        let powers = overtones.iter().map(|[re, im]| re * re + im * im);
        for power in core::iter::once(1.0).chain(powers) {
            let weight = power * number * number;
            let per_turn = 2.0 * PI * per_mm * number;
            let quicker_mm = |mm_s: f32| {
                let slow_mm = mm_s * low_pass_s;
                slow_mm - libm::atanf(per_turn * slow_mm) / per_turn
            };
            quicker += weight * slope(&quicker_mm);
            (weights, number) = (weights + weight, number + 1.0);
        }
        let [per_s, by_low_pass] = [per_s.abs(), quicker / weights]
            .map(|share| if share.is_finite() { share } else { 0.0 });
        Self { per_s, by_low_pass }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::f64::consts::TAU;

    const LOW_PASS_S: f32 = 0.41e-3;
    use std::vec::Vec;

    /// The slope of places that are late over those that are not, less 1: by its definition, in
    /// f64.
    fn stretch(place_mm: impl Fn(f64) -> f64, lasts_s: f64) -> f64 {
        const LATE_S: f64 = 1e-4;
        let t_s = || (0..=4000).map(|at| lasts_s * f64::from(at) / 4000.0);
        let mean = |of: &dyn Fn(f64) -> f64| t_s().map(of).sum::<f64>() / 4001.0;
        let (middle, late) = (mean(&place_mm), mean(&|t_s| place_mm(t_s + LATE_S)));
        let both = mean(&|t_s| (place_mm(t_s) - middle) * (place_mm(t_s + LATE_S) - late));
        (both / mean(&|t_s| (place_mm(t_s) - middle).powi(2)) - 1.0) / LATE_S
    }

    fn of_144(place_mm: &dyn Fn(u32) -> f32) -> Way<'_> {
        Way {
            place_mm,
            last: 144,
            frame_rate_hz: 240.0,
        }
    }

    #[test]
    fn a_way_is_stretched_by_its_change_of_speed() {
        let from_rest = |t_s: f64| 25.0 * t_s * t_s;
        let steady = |t_s: f64| 30.0 * t_s;
        let hand = |t_s: f64| 12.0 * (1.0 - (5.0 * (t_s + 0.1)).cos());
        let turning = |t_s: f64| 12.0 * (1.0 - (5.0 * (t_s + 0.4)).cos());
        let ways: [&dyn Fn(f64) -> f64; 4] = [&from_rest, &steady, &hand, &turning];
        for (number, way) in ways.iter().enumerate() {
            let place_mm = |frame: u32| way(f64::from(frame) * 0.6 / 144.0) as f32;
            let found = DelayError::new(of_144(&place_mm), LOW_PASS_S, 0.4, &[]);
            let unfiltered = DelayError::new(of_144(&place_mm), 0.0, 0.4, &[]);
            assert_eq!(
                (unfiltered.per_s, unfiltered.by_low_pass),
                (found.per_s, 0.0)
            );
            let expected = stretch(way, 0.6).abs();
            // Sixteen parts of the way are a few percent off the integrals.
            assert!(
                (f64::from(found.per_s) - expected).abs() < 0.03 * expected + 0.01,
                "{number}: {found:?}, {expected}"
            );
        }
        let at_rest = DelayError::new(of_144(&|_| 3.0), LOW_PASS_S, 0.4, &[]);
        assert_eq!(
            at_rest,
            DelayError {
                per_s: 0.0,
                by_low_pass: 0.0
            }
        );
    }

    /// Wavenumber of a tone and its overtone (their amplitudes are 1 and `second`) that a
    /// first-order low-pass has made late, by least squares at places that are late as slow tones
    /// are; over the true one, less 1. The low-pass is its differential equation, in f64.
    fn longer(place_mm: impl Fn(f64) -> f64, lasts_s: f64, per_mm: f64, second: f64) -> f64 {
        const STEPS: usize = 40;
        let (count, rc_s) = (128, f64::from(LOW_PASS_S));
        let step_s = lasts_s / (count * STEPS) as f64;
        let signal = |t_s: f64| {
            let turns = per_mm * place_mm(t_s);
            (TAU * turns).cos() + second * (2.0 * TAU * turns).cos()
        };
        // It settles for twenty time constants before; the trapezoidal rule.
        let before = (20.0 * rc_s / step_s) as usize;
        let (mut out, mut filtered) = (0.0, Vec::new());
        for step in 0..before + count * STEPS {
            let t_s = (step as f64 - before as f64) * step_s;
            let mean = 0.5 * (signal(t_s) + signal(t_s + step_s));
            let decay = 0.5 * step_s / rc_s;
            out = ((1.0 - decay) * out + 2.0 * decay * mean) / (1.0 + decay);
            if step >= before && (step + 1 - before).is_multiple_of(STEPS) {
                filtered.push((place_mm(t_s + step_s - rc_s), out));
            }
        }
        let residual = |per_mm: f64| {
            let columns: [&dyn Fn(f64) -> f64; 5] = [
                &|_| 1.0,
                &|mm| (TAU * per_mm * mm).cos(),
                &|mm| (TAU * per_mm * mm).sin(),
                &|mm| (2.0 * TAU * per_mm * mm).cos(),
                &|mm| (2.0 * TAU * per_mm * mm).sin(),
            ];
            let mut basis: Vec<Vec<f64>> = Vec::new();
            let mut left: Vec<f64> = filtered.iter().map(|(_, value)| *value).collect();
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            for column in columns {
                let mut new: Vec<f64> = filtered.iter().map(|(mm, _)| column(*mm)).collect();
                for old in &basis {
                    let along = dot(&new, old);
                    new.iter_mut()
                        .zip(old)
                        .for_each(|(new, old)| *new -= along * old);
                }
                let length = dot(&new, &new).sqrt();
                new.iter_mut().for_each(|new| *new /= length);
                let along = dot(&left, &new);
                left.iter_mut()
                    .zip(&new)
                    .for_each(|(left, new)| *left -= along * new);
                basis.push(new);
            }
            dot(&left, &left)
        };
        // Golden section.
        let (mut low, mut high) = (0.99 * per_mm, 1.01 * per_mm);
        for _ in 0..60 {
            let (a, b) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
            if residual(a) < residual(b) {
                high = b
            } else {
                low = a
            }
        }
        0.5 * (low + high) / per_mm - 1.0
    }

    /// A tone of 100 to 400 Hz of a hand that gets faster, and of one that slows down.
    #[test]
    fn a_fast_tone_is_less_late_than_a_slow_one() {
        for (acceleration_mm_s2, per_mm) in [(1300.0, 1.0), (1300.0, 2.0), (-1300.0, 2.0)] {
            let way = |t_s: f64| {
                200.0 * (t_s + 0.1) + 0.5 * acceleration_mm_s2 * (t_s - 0.032) * (t_s - 0.032)
            };
            for second in [0.0, 0.5] {
                let expected = longer(way, 0.064, per_mm, second);
                let place_mm = |frame: u32| way(f64::from(frame) * 0.5e-3) as f32;
                // The low-pass weakens the overtone, too.
                let gain =
                    |hz: f64| 1.0 / (1.0 + (TAU * hz * f64::from(LOW_PASS_S)).powi(2)).sqrt();
                let overtone = second * gain(2.0 * 200.0 * per_mm) / gain(200.0 * per_mm);
                let way = Way {
                    place_mm: &place_mm,
                    last: 128,
                    frame_rate_hz: 2000.0,
                };
                let overtones = &[[overtone as f32, 0.0]];
                let late = DelayError::new(way, LOW_PASS_S, per_mm as f32, overtones);
                let found = f64::from(late.by_low_pass);
                std::println!(
                    "{acceleration_mm_s2} {per_mm} {second}: {found:.2e} for {expected:.2e}"
                );
                assert!(
                    (found - expected).abs() < 0.1 * expected.abs(),
                    "{found:.2e} {expected:.2e}"
                );
            }
        }
    }
}
