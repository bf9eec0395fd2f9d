//! Maps rows with time stamps onto an even grid, or keeps the stamped times if there is no grid.

use crate::digits::significant;
use crate::part::{Part, Selection};
use crate::speed::{Column, Quantity};
use crate::tables::{RowClock, Spacing, spacing};
use anyhow::{Context, Result, bail, ensure};

/// Fraction of missing rows above which the time stamps do not count as steady sampling with a few
/// rows lost.
const MISSING_MAX: f64 = 0.2;

/// Length of a gap, as a fraction of the whole time, above which it separates two recordings.
const PAUSE_FRACTION: f64 = 0.5;

/// Maximum distance of stamps from multiples of a supplied spacing, as a fraction of the spacing.
/// Stamps closer than this show which rows are missing.
const ON_GRID: f64 = 0.2;

/// Standard deviation of the spacings, as a fraction of their mean, above which rows may have been
/// sampled at their stamped times instead of on an even grid.
const SCATTER_MAX: f64 = 0.02;

/// Maximum number of grid positions per row of a file, if the rate is supplied.
const SLOTS_MAX: usize = 16;

#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    pub rate_hz: f64,
    /// Standard deviation of the rate; zero for a supplied rate.
    pub rate_sigma_hz: f64,
    /// Rate according to the time stamps, if there are any.
    pub stamped_hz: Option<f64>,
    /// Position of each row on the grid, in sampling intervals from the first row.
    pub places: Vec<usize>,
    /// Times of the rows in seconds from the first one, if they are not evenly spaced (the rate is
    /// then the mean); otherwise empty.
    pub uneven_s: Vec<f64>,
    /// Standard deviation of the spacings, as a fraction of their mean; zero if rounding of the
    /// stamps explains it, or for a supplied rate.
    pub scatter: f64,
}

impl Grid {
    /// Returns the number of sampling intervals, including those of missing rows.
    pub fn slots(&self) -> usize {
        self.places.last().map_or(0, |last| last + 1)
    }

    /// Returns the number of sampling intervals without a row.
    pub fn missing(&self) -> usize {
        self.slots() - self.places.len()
    }

    /// Returns the time in seconds between two rows, given by their numbers in the part.
    pub fn between_s(&self, from: usize, to: usize) -> f64 {
        match self.uneven_s[..] {
            [] => (self.places[to] - self.places[from]) as f64 / self.rate_hz,
            _ => self.uneven_s[to] - self.uneven_s[from],
        }
    }

    /// Makes a grid for rows without time stamps, 1 / `rate_hz` apart.
    pub fn even(rows: usize, rate_hz: f64) -> Self {
        Self {
            rate_hz,
            rate_sigma_hz: 0.0,
            stamped_hz: None,
            places: (0..rows).collect(),
            uneven_s: Vec::new(),
            scatter: 0.0,
        }
    }

    /// Makes a grid of rows at their stamped times.
    fn uneven(time_s: &[f64]) -> Self {
        let length_s = time_s[time_s.len() - 1] - time_s[0];
        Self {
            uneven_s: time_s.iter().map(|t_s| t_s - time_s[0]).collect(),
            ..Self::even(time_s.len(), (time_s.len() - 1) as f64 / length_s)
        }
    }

    /// Returns the same rows at their stamped times if these scatter about the grid. The readings
    /// can show whether the sampling or only the stamps were uneven.
    pub fn at_own_times(&self, time_s: &[f64]) -> Option<Self> {
        (self.scatter > SCATTER_MAX).then(|| Self::uneven(time_s))
    }

