//! Single readings that are missing: the fit needs frames that have every channel.

/// Known readings on each side that a cubic goes through, and how many frames away they may be.
const SIDE: usize = 2;
const REACH: usize = 8;
/// A channel with a larger share of missing readings is left as it is.
const SHARE_MAX: f64 = 0.5;

/// The readings of a channel that are missing, at their places, by the cubic through the two known ones on each side; some are not
/// close enough. `known` has the value of each frame, where there is one.
///
/// Such a reading has about the noise of a real one (0.94 of its variance where one is missing alone), but says nothing new.
pub fn bridged(known: &[Option<f64>]) -> Vec<(usize, f64)> {
    let missing = known.iter().filter(|value| value.is_none()).count();
    if missing as f64 > SHARE_MAX * known.len() as f64 {
        return Vec::new();
    }
    let at = |frame: usize| known.get(frame).copied().flatten().map(|value| (frame as f64, value));
    let mut bridged = Vec::new();
    for (frame, _) in known.iter().enumerate().filter(|(_, value)| value.is_none()) {
        let before = (1..=REACH.min(frame)).filter_map(|back| at(frame - back)).take(SIDE);
        let after = (1..=REACH).filter_map(|ahead| at(frame + ahead)).take(SIDE);
        let beside: Vec<(f64, f64)> = before.chain(after).collect();
        if beside.len() == 2 * SIDE {
            bridged.push((frame, lagrange(&beside, frame as f64)));
        }
    }
    bridged
}

/// The value at `x` of the polynomial through all points.
fn lagrange(points: &[(f64, f64)], x: f64) -> f64 {
    let weight = |of: f64| -> f64 {
        points.iter().filter(|(other, _)| *other != of).map(|(other, _)| (x - other) / (of - other)).product()
    };
    points.iter().map(|(at, value)| value * weight(*at)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_bridged_exactly_and_gaps_at_the_ends_are_left() {
        let cubic = |n: usize| 3.0 - 2.0 * n as f64 + 0.5 * (n * n) as f64 - 0.01 * (n * n * n) as f64;
        let known: Vec<Option<f64>> =
            (0..40).map(|n| (![1, 7, 8, 20, 21, 22, 39].contains(&n)).then(|| cubic(n))).collect();
        let found = bridged(&known);
        assert_eq!(found.iter().map(|(n, _)| *n).collect::<Vec<_>>(), [7, 8, 20, 21, 22]);
        assert!(found.iter().all(|(n, value)| (value - cubic(*n)).abs() < 1e-9), "{found:?}");
        assert!(
            bridged(&known.iter().map(|value| value.filter(|value| *value < -40.0)).collect::<Vec<_>>()).is_empty()
        );
        // A gap that is longer than the reach.
        let gap: Vec<Option<f64>> = (0..60).map(|n| (!(20..38).contains(&n)).then(|| cubic(n))).collect();
        assert!(bridged(&gap).iter().all(|(n, _)| *n < 28 || *n > 29), "{:?}", bridged(&gap));
    }
}
