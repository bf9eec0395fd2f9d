//! Rows with time stamps onto an even grid: the fit takes one row per sampling interval.

use crate::digits::significant;
use anyhow::{Result, bail, ensure};

/// A spacing of more than this many median spacings is a gap: rows are missing in it.
const GAP: f64 = 1.5;

/// Share of missing rows above which the time stamps are no steady sampling with a few rows lost.
const MISSING_MAX: f64 = 0.2;

#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    pub rate_hz: f64,
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
        Self { rate_hz, places: (0..rows).collect() }
    }

    /// From time stamps in seconds, strictly increasing. Jitter is harmless; a gap counts as rows that are missing.
    /// `rate_hz` overrides the rate, which is otherwise the mean one. `name_row` names a row in errors.
    pub fn from_stamps(time_s: &[f64], rate_hz: Option<f64>, name_row: impl Fn(usize) -> String) -> Result<Self> {
        let spacings: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let Some(median_s) = median(&spacings) else {
            bail!("one row alone has no rate");
        };
        let mut places = vec![0];
        let mut place = 0;
        for spacing_s in &spacings {
            let steps = if *spacing_s > GAP * median_s { (spacing_s / median_s).round() } else { 1.0 };
            // Clipped, so that a stamp in another century is refused below and does not overflow.
            place += steps.min(1e9) as usize;
            places.push(place);
        }
        let missing = place + 1 - places.len();
        if missing as f64 > MISSING_MAX * (place + 1) as f64 {
            let widest = (0..spacings.len()).max_by(|a, b| spacings[*a].total_cmp(&spacings[*b])).unwrap_or(0);
            bail!(
                "{}: a gap of {} s where rows are {} s apart ({missing} of {} rows are missing); use --from and --to to stay out of it",
                name_row(widest + 1),
                significant(spacings[widest], 6),
                significant(median_s, 4),
                place + 1,
            );
        }
        let mean_hz = place as f64 / (time_s[time_s.len() - 1] - time_s[0]);
        let rate_hz = rate_hz.unwrap_or(mean_hz);
        ensure!(rate_hz.is_finite(), "the time stamps give no rate");
        Ok(Self { rate_hz, places })
    }
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(row: usize) -> String {
        format!("row {}", row + 1)
    }

    #[test]
    fn jitter_of_a_millisecond_is_averaged_out() {
        let stamps: Vec<f64> = (0..1000).map(|i| (i as f64 * 28.0909).floor() * 1e-3).collect();
        let grid = Grid::from_stamps(&stamps, None, named).unwrap();
        assert_eq!(grid.places, (0..1000).collect::<Vec<_>>());
        assert!((grid.rate_hz / 35.5987 - 1.0).abs() < 1e-4, "{}", grid.rate_hz);
    }

    #[test]
    fn a_gap_is_rows_that_are_missing() {
        let stamps: Vec<f64> = (0..100).filter(|i| !(40..43).contains(i)).map(|i| f64::from(i) * 0.01).collect();
        let grid = Grid::from_stamps(&stamps, None, named).unwrap();
        assert_eq!((grid.slots(), grid.missing()), (100, 3));
        assert_eq!(grid.places[39..41], [39, 43]);
        assert!((grid.rate_hz - 100.0).abs() < 1e-9);
    }

    #[test]
    fn a_pause_is_refused_and_its_row_named() {
        let stamps: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.01 + if i < 60 { 0.0 } else { 30.0 }).collect();
        let error = Grid::from_stamps(&stamps, None, named).unwrap_err().to_string();
        assert!(error.starts_with("row 61: a gap of 30.0100 s"), "{error}");
        assert!(Grid::from_stamps(&[1.0], None, named).is_err());
    }
}
