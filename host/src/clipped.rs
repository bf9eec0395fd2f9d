//! Detects clipped channels, and angles that wrap.

/// Standard deviations below which a difference between two counts may be chance.
const BY_CHANCE: f64 = 3.0;

/// True if readings end at a limit: the outermost value is more frequent, relative to the next one,
/// than in a sine. In a rounded sine the ratio is at most 1 + sqrt(2), because the time that a sine
/// spends within a height h of its peak grows with the root of h.
pub fn is_clipped(values: &[f64]) -> bool {
    let known = || values.iter().copied().filter(|value| !value.is_nan());
    let (lowest, highest) = (Ends::of(known()), Ends::of(known().map(|value| -value)));
    let has_values_between = lowest.next < -highest.outer;
    has_values_between && (lowest.is_limit() || highest.is_limit())
}

/// The lowest value, the next one above it, and the number of times each occurs.
struct Ends {
    outer: f64,
    next: f64,
    outer_count: f64,
    next_count: f64,
}

impl Ends {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut ends = Self {
            outer: f64::INFINITY,
            next: f64::INFINITY,
            outer_count: 0.0,
            next_count: 0.0,
        };
        for value in values {
            if value < ends.outer {
                ends = Self {
                    outer: value,
                    next: ends.outer,
                    outer_count: 1.0,
                    next_count: ends.outer_count,
                };
            } else if value == ends.outer {
                ends.outer_count += 1.0;
            } else if value < ends.next {
                (ends.next, ends.next_count) = (value, 1.0);
            } else if value == ends.next {
                ends.next_count += 1.0;
            }
        }
        ends
    }

    /// True if the outermost value is more frequent than in any sine, allowing for chance.
    fn is_limit(&self) -> bool {
        let max = 1.0 + 2f64.sqrt();
        let more = self.outer_count - max * self.next_count;
        more > BY_CHANCE * (self.outer_count + max * max * self.next_count).sqrt()
    }
}

/// Possible periods of angles: degrees, radians, gons.
const PERIODS: [f64; 3] = [360.0, std::f64::consts::TAU, 400.0];

/// Minimum number of jumps that show that an angle wraps.
const JUMPS_MIN: usize = 3;

/// Returns the period at which readings wrap, as angles do; `None` if they do not.
pub fn wraps_at(values: &[f64]) -> Option<f64> {
    let known = || values.iter().copied().filter(|value| !value.is_nan());
    let span = known().fold(f64::NEG_INFINITY, f64::max) - known().fold(f64::INFINITY, f64::min);
    let steps = || known().zip(known().skip(1)).map(|(a, b)| (b - a).abs());
    // Whole numbers are not angles in radians.
    let are_whole = known().all(|value| value.fract() == 0.0);
    PERIODS
        .into_iter()
        .filter(|period| !are_whole || period.fract() == 0.0)
        .find(|period| {
            let is_jump = |step: &f64| *step > 0.75 * period;
            let jumps = steps().filter(is_jump).count();
            let others = steps().filter(|step| !is_jump(step));
            // A counter is constant between jumps.
            let steepest = others.fold(0.0, f64::max);
            (0.9 * period..=1.0001 * period).contains(&span)
                && jumps >= JUMPS_MIN
                && steepest < 0.25 * period
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipped_readings_are_told_from_a_rounded_sine_and_from_a_square_wave() {
        let sine = |step: f64, limit: f64| -> Vec<f64> {
            let value = |row: usize| (0.0137 * row as f64).sin().clamp(-limit, limit);
            (0..5000)
                .map(|row| (value(row) / step).round() * step)
                .collect()
        };
        for step in [1e-9, 1e-3, 0.01, 0.03, 0.1, 0.3] {
            assert!(!is_clipped(&sine(step, 2.0)), "{step}");
        }
        for (step, limit) in [(1e-9, 0.99), (1e-3, 0.9), (0.01, 0.5), (0.03, 0.5)] {
            assert!(is_clipped(&sine(step, limit)), "{step} {limit}");
        }
        let square: Vec<f64> = (0..1000).map(|row| f64::from(row / 10 % 2)).collect();
        assert!(!is_clipped(&square));
        assert!(!is_clipped(&[1.0; 100]) && !is_clipped(&[]));
    }

    #[test]
    fn angles_begin_again() {
        let angle = |period: f64| {
            (0..1000)
                .map(|row| f64::from(row) * 0.024 * period % period)
                .collect::<Vec<f64>>()
        };
        assert_eq!(wraps_at(&angle(360.0)), Some(360.0));
        assert_eq!(
            wraps_at(&angle(std::f64::consts::TAU)),
            Some(std::f64::consts::TAU)
        );
        let sine: Vec<f64> = (0..1000)
            .map(|row| 180.0 * (f64::from(row) * 0.1).sin())
            .collect();
        assert_eq!(wraps_at(&sine), None);
        assert_eq!(wraps_at(&[]), None);
    }
}
