//! The thresholds of the receptors, for the plots of the event `feel`.

use super::coefficients::NAMES;
use ridgetone_feel::{RECEPTORS, Receptor};
use serde::Serialize;

/// A threshold, to the scale of the event's spectrum. In decibels over the logarithm of the
/// frequency it is straight between its ends.
#[derive(Clone, Debug, Serialize)]
pub struct Threshold {
    /// As in JSON.
    pub receptor: &'static str,
    /// As in the literature.
    pub name: &'static str,
    /// Hertz, rising.
    pub hz: [f32; 4],
    /// Decibels over one micrometre from peak to peak.
    pub level_db: [f32; 4],
}

/// The thresholds of all receptors (equations 1 to 4 of the paper).
pub fn thresholds() -> [Threshold; RECEPTORS] {
    Receptor::ALL.map(|receptor| {
        let ends: [(f32, f32); 4] = {
            let [[a, b], [c, d]] = receptor.threshold_ends();
            [a, b, c, d]
        };
        Threshold {
            receptor: NAMES[receptor as usize],
            name: receptor.name(),
            hz: ends.map(|(hz, _)| hz),
            level_db: ends.map(|(_, um)| 20.0 * um.log10()),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levels at the corners of Table 1 by the plain powers of equations 1 to 4.
    #[test]
    fn thresholds_have_the_levels_of_the_paper_s_equations() {
        let [fa1, fa2, sa1, sa2] = thresholds();
        let expected = |um: f64| 20.0 * um.log10();
        for (found, hz, um) in [
            (fa1.level_db[0], 0.5f64, 499.0 * 0.5f64.powf(-0.89)),
            (fa2.level_db[1], 241.0, 1690.0 * 241f64.powf(-1.93)),
            (sa1.level_db[2], 26.2, 0.787 * 26.2f64.powf(0.683)),
            (sa2.level_db[3], 400.0, 17.1 * 400f64.powf(-0.034)),
        ] {
            assert!(
                (f64::from(found) - expected(um)).abs() < 0.01,
                "at {hz} Hz: {found} and {}",
                expected(um)
            );
        }
        assert_eq!(
            (fa2.receptor, fa2.name, fa2.hz),
            ("fa2", "FA II", [20.0, 241.0, 241.0, 800.0])
        );
    }
}
