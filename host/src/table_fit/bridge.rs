//! Bridges single missing readings, because the fit needs frames with all channels.

/// Number of known readings on each side that define the cubic, and their maximum distance, frames.
const SIDE: usize = 2;
const REACH: usize = 5;
/// Maximum number of consecutive missing readings to bridge. With more, the noise would be many
/// times that of a real reading.
const RUN_MAX: f64 = 3.0;
/// Maximum fraction of missing readings in a channel that is bridged.
const MISSING_FRACTION_MAX: f64 = 0.5;
/// Maximum frequency of a tone that a cubic follows, cycles per frame. At this frequency the error
/// is 6 % of the amplitude; at twice this frequency it is two thirds.
pub const TONE_MAX: f64 = 1.0 / 8.0;

/// Interpolates missing readings of a channel with the cubic through the two known readings on each
/// side, and returns frames and values. Gaps without known readings nearby are not filled. `known`
/// has the value of each frame, if there is one.
///
/// The noise variance of an interpolated value, relative to a real reading, is 0.94 for a single
/// missing reading and 1.4 for two. Interpolated values add no information on the tone.
pub fn bridged(known: &[Option<f64>]) -> Vec<(usize, f64)> {
    let missing = known.iter().filter(|value| value.is_none()).count();
    if missing as f64 > MISSING_FRACTION_MAX * known.len() as f64 {
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

    /// The cubic through the neighbours at 1 and 2 frames responds to a tone of w radians per frame
    /// with (8 cos w - 2 cos 2 w) / 6.
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
