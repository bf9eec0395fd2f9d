//! Rows with time stamps onto an even grid: the fit takes one row per sampling interval.

use crate::digits::significant;
use anyhow::{Context, Result, bail, ensure};
use hal_mock::RowClock;

/// Share of missing rows above which the time stamps are no steady sampling with a few rows lost.
const MISSING_MAX: f64 = 0.2;

/// Most decimals by which the rounding of stamps is recognised: microseconds.
const DECIMALS_MAX: i32 = 6;

#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    pub rate_hz: f64,
    /// Standard deviation of the rate; zero of a given one.
    pub rate_sigma_hz: f64,
    /// The rate by the time stamps, if there are any.
    pub stamped_hz: Option<f64>,
    /// Places of the rows, in sampling intervals from the first row.
    pub places: Vec<usize>,
}

impl Grid {
    /// Sampling intervals, those of missing rows included.
    pub fn slots(&self) -> usize {
        self.places.last().map_or(0, |last| last + 1)
    }

    /// Places without a row.
    pub fn missing(&self) -> usize {
        self.slots() - self.places.len()
    }

    /// Rows without time stamps: one each 1 / `rate_hz`.
    pub fn even(rows: usize, rate_hz: f64) -> Self {
        Self {
            rate_hz,
            rate_sigma_hz: 0.0,
            stamped_hz: None,
            places: (0..rows).collect(),
        }
    }

    /// From time stamps in seconds, strictly increasing. A gap counts as rows that are missing. The
    /// rate is that of the straight line through all stamps, unless `rate_hz` overrides it.
    /// `name_row` names a row in errors.
    pub fn from_stamps(
        time_s: &[f64],
        rate_hz: Option<f64>,
        name_row: impl Fn(usize) -> String,
    ) -> Result<Self> {
        let mut clock = RowClock::new(time_s).context("one row alone has no rate")?;
        let places: Vec<usize> = time_s.iter().map(|t_s| clock.push(*t_s) as usize).collect();
        let spacing_s = clock.spacing_s();
        let slots = places.last().map_or(0, |last| last + 1);
        let missing = slots - places.len();
        if missing as f64 > MISSING_MAX * slots as f64 {
            let spacing = |row: &usize| time_s[row + 1] - time_s[*row];
            let widest = (0..time_s.len() - 1)
                .max_by(|a, b| spacing(a).total_cmp(&spacing(b)))
                .unwrap_or(0);
            bail!(
                "{}: a gap of {} s where rows are {} s apart ({missing} of {slots} rows are missing); use --from and --to to stay out of it",
                name_row(widest + 1),
                significant(spacing(&widest), 6),
                significant(spacing_s, 4),
            );
        }
        ensure!(
            spacing_s.recip().is_finite(),
            "the time stamps give no rate"
        );
        let stamped_hz = Some(spacing_s.recip());
        if let Some(rate_hz) = rate_hz {
            return Ok(Self {
                rate_hz,
                rate_sigma_hz: 0.0,
                stamped_hz,
                places,
            });
        }
        let rate_sigma_hz = spacing_sigma_s(&clock, time_s, &places) / (spacing_s * spacing_s);
        Ok(Self {
            rate_hz: spacing_s.recip(),
            rate_sigma_hz,
            stamped_hz,
            places,
        })
    }
}

/// Standard deviation of the spacing of rows.
///
/// Errors from rounding are no noise: they follow from the spacing, repeat in a pattern, and may
/// lie on a slope of their own. But every stamp bounds them. If some spacings put every row within
/// the rounding of its stamp, one of these is true, and any of them as likely as another. If none
/// does, then the stamps jitter, which makes their errors independent.
fn spacing_sigma_s(clock: &RowClock, time_s: &[f64], places: &[usize]) -> f64 {
    let spacing_s = clock.spacing_s();
    let Some(step_s) = resolution_s(time_s) else {
        return clock.spacing_sigma_s(0.0);
    };
    // Range of the rows' distances from an even grid.
    let range_s = |spacing_s: f64| {
        let off_s = time_s
            .iter()
            .zip(places)
            .map(|(t_s, place)| t_s - time_s[0] - *place as f64 * spacing_s);
        let (least, greatest) = off_s.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, g), off| {
            (off.min(l), off.max(g))
        });
        greatest - least
    };
    // Stamps on an even grid are taken for exact ones: 0.01, 0.02, 0.03.
    if range_s(spacing_s) < 1e-3 * step_s {
        return clock.spacing_sigma_s(0.0);
    }
    let is_possible = |spacing_s: f64| range_s(spacing_s) <= step_s * (1.0 + 1e-3);
    let reach_s = 2.0 * step_s / places.last().map_or(1.0, |last| *last as f64);
    let (mut low, mut high) = (spacing_s - reach_s, spacing_s + reach_s);
    // The range is convex in the spacing: halve towards its least value.
    let mut inside = spacing_s;
    while !is_possible(inside) {
        let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if right - left < 1e-9 * reach_s {
            return clock.spacing_sigma_s(step_s / 12f64.sqrt());
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
    let (least, most) = (edge(spacing_s - reach_s), edge(spacing_s + reach_s));
    ((most - least) / 12f64.sqrt()).hypot(spacing_s - 0.5 * (least + most))
}

/// The step of the stamps' last decimal, seconds; none if they have more decimals than stand for a
/// rounding.
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

    fn named(row: usize) -> String {
        format!("row {}", row + 1)
    }

    #[test]
    fn jitter_of_a_millisecond_is_averaged_out() {
        let stamps: Vec<f64> = (0..1000)
            .map(|i| (i as f64 * 28.0909).floor() * 1e-3)
            .collect();
        let grid = Grid::from_stamps(&stamps, None, named).unwrap();
        assert_eq!(grid.places, (0..1000).collect::<Vec<_>>());
        assert!(
            (grid.rate_hz * 28.0909e-3 - 1.0).abs() < 1e-5,
            "{}",
            grid.rate_hz
        );
    }

    #[test]
    fn a_gap_is_rows_that_are_missing() {
        let stamps: Vec<f64> = (0..100)
            .filter(|i| !(40..43).contains(i))
            .map(|i| f64::from(i) * 0.01)
            .collect();
        let grid = Grid::from_stamps(&stamps, None, named).unwrap();
        assert_eq!((grid.slots(), grid.missing()), (100, 3));
        assert_eq!(grid.places[39..41], [39, 43]);
        assert!((grid.rate_hz - 100.0).abs() < 1e-9);
    }

    #[test]
    fn a_pause_is_refused_and_its_row_named() {
        let stamps: Vec<f64> = (0..100)
            .map(|i| f64::from(i) * 0.01 + if i < 60 { 0.0 } else { 30.0 })
            .collect();
        let error = Grid::from_stamps(&stamps, None, named)
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("row 61: a gap of 30.0100 s"), "{error}");
        assert!(Grid::from_stamps(&[1.0], None, named).is_err());
    }
}
