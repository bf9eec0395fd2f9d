//! The finger's skin: smooth as Ridgetone's, or with ridges as the paper's sensor has them.

use super::paper::SKIN_RIDGE_MM;
use hal_mock::Finger;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Skin {
    Ridged,
    Smooth,
}

impl Skin {
    pub fn finger(self) -> Finger {
        let skin_ridge_mm = if self == Self::Ridged {
            SKIN_RIDGE_MM
        } else {
            0.0
        };
        Finger {
            skin_ridge_mm,
            ..Finger::default()
        }
    }

    /// Harmonics of a fit. A smooth skin leaves two. Under a ridged one a third harmonic with
    /// nearly the ridges' period is as strong as the fundamental: the firmware's default.
    pub fn harmonics(self) -> u8 {
        if self == Self::Ridged { 4 } else { 2 }
    }
}