    /// Returns the positions of all sampling intervals (millimetres from the first) by linear
    /// interpolation between the rows' values in a column. NaN marks a missing value.
    pub fn positions_mm(&self, column: &Column, values: &[f64]) -> Result<Vec<f32>, String> {
        let mm_per_unit = column.mm_per_unit(values)?;
        let first = values.first().copied().unwrap_or(0.0);
        let mut at_rows = Vec::with_capacity(values.len());
        let (mut position_mm, mut before) = (0.0, (0usize, first));
        for (row, value) in values
            .iter()
            .enumerate()
            .filter(|(_, value)| !value.is_nan())
        {
            position_mm = match column.quantity() {
                Quantity::Position => value - first,
                Quantity::Speed => {
                    position_mm + 0.5 * (before.1 + value) * self.between_s(before.0, row)
                }
            };
            before = (row, *value);
            at_rows.push((self.places[row], position_mm * mm_per_unit));
        }
        let mut positions = vec![0.0; self.slots()];
        for pair in at_rows.windows(2) {
            let ((from, from_mm), (to, to_mm)) = (pair[0], pair[1]);
            for (since, position) in positions[from..=to].iter_mut().enumerate() {
                *position =
                    (from_mm + (to_mm - from_mm) * since as f64 / (to - from) as f64) as f32;
            }
        }
        Ok(positions)
    }

    /// Makes the grid of a part of a recording, from a supplied rate or from its stamps.
    pub fn of(part: &Part, file: &str, selection: &Selection) -> Result<Self> {
        if !part.is_stamped {
            let rate_hz = selection.rate_hz.with_context(|| {
                format!("{file}: nothing says when its rows were: give their rate with --rate HZ")
            })?;
            return Ok(Self::even(part.rows(), rate_hz));
        }
        let name_row = |row: usize| {
            let (number, time_s) = (part.before + row as u64 + 1, part.times_s[row]);
            format!("row {number} (time_s {time_s})")
        };
        Self::from_stamps(&part.times_s, selection.rate_hz, name_row)
            .with_context(|| file.to_owned())
    }

    /// Makes a grid from time stamps in seconds, strictly increasing unless `rate_hz` overrides
    /// them. A gap counts as missing rows. The rate is that of the straight line through all
    /// stamps. `name_row` names a row in errors.
    pub fn from_stamps(
        time_s: &[f64],
        rate_hz: Option<f64>,
        name_row: impl Fn(usize) -> String,
    ) -> Result<Self> {
        if let Some(rate_hz) = rate_hz {
            return Self::given(time_s, rate_hz, &name_row);
        }
        let mut clock = RowClock::new(time_s).context("one row alone has no rate")?;
        let places = numbered(&mut clock, time_s);
        let spacing_s = clock.spacing_s();
        ensure!(
            spacing_s.recip().is_finite(),
            "the time stamps give no rate"
        );
        if is_steady(&places) {
            let Spacing { sigma_s, is_even } = spacing(&clock, time_s, &places);
            return Ok(Self {
                rate_hz: spacing_s.recip(),
                rate_sigma_hz: sigma_s / (spacing_s * spacing_s),
                stamped_hz: Some(spacing_s.recip()),
                scatter: if is_even {
                    0.0
                } else {
                    scatter(time_s, &places, spacing_s)
                },
                places,
                uneven_s: Vec::new(),
            });
        }
        check_pause(time_s, &name_row)?;
        Ok(Self::uneven(time_s))
    }

    /// Makes a grid at a supplied rate. The stamps, at whatever rate, only show which rows are
    /// missing.
    fn given(time_s: &[f64], rate_hz: f64, name_row: &dyn Fn(usize) -> String) -> Result<Self> {
        let even = Self::even(time_s.len(), rate_hz);
        let increases = time_s.windows(2).all(|pair| pair[1] > pair[0]);
        let Some(mut clock) = RowClock::new(time_s).filter(|_| increases) else {
            return Ok(even);
        };
        let places = numbered(&mut clock, time_s);
        let stamped_hz = Some(clock.spacing_s().recip());
        if is_steady(&places) {
            return Ok(Self {
                stamped_hz,
                places,
                ..even
            });
        }
        check_pause(time_s, name_row)?;
        let exact = time_s.iter().map(|t_s| (t_s - time_s[0]) * rate_hz);
        let is_on_grid = exact
            .clone()
            .all(|place| (place - place.round()).abs() < ON_GRID);
        let rounded: Vec<usize> = exact.map(|place| place.round() as usize).collect();
        let are_apart = rounded.windows(2).all(|pair| pair[1] > pair[0]);
        // Stamps of a different rate would need far more positions than the file has rows.
        let slots = rounded.last().map_or(0, |last| last + 1);
        if is_on_grid && are_apart && slots <= SLOTS_MAX * time_s.len() {
            return Ok(Self {
                stamped_hz: Some(rate_hz),
                places: rounded,
                ..even
            });
        }
        Ok(even)
    }
}

