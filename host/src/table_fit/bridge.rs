//! Single readings that are missing: the fit needs frames that have every channel.

/// Known readings on each side that a cubic goes through, and how many frames away they may be.
const SIDE: usize = 2;
const REACH: usize = 5;
/// Maximum number of readings in a row that are bridged: of more the noise would be many times that
/// of a real one.
const RUN_MAX: f64 = 3.0;
/// A channel with a larger fraction of missing readings is left as it is.
const SHARE_MAX: f64 = 0.5;
/// Cycles a frame up to which a cubic follows a tone: it is off by 6 % of the amplitude there, and
/// by two thirds of it at twice that.
pub const TONE_MAX: f64 = 1.0 / 8.0;

/// The readings of a channel that are missing, at their frames, by the cubic through the two known
/// ones on each side; some are not close enough. `known` has the value of each frame, where there
/// is one.
///
/// Where one is missing alone its value has 0.94 of the noise variance of a real one, where two are
/// missing 1.4 of it. It says nothing new of the tone.
pub fn bridged(known: &[Option<f64>]) -> Vec<(usize, f64)> {
    let missing = known.iter().filter(|value| value.is_none()).count();
    if missing as f64 > SHARE_MAX * known.len() as f64 {
        return Vec::new();
    }
    let at = |frame: usize| {
        known
            .get(frame)
            .copied()
            .flatten()
            .map(|value| (frame as f64, value))
    };
    let mut bridged = Vec::new();
    for (frame, _) in known
        .iter()
        .enumerate()
        .filter(|(_, value)| value.is_none())
    {
        let before = (1..=REACH.min(frame))
            .filter_map(|back| at(frame - back))
            .take(SIDE);
        let after = (1..=REACH).filter_map(|ahead| at(frame + ahead)).take(SIDE);
        let beside: Vec<(f64, f64)> = before.chain(after).collect();
        let is_short = beside.len() == 2 * SIDE && beside[SIDE].0 - beside[0].0 <= RUN_MAX + 1.0;
        if is_short {
            bridged.push((frame, lagrange(&beside, frame as f64)));
        }
    }
    bridged
}

/// The value at `x` of the polynomial through all points.
fn lagrange(points: &[(f64, f64)], x: f64) -> f64 {
    let weight = |of: f64| -> f64 {
        points
            .iter()
            .filter(|(other, _)| *other != of)
            .map(|(other, _)| (x - other) / (of - other))
            .product()
    };
    points.iter().map(|(at, value)| value * weight(*at)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_bridged_exactly_and_gaps_at_the_ends_are_left() {
        let cubic =
            |n: usize| 3.0 - 2.0 * n as f64 + 0.5 * (n * n) as f64 - 0.01 * (n * n * n) as f64;
        let known: Vec<Option<f64>> = (0..40)
            .map(|n| (![1, 7, 8, 20, 21, 22, 30, 31, 32, 33, 39].contains(&n)).then(|| cubic(n)))
            .collect();
        let found = bridged(&known);
        assert_eq!(
            found.iter().map(|(n, _)| *n).collect::<Vec<_>>(),
            [7, 8, 20, 21, 22]
        );
        assert!(
            found
                .iter()
                .all(|(n, value)| (value - cubic(*n)).abs() < 1e-9),
            "{found:?}"
        );
        assert!(
            bridged(
                &known
                    .iter()
                    .map(|value| value.filter(|value| *value < -40.0))
                    .collect::<Vec<_>>()
            )
            .is_empty()
        );
    }

    /// The cubic through the neighbours at 1 and 2 frames has the response (8 cos w - 2 cos 2 w) /
    /// 6 to a tone of w radians a frame.
    #[test]
    fn a_tone_is_bridged_with_the_cubics_own_response() {
        for cycles in [0.02, 0.05, TONE_MAX, 0.25] {
            let w = std::f64::consts::TAU * cycles;
            let known: Vec<Option<f64>> = (0..9)
                .map(|n| (n != 4).then(|| (w * (n as f64 - 4.0)).cos()))
                .collect();
            let expected = (8.0 * w.cos() - 2.0 * (2.0 * w).cos()) / 6.0;
            assert!((bridged(&known)[0].1 - expected).abs() < 1e-12, "{cycles}");
            assert!(
                cycles > TONE_MAX || 1.0 - expected < 0.06,
                "{cycles}: {expected}"
            );
        }
    }
}
