//! Information of a window about its frequency, and the projection of columns on each other.

/// A column of which the others leave less than this share of its length is one of theirs.
const DEPENDENT: f64 = 1e-9;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clue {
    /// Fisher information, one over hertz squared.
    pub information: f64,
    /// Derivative of the log-likelihood by the frequency at the truth, for the noise of a window;
    /// one over hertz.
    pub score: f64,
}

impl Clue {
    /// What values say of a frequency, if `derivative` is theirs by it and `basis` is unknown: of
    /// white noise of variance one.
    pub fn of(mut derivative: Vec<f64>, values: &[f64], basis: &[Vec<f64>]) -> Self {
        let whole = length(&derivative);
        remove(&mut derivative, basis);
        let remainder = length(&derivative);
        // A remainder of the size of rounding is no information.
        if remainder <= DEPENDENT * whole {
            return Self::default();
        }
        Self {
            information: remainder.powi(2),
            score: derivative
                .iter()
                .zip(values)
                .map(|(part, value)| part * value)
                .sum(),
        }
    }
}

/// Columns of unit length at right angles to each other that span what `columns` span (Gram and
/// Schmidt).
pub fn orthonormal(columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut column in columns {
        let whole = length(&column);
        remove(&mut column, &basis);
        let remainder = length(&column);
        if remainder > DEPENDENT * whole {
            column.iter_mut().for_each(|value| *value /= remainder);
            basis.push(column);
        }
    }
    basis
}

/// Takes off `column` what it has in common with `basis`. Twice: once leaves rounding of the size
/// of what was taken.
pub fn remove(column: &mut [f64], basis: &[Vec<f64>]) {
    for _ in 0..2 {
        for unit in basis {
            let common: f64 = unit.iter().zip(&*column).map(|(a, b)| a * b).sum();
            column
                .iter_mut()
                .zip(unit)
                .for_each(|(value, unit)| *value -= common * unit);
        }
    }
}

fn length(column: &[f64]) -> f64 {
    column.iter().map(|value| value * value).sum::<f64>().sqrt()
}
