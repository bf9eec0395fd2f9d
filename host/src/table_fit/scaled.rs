//! The rows of a part as the estimator takes them.

use super::bridge;
use crate::grid::Grid;
use crate::part::Part;
use ridgetone_proto::settings::TAXELS;

/// Channels are scaled to about the span of a real channel in codes. Quantization to 1 is then far
/// below any file's residuals.
const SPAN_CODES: f64 = 1e6;

/// The rows as the library takes them.
#[derive(Clone)]
pub struct Scaled {
    pub values: Vec<[f32; TAXELS]>,
    pub valid: Vec<u16>,
    /// First value of each channel: subtracted before anything is rounded to f32.
    pub zeros: Vec<f64>,
    /// File units per unit of `values`.
    pub units: Vec<f64>,
    /// Readings of the file.
    pub readings: usize,
}

impl Scaled {
    pub fn new(part: &Part, columns: &[usize], grid: &Grid) -> Self {
        let mut scaled = Self {
            values: vec![[0.0; TAXELS]; grid.slots()],
            valid: vec![0; grid.slots()],
            zeros: Vec::new(),
            units: Vec::new(),
            readings: 0,
        };
        for (c, column) in columns.iter().enumerate() {
            let column = part.column(*column);
            let zero = column.iter().copied().find(|value| !value.is_nan());
            let zero = zero.unwrap_or(0.0);
            let (mut least, mut greatest) = (zero, zero);
            for value in column.iter() {
                if *value < least {
                    least = *value;
                } else if *value > greatest {
                    greatest = *value;
                }
            }
            let span = greatest - least;
            // The fit leaves a constant channel out, whatever its unit.
            let unit = if span > f64::MIN_POSITIVE * SPAN_CODES {
                span / SPAN_CODES
            } else {
                1.0
            };
            for (value, place) in column.iter().zip(&grid.places) {
                if value.is_nan() {
                    continue;
                }
                scaled.values[*place][c] = ((value - zero) / unit) as f32;
                scaled.valid[*place] |= 1 << c;
                scaled.readings += 1;
            }
            scaled.zeros.push(zero);
            scaled.units.push(unit);
        }
        scaled
    }

    /// Fraction of the rows that have all readings of the channels that have any.
    pub fn whole_share(&self) -> f64 {
        let all = self.valid.iter().fold(0, |all, valid| all | valid);
        let count =
            |is: &dyn Fn(u16) -> bool| self.valid.iter().filter(|valid| is(**valid)).count() as f64;
        count(&|valid| valid == all) / count(&|valid| valid != 0).max(1.0)
    }

    /// Without any frames.
    pub fn clone_head(&self) -> Self {
        Self {
            values: Vec::new(),
            valid: Vec::new(),
            zeros: self.zeros.clone(),
            units: self.units.clone(),
            ..*self
        }
    }

    /// A copy with single missing readings bridged; whole missing rows stay missing.
    pub fn bridged(&self) -> Self {
        let mut bridged = self.clone();
        for c in 0..self.units.len() {
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