/// Refuses rows in which a gap takes more than half the time.
fn check_pause(time_s: &[f64], name_row: &dyn Fn(usize) -> String) -> Result<()> {
    let spacing = |row: &usize| time_s[row + 1] - time_s[*row];
    let widest = (0..time_s.len() - 1).max_by(|a, b| spacing(a).total_cmp(&spacing(b)));
    let (widest, length_s) = (widest.unwrap_or(0), time_s[time_s.len() - 1] - time_s[0]);
    if spacing(&widest) > PAUSE_FRACTION * length_s {
        bail!(
            "{}: a gap of {} s in {} s of data; use --from and --to to stay out of it",
            name_row(widest + 1),
            significant(spacing(&widest), 6),
            significant(length_s, 4),
        );
    }
    Ok(())
}

fn numbered(clock: &mut RowClock, time_s: &[f64]) -> Vec<usize> {
    time_s.iter().map(|t_s| clock.push(*t_s) as usize).collect()
}

/// Returns the RMS deviation of the rows' spacings from whole numbers of sampling intervals, as a
/// fraction of an interval.
fn scatter(time_s: &[f64], places: &[usize], spacing_s: f64) -> f64 {
    let pairs = time_s.windows(2).zip(places.windows(2));
    let off = pairs.map(|(time_s, places)| {
        (time_s[1] - time_s[0]) / spacing_s - (places[1] - places[0]) as f64
    });
    let count = time_s.len().saturating_sub(1).max(1) as f64;
    (off.map(|off| off * off).sum::<f64>() / count).sqrt()
}

/// True if rows at these positions are evenly sampled, with only a few missing.
fn is_steady(places: &[usize]) -> bool {
    let slots = places.last().map_or(0, |last| last + 1);
    (slots - places.len()) as f64 <= MISSING_MAX * slots as f64
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
    fn rows_that_are_nowhere_near_even_keep_their_times() {
        let stamps: Vec<f64> = (0..100)
            .map(|i| 5.0 + f64::from(i / 2) * 0.01 + f64::from(i % 2) * 0.008)
            .collect();
        let grid = Grid::from_stamps(&stamps, None, named).unwrap();
        assert!((grid.rate_hz - 200.0).abs() < 2.0, "{}", grid.rate_hz);
        assert!((grid.between_s(0, 3) - 0.018).abs() < 1e-9 && grid.missing() == 0);
        // A supplied rate overrides the stamps.
        let given = Grid::from_stamps(&stamps, Some(200.0), named).unwrap();
        assert_eq!(given, Grid::even(100, 200.0));
        let dropped: Vec<f64> = (0..100)
            .filter(|i| i % 5 < 3)
            .map(|i| f64::from(i) * 0.004)
            .collect();
        let given = Grid::from_stamps(&dropped, Some(250.0), named).unwrap();
        assert_eq!((given.slots(), given.missing()), (98, 38));
        let backwards = Grid::from_stamps(&[3.0, 1.0, 2.0], Some(10.0), named).unwrap();
        assert_eq!(backwards, Grid::even(3, 10.0));
    }

    #[test]
    fn a_pause_is_refused_and_its_row_named() {
        let stamps: Vec<f64> = (0..100)
            .map(|i| f64::from(i) * 0.01 + if i < 60 { 0.0 } else { 30.0 })
            .collect();
        let error = Grid::from_stamps(&stamps, None, named)
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("row 61: a gap of 30.0100 s in 30.99 s"),
            "{error}"
        );
        assert!(Grid::from_stamps(&[1.0], None, named).is_err());
    }
}
