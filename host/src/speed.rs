//! Speeds and places of a recording: a profile for the library, or a column beside the channels.

use crate::grid::Grid;
use anyhow::{Context, Result, bail, ensure};
use hal_mock::Table;
use ridgetone::surface::profile::Profile;
use ridgetone_proto::profile::{After, Knot};
use std::path::Path;

/// Name of a profile's column of speeds.
pub const SPEED_COLUMN: &str = "speed_mm_s";

/// Behaviour after a profile's last knot.
pub const fn after(repeats: bool) -> After {
    if repeats { After::Repeat } else { After::Hold }
}

pub fn profile(path: &Path, after: After) -> Result<Profile> {
    Ok(knots(path, after)?.1)
}

/// Reads a speed profile, and its knots: columns `time_s` (device time) and `speed_mm_s`, one knot
/// a row.
pub fn knots(path: &Path, after: After) -> Result<(Vec<Knot>, Profile)> {
    let table = Table::load(path)?;
    let file = table.file();
    let Some(column) = table.names().iter().position(|name| name == SPEED_COLUMN) else {
        bail!(
            "{file}: no column {SPEED_COLUMN}; there are: {}",
            table.names().join(", ")
        );
    };
    let Some(time_s) = table.time_s() else {
        bail!("{file}: no column time_s")
    };
    let mut knots = Vec::new();
    for (t_s, row) in time_s.iter().zip(table.rows()) {
        let t_us = (t_s * 1e6).round();
        ensure!(
            (0.0..=f64::from(u32::MAX)).contains(&t_us),
            "{file}: time_s {t_s}: choose 0 to 4294 s"
        );
        ensure!(
            !row[column].is_nan(),
            "{file}: time_s {t_s}: no {SPEED_COLUMN}"
        );
        knots.push(Knot {
            t_us: t_us as u32,
            speed_mm_s: row[column] as f32,
        });
    }
    let profile = Profile::new(&knots, after).with_context(|| file.to_owned())?;
    Ok((knots, profile))
}

/// A column with the finger's place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Column {
    /// Its place on the surface, millimetres.
    Position(String),
    /// Its speed over it, millimetres per second.
    Speed(String),
}

impl Column {
    pub fn name(&self) -> &str {
        match self {
            Self::Position(name) | Self::Speed(name) => name,
        }
    }

    /// Places of all sampling intervals, millimetres from the first, from the rows' values, with
    /// straight lines in between. NaN stands for a value that is missing.
    pub fn places_mm(&self, values: &[f64], grid: &Grid) -> Vec<f32> {
        let first = values.first().copied().unwrap_or(0.0);
        let mut at_rows = Vec::with_capacity(values.len());
        let (mut place_mm, mut before) = (0.0, (0usize, first));
        for (slot, value) in grid
            .places
            .iter()
            .zip(values)
            .filter(|(_, value)| !value.is_nan())
        {
            place_mm = match self {
                Self::Position(_) => value - first,
                Self::Speed(_) => {
                    place_mm
                        + 0.5 * (before.1 + value) * (slot.saturating_sub(before.0)) as f64
                            / grid.rate_hz
                }
            };
            before = (*slot, *value);
            at_rows.push((*slot, place_mm));
        }
        let mut places = vec![0.0; grid.slots()];
        for pair in at_rows.windows(2) {
            let ((from, from_mm), (to, to_mm)) = (pair[0], pair[1]);
            for (since, place) in places[from..=to].iter_mut().enumerate() {
                *place = (from_mm + (to_mm - from_mm) * since as f64 / (to - from) as f64) as f32;
            }
        }
        places
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_are_summed_and_gaps_filled() {
        let grid = Grid {
            places: vec![0, 1, 4, 5],
            ..Grid::even(0, 10.0)
        };
        let speed = Column::Speed("v".into()).places_mm(&[10.0, 20.0, 20.0, -40.0], &grid);
        assert_eq!(speed, [0.0, 1.5, 3.5, 5.5, 7.5, 6.5]);
        let blank = Column::Speed("v".into()).places_mm(&[10.0, f64::NAN, 20.0, -40.0], &grid);
        assert_eq!(blank, [0.0, 1.5, 3.0, 4.5, 6.0, 5.0]);
        let position = Column::Position("x".into()).places_mm(&[7.0, 8.0, 11.0, 9.0], &grid);
        assert_eq!(position, [0.0, 1.0, 2.0, 3.0, 4.0, 2.0]);
    }
}
