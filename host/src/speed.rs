//! A column of speeds or places beside the channels of a recording.

use crate::grid::Grid;

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
