//! Detects a single series written with several samples per row.

/// Minimum number of rows for the detection.
const ROWS_MIN: usize = 24;

/// Minimum number of samples per row. Two channels a quarter of a cycle apart look like a series
/// with two samples per row.
const WIDTH_MIN: usize = 3;

/// Maximum ratio of steps within rows to steps between rows, in a single series.
const RATIO_MAX: f64 = 1.5;

/// Maximum deviation of a column's mean from the overall mean in a single series, in standard
/// deviations.
const MEANS_APART: f64 = 0.5;

/// True if the columns are consecutive samples: the step from the end of a row to the beginning of
/// the next is as large as steps within a row, and smaller than both the steps down a column and
/// the scatter of all values. All `rows` have the same number of values.
pub fn is_wrapped(rows: &[Vec<f64>]) -> bool {
    let width = rows.first().map_or(0, Vec::len);
    if width < WIDTH_MIN
        || rows.len() < ROWS_MIN
        || rows.iter().flatten().any(|value| !value.is_finite())
    {
        return false;
    }
    let mean_square = |steps: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = steps.fold((0.0, 0.0), |(sum, count), step| {
            (sum + step * step, count + 1.0)
        });
        sum / f64::max(count, 1.0)
    };
    let pairs = || rows.windows(2);
    let end = mean_square(&mut pairs().map(|pair| pair[1][0] - pair[0][width - 1]));
    let within: Vec<f64> = (1..width)
        .map(|at| mean_square(&mut rows.iter().map(|row| row[at] - row[at - 1])))
        .collect();
    let down = mean_square(&mut pairs().flat_map(|pair| {
        pair[0]
            .iter()
            .zip(&pair[1])
            .map(|(before, after)| after - before)
    }));
    let values = || rows.iter().flatten();
    let mean = values().sum::<f64>() / (rows.len() * width) as f64;
    let variance = mean_square(&mut values().map(|value| value - mean));
    let alike = within
        .iter()
        .all(|step| *step < RATIO_MAX * end && end < RATIO_MAX * step);
    let columns = (0..width).map(|at| {
        let column = || rows.iter().map(move |row| row[at]);
        let level = column().sum::<f64>() / rows.len() as f64;
        (level, mean_square(&mut column().map(|value| value - level)))
    });
    let is_one = columns.into_iter().all(|(level, scatter)| {
        let is_level = (level - mean).abs() < MEANS_APART * variance.sqrt();
        is_level && scatter < RATIO_MAX * variance && variance < RATIO_MAX * scatter
    });
    // The mean square difference of two samples of white noise is twice the variance.
    alike && is_one && end < variance && end < 0.7 * down
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(number: usize) -> f64 {
        ((number as f64 * 12.9898).sin() * 43_758.545).fract().abs() - 0.5
    }

    fn rows(width: usize, value: impl Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
        (0..120)
            .map(|row| {
                (0..width)
                    .map(|at| value(row, at) + 0.1 * noise(row * width + at))
                    .collect()
            })
            .collect()
    }

    #[test]
    fn a_wrapped_series_is_told_from_channels() {
        let tone = |phase: f64| (std::f64::consts::TAU * phase).sin();
        for width in [3, 5, 6, 8, 50] {
            for per_sample in [0.0185, 0.03, 0.05] {
                let series = rows(width, |row, at| {
                    tone((row * width + at) as f64 * per_sample)
                });
                // If the row length is a whole number of periods, all rows are alike.
                assert!(
                    is_wrapped(&series) || width == 50 && per_sample != 0.0185,
                    "{width} {per_sample}"
                );
            }
            for (per_row, per_column) in [
                (0.02, 0.0),
                (0.02, 1.0 / 3.0),
                (0.3, 0.0),
                (0.02, 0.1),
                (0.26, 0.16),
                (0.26, 0.1),
                (0.45, 0.2),
            ] {
                let channels = rows(width, |row, at| {
                    tone(row as f64 * per_row + at as f64 * per_column) + at as f64
                });
                assert!(!is_wrapped(&channels), "{width} {per_row} {per_column}");
                let channels = rows(width, |row, at| {
                    tone(row as f64 * per_row + at as f64 * per_column)
                });
                // Phases that continue from the last channel to the next row look like a single
                // series.
                let gap = width as f64 * per_column - per_row;
                let goes_on = per_column > 0.0 && (gap - gap.round()).abs() < 0.05;
                assert!(
                    goes_on || !is_wrapped(&channels),
                    "{width} {per_row} {per_column}, no offset"
                );
            }
        }
        assert!(!is_wrapped(&rows(3, |_, _| 0.0)), "noise");
    }
}
