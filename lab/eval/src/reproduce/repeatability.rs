//! Repeatability: how alike the runs of a combination are (equation 11).

/// Mean over all pairs of runs of their Pearson correlation, each pair shifted against each other
/// by up to `half_cycle` samples to where it is greatest, over what overlaps then. None for less
/// than two runs.
pub fn correlation(runs: &[Vec<f64>], half_cycle: usize) -> Option<f64> {
    let pairs = (0..runs.len()).flat_map(|l| (0..l).map(move |p| (l, p)));
    let each: Vec<f64> = pairs
        .map(|(l, p)| shifted(&runs[l], &runs[p], half_cycle))
        .collect();
    // Equation 11 sums over 12 ordered pairs; two of them are one of these, taken twice.
    (!each.is_empty()).then(|| each.iter().sum::<f64>() / each.len() as f64)
}

fn shifted(a: &[f64], b: &[f64], most: usize) -> f64 {
    let later = |x: &[f64], y: &[f64]| {
        (0..=most)
            .filter_map(|by| Some(pearson(x.get(by..)?, y)))
            .fold(f64::NEG_INFINITY, f64::max)
    };
    later(a, b).max(later(b, a))
}

/// Pearson's correlation of two series over the length of the shorter; 0 where one does not vary.
fn pearson(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len().min(b.len());
    let mean = |x: &[f64]| x[..count].iter().sum::<f64>() / count as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let sums = a
        .iter()
        .zip(b)
        .fold((0.0, 0.0, 0.0), |(ab, aa, bb), (a, b)| {
            let (a, b) = (a - mean_a, b - mean_b);
            (ab + a * b, aa + a * a, bb + b * b)
        });
    let (ab, aa, bb) = sums;
    if aa > 0.0 && bb > 0.0 {
        ab / (aa * bb).sqrt()
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine of 40 samples a cycle.
    fn wave(phase: f64) -> Vec<f64> {
        (0..400)
            .map(|n| (std::f64::consts::TAU * f64::from(n) / 40.0 + phase).sin())
            .collect()
    }

    #[test]
    fn a_shift_of_up_to_half_a_cycle_does_not_count() {
        let alike = correlation(&[wave(0.0), wave(1.0), wave(-1.5)], 20).expect("three runs");
        assert!(alike > 0.99, "{alike}");
        // Without the shift it is the cosine of the phase.
        assert!((pearson(&wave(0.0), &wave(1.0)) - 1f64.cos()).abs() < 1e-9);
        assert_eq!(correlation(&[wave(0.0)], 20), None);
    }

    #[test]
    fn what_differs_lowers_it() {
        // Two runs with as much of their own as they have in common: a half.
        let other = |cycles: f64| {
            (0..400).map(move |n| (std::f64::consts::TAU * cycles * f64::from(n) / 400.0).sin())
        };
        let own = |cycles: f64| {
            wave(0.0)
                .iter()
                .zip(other(cycles))
                .map(|(a, b)| a + b)
                .collect::<Vec<f64>>()
        };
        assert!((pearson(&own(31.0), &own(57.0)) - 0.5).abs() < 1e-9);
    }
}
