//! What a display must be able to do, so that nobody feels its steps: the paper's rule for any
//! spacing, layer and resolution.

use super::grating::{CELL_MM, Pressure, pins_with_errors};
use crate::display::half_plane::normal_wave;
use anyhow::Result;
use ridgetone_host::usage::UsageError;
use serde::Serialize;

/// Modulation indices between which people just notice a grating (Moy et al., section 5).
pub const NOTICEABLE: (f64, f64) = (0.10, 0.15);

/// Fewest pins a millimetre, and least spacing over the layer that is too coarse (section 5).
const SAMPLES_PER_MM_MIN: f64 = 0.5;
const SPACING_OVER_DEPTH_MOST: f64 = 2.0;

/// Longest error of a display that a finger can have under it, millimetres: the finger pad (section
/// 5: 0.1 cycles a millimetre).
const PAD_MM: f64 = 10.0;

/// Whether people notice a ripple.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Perception {
    NotNoticed,
    JustNoticed,
    Noticed,
}

impl Perception {
    fn of(index: f64) -> Self {
        match index {
            index if index < NOTICEABLE.0 => Self::NotNoticed,
            index if index <= NOTICEABLE.1 => Self::JustNoticed,
            _ => Self::Noticed,
        }
    }
}

/// A display and what a finger would feel of its errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Design {
    pub spacing_mm: f64,
    pub depth_mm: f64,
    pub resolution_percent: f64,
    /// Pins a millimetre.
    pub samples_per_mm: f64,
    /// Whether the pins are dense enough by the paper's rule: at least 0.5 a millimetre, and a
    /// spacing below two layers (section 5).
    pub is_dense: bool,
    /// Index of an error from pin to pin, whose period is two spacings.
    pub index: f64,
    pub verdict: Perception,
    /// Period of the worst error that fits under a finger pad, millimetres, and its index.
    pub worst_period_mm: f64,
    pub worst_index: f64,
    pub worst_verdict: Perception,
    /// Index of the pins themselves, if all are at one height.
    pub pins_index: f64,
    /// Coarsest resolution whose worst error is not noticed, percent.
    pub resolution_max_percent: f64,
}

impl Design {
    /// `spacing_mm`: 0.4 to 10, in steps of 0.1. `depth_mm`, the layer between pins and finger: 0.1
    /// to 20. `resolution_percent` of the pins' mean height: above 0, to 50.
    pub fn new(spacing_mm: f64, depth_mm: f64, resolution_percent: f64) -> Result<Self> {
        let bounds = [
            ("--spacing-mm", spacing_mm, 0.4, 10.0),
            ("--depth-mm", depth_mm, 0.1, 20.0),
            ("--resolution", resolution_percent, 0.01, 50.0),
        ];
        for (name, value, least, most) in bounds {
            if !(value >= least && value <= most) {
                return Err(UsageError(format!(
                    "{name} {value}: choose a value from {least} to {most}"
                ))
                .into());
            }
        }
        // An even number of cells, so that a pin is half of its spacing.
        let step_mm = 2.0 * CELL_MM;
        if (spacing_mm / step_mm - (spacing_mm / step_mm).round()).abs() > 1e-6 {
            return Err(UsageError(format!(
                "--spacing-mm {spacing_mm}: choose a multiple of {step_mm:.1}"
            ))
            .into());
        }
        let error = 0.01 * resolution_percent;
        let stress = |k: f64| normal_wave(k, depth_mm).z;
        let index = |pins: usize| {
            Pressure::under(&pins_with_errors(spacing_mm, pins, error)).index(1, stress)
        };
        let first = index(2);
        let pins_max = (PAD_MM / spacing_mm + 1e-9) as usize;
        let (worst, worst_index) =
            (3..=pins_max)
                .map(|pins| (pins, index(pins)))
                .fold(
                    (2, first),
                    |worst, this| if this.1 > worst.1 { this } else { worst },
                );
        Ok(Self {
            spacing_mm,
            depth_mm,
            resolution_percent,
            samples_per_mm: 1.0 / spacing_mm,
            is_dense: 1.0 / spacing_mm >= SAMPLES_PER_MM_MIN
                && spacing_mm / depth_mm < SPACING_OVER_DEPTH_MOST,
            index: first,
            verdict: Perception::of(first),
            worst_period_mm: worst as f64 * spacing_mm,
            worst_index,
            worst_verdict: Perception::of(worst_index),
            pins_index: Pressure::under(&pins_with_errors(spacing_mm, 1, 0.0)).index(1, stress),
            // Pressure is linear in height, as long as every pin presses.
            resolution_max_percent: resolution_percent * NOTICEABLE.0 / worst_index,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Section 5: 2 mm, 2 mm and 10 % stay below an index of 0.1.
    #[test]
    fn the_papers_display_is_not_noticed() {
        let design = Design::new(2.0, 2.0, 10.0).expect("a design");
        assert!(
            (design.index - 0.06).abs() < 0.01 && design.worst_index < 0.1,
            "{design:?}"
        );
        assert_eq!(
            (design.verdict, design.worst_verdict),
            (Perception::NotNoticed, Perception::NotNoticed)
        );
        assert!(
            design.resolution_max_percent > 10.0 && design.resolution_max_percent < 15.0,
            "{design:?}"
        );
        // What is found to be just not noticed is so.
        let limit = Design::new(2.0, 2.0, design.resolution_max_percent).expect("a design");
        assert!((limit.worst_index - 0.1).abs() < 1e-3, "{limit:?}");
    }

    #[test]
    fn coarser_pins_and_thinner_layers_are_felt_more() {
        let index = |spacing_mm, depth_mm, resolution| {
            Design::new(spacing_mm, depth_mm, resolution).expect("a design")
        };
        let paper = index(2.0, 2.0, 10.0);
        assert!(
            index(3.0, 2.0, 10.0).index > paper.index && index(2.0, 1.0, 10.0).index > paper.index
        );
        assert!(index(2.0, 1.0, 10.0).pins_index > paper.pins_index);
        assert_eq!(index(2.0, 2.0, 40.0).worst_verdict, Perception::Noticed);
        // 0.5 pins a millimetre and a spacing below two layers.
        let is_dense = |spacing_mm, depth_mm| index(spacing_mm, depth_mm, 10.0).is_dense;
        assert!(is_dense(2.0, 2.0) && is_dense(1.8, 1.0));
        assert!(!is_dense(2.1, 2.0) && !is_dense(2.0, 1.0));
    }

    #[test]
    fn designs_that_make_no_sense_are_refused() {
        for (spacing_mm, depth_mm, resolution) in [
            (0.0, 2.0, 10.0),
            (2.03, 2.0, 10.0),
            (2.0, f64::NAN, 10.0),
            (2.0, 2.0, 0.0),
            (2.0, 2.0, 90.0),
        ] {
            assert!(
                Design::new(spacing_mm, depth_mm, resolution)
                    .expect_err("refused")
                    .is::<UsageError>()
            );
        }
    }
}
