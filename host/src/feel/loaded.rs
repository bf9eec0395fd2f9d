//! The samples of a recording, evenly spaced, channel by channel.

use crate::grid::Grid;
use crate::part::Part;
use crate::samples::Samples;
use crate::table_fit::{Selection, columns};
use anyhow::{Result, ensure};
use std::ops::Range;

/// Most rows of a recording: seven minutes at 10 kHz, half a gigabyte of sixteen channels.
const ROWS_MAX: usize = 1 << 22;

/// Amplitudes that f32 can square together with the noise next to them.
const SQUARED: Range<f32> = 1e-15..1e15;

/// The samples of a part of a recording, channel by channel.
pub struct Loaded {
    pub file: String,
    pub rate_hz: f64,
    pub rows: usize,
    pub rows_missing: usize,
    pub readings_missing: usize,
    pub channels: Vec<(String, Vec<f32>)>,
    pub guessed: Option<String>,
}

impl Loaded {
    pub fn read(
        samples: &Samples,
        selection: &Selection,
        progress: &mut dyn FnMut(u64),
    ) -> Result<Self> {
        let rows = &mut *samples.open()?;
        let columns = columns(rows, selection)?;
        let part = Part::read(rows, selection, ROWS_MAX, progress)?;
        let file = rows.file().to_owned();
        let grid = Grid::of(&part, &file, selection)?;
        ensure!(
            grid.uneven_s.is_empty(),
            "{file}: its rows are not evenly spaced in time, as spectra need: give their rate with --rate HZ if the stamps are wrong"
        );
        let mut readings_missing = 0;
        let mut channel = |column: &usize| {
            let column_values = part.column(*column);
            let readings = grid.places.iter().zip(column_values.iter());
            let readings = readings.map(|(place, value)| (*place, *value));
            let known: Vec<(usize, f64)> = readings.filter(|(_, value)| !value.is_nan()).collect();
            readings_missing += part.rows() - known.len();
            let values = bridged(&known, grid.slots());
            let name = rows.names()[*column].clone();
            let greatest = values
                .iter()
                .fold(0.0, |greatest: f32, value| greatest.max(value.abs()));
            ensure!(
                greatest == 0.0 || SQUARED.contains(&greatest),
                "{file}: column {name}: its values differ by {greatest:e}, which f32 cannot square: scale them"
            );
            Ok((name, values))
        };
        let channels = columns.iter().map(&mut channel).collect::<Result<_>>()?;
        let (rate_hz, rows_missing) = (grid.rate_hz, grid.missing());
        Ok(Self {
            file,
            rate_hz,
            rows: part.rows(),
            rows_missing,
            readings_missing,
            channels,
            guessed: rows.guessed(),
        })
    }

    /// Samples of a channel, missing rows included.
    pub fn slots(&self) -> usize {
        self.rows + self.rows_missing
    }
}

/// Readings at their places, less the first one; straight lines where readings are missing. Zeros
/// without any reading.
fn bridged(known: &[(usize, f64)], slots: usize) -> Vec<f32> {
    let mut values = vec![0.0; slots];
    let Some((_, first)) = known.first().copied() else {
        return values;
    };
    for pair in known.windows(2) {
        let [(from, a), (to, b)] = [pair[0], pair[1]];
        for (step, value) in values[from..to].iter_mut().enumerate() {
            *value = (a - first + (b - a) * step as f64 / (to - from) as f64) as f32;
        }
    }
    if let Some((last, value)) = known.last() {
        values[*last..].fill((value - first) as f32);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_readings_are_bridged() {
        assert_eq!(
            bridged(&[(1, 10.0), (2, 12.0), (4, 16.0)], 6),
            [0.0, 0.0, 2.0, 4.0, 6.0, 6.0]
        );
        assert_eq!(bridged(&[], 2), [0.0, 0.0]);
    }
}
