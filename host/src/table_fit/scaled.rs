//! Converts the rows of a part to the estimator's input.

use super::bridge;
use crate::grid::Grid;
use crate::part::Part;
use core::ops::Range;
use ridgetone_proto::settings::TAXELS;

/// Span to which each channel is scaled, about that of a real channel in codes. Quantization to 1
/// is then far below any file's residuals.
const SPAN_CODES: f64 = 1e6;

/// The channels of a part on its grid, with their scales. The readings stay in the part, so that
/// only the rows being fitted are copied.
pub struct Channels<'a> {
    part: &'a Part,
    columns: &'a [usize],
    grid: &'a Grid,
    /// First value of each channel, subtracted before rounding to f32.
    pub zeros: Vec<f64>,
    /// File units per unit of [`Scaled::values`].
    pub units: Vec<f64>,
    /// Number of readings that are not missing.
    pub readings: usize,
}

impl<'a> Channels<'a> {
    pub fn new(part: &'a Part, columns: &'a [usize], grid: &'a Grid) -> Self {
        let (mut zeros, mut units, mut readings) = (Vec::new(), Vec::new(), 0);
        for column in columns {
            let column = part.column(*column);
            let mut known = column.iter().copied().filter(|value| !value.is_nan());
            let zero = known.next().unwrap_or(0.0);
            let (mut min, mut max) = (zero, zero);
            for value in known {
                (min, max) = (value.min(min), value.max(max));
            }
            let span = max - min;
            // The fit leaves a constant channel out, whatever its unit.
            let unit = if span > f64::MIN_POSITIVE * SPAN_CODES {
                span / SPAN_CODES
            } else {
                1.0
            };
            readings += column.iter().filter(|value| !value.is_nan()).count();
            zeros.push(zero);
            units.push(unit);
        }
        Self {
            part,
            columns,
            grid,
            zeros,
            units,
            readings,
        }
    }

    /// Returns the number of sampling intervals, including those of missing rows.
    pub fn slots(&self) -> usize {
        self.grid.slots()
    }

    /// Copies the rows in a range of sampling intervals.
    pub fn cut(&self, slots: Range<usize>) -> Scaled {
        let mut cut = Scaled::empty(slots.len(), self.columns.len());
        self.each(slots.clone(), &mut |slot, values, valid| {
            cut.values[slot - slots.start] = *values;
            cut.valid[slot - slots.start] = valid;
        });
        cut
    }

    /// Calls `take` for each row in a range of sampling intervals, with the interval, the scaled
    /// readings, and a bit for each present reading.
    pub fn each(&self, slots: Range<usize>, take: &mut dyn FnMut(usize, &[f32; TAXELS], u16)) {
        let places = &self.grid.places;
        let [from, to] = [slots.start, slots.end].map(|end| places.partition_point(|at| *at < end));
        for (row, place) in (from..to).zip(&places[from..to]) {
            let (mut values, mut valid) = ([0.0; TAXELS], 0);
            for (c, column) in self.columns.iter().enumerate() {
                let value = self.part.value(row, *column);
                if !value.is_nan() {
                    values[c] = ((value - self.zeros[c]) / self.units[c]) as f32;
                    valid |= 1 << c;
                }
            }
            take(*place, &values, valid);
        }
    }
}

/// Rows in the form that the library accepts.
#[derive(Clone)]
pub struct Scaled {
    pub values: Vec<[f32; TAXELS]>,
    pub valid: Vec<u16>,
    channels: usize,
}

impl Scaled {
    /// Rows without a reading.
    pub fn empty(rows: usize, channels: usize) -> Self {
        Self {
            values: vec![[0.0; TAXELS]; rows],
            valid: vec![0; rows],
            channels,
        }
    }

    /// Returns the fraction of rows that have all readings, ignoring empty rows and channels.
    pub fn whole_fraction(&self) -> f64 {
        let all = self.valid.iter().fold(0, |all, valid| all | valid);
        let count =
            |is: &dyn Fn(u16) -> bool| self.valid.iter().filter(|valid| is(**valid)).count() as f64;
        count(&|valid| valid == all) / count(&|valid| valid != 0).max(1.0)
    }

    /// Returns a copy with single missing readings bridged; rows that are missing stay missing.
    pub fn bridged(&self) -> Self {
        let mut bridged = self.clone();
        for c in 0..self.channels {
            let readings = self.values.iter().zip(&self.valid);
            let known: Vec<_> = readings
                .map(|(values, valid)| (valid & 1 << c != 0).then_some(f64::from(values[c])))
                .collect();
            for (slot, value) in bridge::bridged(&known)
                .into_iter()
                .filter(|(slot, _)| self.valid[*slot] != 0)
            {
                bridged.values[slot][c] = value as f32;
                bridged.valid[slot] |= 1 << c;
            }
        }
        bridged
    }
}
