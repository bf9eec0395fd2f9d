//! Tangential over normal force, from what a hold does to the array.

/// M = F / N (equation 10) of an array of units with four piezoresistors each on a cross, by the
/// levels of a static image and their standard deviations: a NaN stands for a dead piezoresistor,
/// whose unit does not count. With its standard deviation; none without a unit or without normal
/// force.
///
/// A force along the surface stretches one of two opposite piezoresistors and compresses the other;
/// pressure does the same to all four. `gain` is what the unit's mechanics make of it: M by a force
/// sensor over M with a gain of 1.
pub fn force_ratio<const UNITS: usize>(
    levels: &[[f32; 4]; UNITS],
    sigmas: &[[f32; 4]; UNITS],
    gain: f32,
) -> Option<(f32, f32)> {
    let (mut along, mut across, mut normal, mut variance) = (0.0, 0.0, 0.0, 0.0);
    for (unit, sigma) in levels
        .iter()
        .zip(sigmas)
        .filter(|(unit, _)| unit.iter().all(|level| level.is_finite()))
    {
        along += unit[0] - unit[2];
        across += unit[1] - unit[3];
        normal += unit.iter().sum::<f32>();
        variance += sigma.iter().map(|sigma| sigma * sigma).sum::<f32>();
    }
    // Each pair has half of the variance of all four.
    let ratio = libm::sqrtf(along * along + across * across) / normal.abs();
    let sigma = libm::sqrtf(variance * (0.5 + ratio * ratio)) / normal.abs();
    ratio
        .is_finite()
        .then_some((gain * ratio, gain.abs() * sigma))
}
