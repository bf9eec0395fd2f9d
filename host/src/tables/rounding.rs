//! Uncertainty of the row spacing with rounded stamps.

use super::clock::RowClock;

/// Maximum number of decimals for which rounded stamps are recognised: microseconds.
const DECIMALS_MAX: i32 = 6;

/// Accuracy of the row spacing that time stamps give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacing {
    /// Standard deviation of the spacing, seconds.
    pub sigma_s: f64,
    /// True if some even spacing puts every row within the rounding of its stamp.
    pub is_even: bool,
}

/// Returns the standard deviation of the row spacing, from stamps and row numbers.
///
/// Rounding errors are not noise: they depend on the spacing, repeat in a pattern, and may have a
/// slope. But every stamp limits them. If a range of spacings puts every row within the rounding of
/// its stamp, the true spacing is in this range, with equal probability. If no spacing does, the
/// stamps jitter, which makes their errors independent.
pub fn spacing(clock: &RowClock, time_s: &[f64], places: &[usize]) -> Spacing {
    let spacing_s = clock.spacing_s();
    let scattered = |error_s: f64| Spacing {
        sigma_s: clock.spacing_sigma_s(error_s),
        is_even: false,
    };
    let Some(step_s) = resolution_s(time_s) else {
        return scattered(0.0);
    };
    let corners = corners(time_s, places);
    let range_s = |spacing_s: f64| range_s(&corners, spacing_s);
    // Stamps on an even grid, such as 0.01, 0.02, 0.03, are assumed to be exact.
    if range_s(spacing_s) < 1e-3 * step_s {
        return Spacing {
            sigma_s: 0.0,
            is_even: true,
        };
    }
    let is_possible = |spacing_s: f64| range_s(spacing_s) <= step_s * (1.0 + 1e-3);
    let reach_s = 2.0 * step_s / places.last().map_or(1.0, |last| *last as f64);
    let (mut low, mut high) = (spacing_s - reach_s, spacing_s + reach_s);
    // The range is convex in the spacing: use ternary search for the minimum.
    let mut inside = spacing_s;
    while !is_possible(inside) {
        let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if right - left < 1e-9 * reach_s {
            return scattered(step_s / 12f64.sqrt());
        }
        if range_s(left) < range_s(right) {
            high = right
        } else {
            low = left
        }
        inside = 0.5 * (low + high);
    }
    let edge = |mut out: f64| {
        let mut within = inside;
        for _ in 0..40 {
            let middle = 0.5 * (within + out);
            if is_possible(middle) {
                within = middle
            } else {
                out = middle
            }
        }
        within
    };
    let (min, max) = (edge(spacing_s - reach_s), edge(spacing_s + reach_s));
    Spacing {
        sigma_s: ((max - min) / 12f64.sqrt()).hypot(spacing_s - 0.5 * (min + max)),
        is_even: true,
    }
}

/// Number of a row, and its stamp relative to the first one, seconds.
#[derive(Clone, Copy, Debug)]
struct Stamp {
    place: f64,
    t_s: f64,
}

/// Returns the range of the rows' distances from an even grid, seconds.
fn range_s(stamps: &[Stamp], spacing_s: f64) -> f64 {
    let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
    for stamp in stamps {
        let off_s = stamp.t_s - stamp.place * spacing_s;
        (min, max) = (off_s.min(min), off_s.max(max));
    }
    max - min
}

/// Returns the rows that can be furthest from an even grid of any spacing: the corners of the
/// convex hull of all stamps over row numbers. The search for possible spacings evaluates the range
/// about 80 times and needs only these rows.
fn corners(time_s: &[f64], places: &[usize]) -> Vec<Stamp> {
    let is_left_turn = |a: Stamp, b: Stamp, c: Stamp| {
        (b.place - a.place) * (c.t_s - a.t_s) > (b.t_s - a.t_s) * (c.place - a.place)
    };
    let (mut below, mut above) = (Vec::<Stamp>::new(), Vec::<Stamp>::new());
    for (t_s, place) in time_s.iter().zip(places) {
        let next = Stamp {
            place: *place as f64,
            t_s: t_s - time_s[0],
        };
        while let [.., a, b] = below[..]
            && !is_left_turn(a, b, next)
        {
            below.pop();
        }
        while let [.., a, b] = above[..]
            && !is_left_turn(b, a, next)
        {
            above.pop();
        }
        below.push(next);
        above.push(next);
    }
    below.append(&mut above);
    below
}

/// Returns the step of the stamps' last decimal, in seconds; `None` if there are too many decimals.
fn resolution_s(time_s: &[f64]) -> Option<f64> {
    let is_multiple = |decimals: &i32| {
        let steps = 10f64.powi(*decimals);
        time_s
            .iter()
            .all(|t_s| (t_s * steps - (t_s * steps).round()).abs() < 0.01)
    };
    (0..=DECIMALS_MAX)
        .find(is_multiple)
        .map(|decimals| 0.1f64.powi(decimals))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_rows_have_the_range_of_all() {
        let places: Vec<usize> = (0..1000).filter(|place| place % 7 != 3).collect();
        let exact = |place: usize| place as f64 / 241.14;
        let jittering = |place: usize| exact(place) + 1e-4 * (place * 7919 % 101) as f64;
        let rounded = |place: usize| (exact(place) * 1e3).round() * 1e-3;
        for stamp in [&exact as &dyn Fn(usize) -> f64, &jittering, &rounded] {
            let time_s: Vec<f64> = places.iter().map(|place| 5.0 + stamp(*place)).collect();
            let corners = corners(&time_s, &places);
            assert!(corners.len() < 120, "{}", corners.len());
            for spacing_s in [0.0, 0.004, 1.0 / 241.2, 1.0 / 241.14, 0.01] {
                let off_s = |row: &usize| time_s[*row] - places[*row] as f64 * spacing_s;
                let all = || (0..places.len()).map(|row| off_s(&row));
                let range = all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min);
                let found = range_s(&corners, spacing_s);
                assert!((found - range).abs() < 1e-12, "{found} {range}");
            }
        }
    }
}
