//! Skin as a Kelvin body: what a finger keeps of an earlier touch.
//!
//! Equations 5 to 8 and 15, 16 of Moy et al. Equation 8 repeats equation 7 where it should have the
//! creep function; the creep here is what equation 5 gives.

use crate::display::error::{Error, within};

/// The finger pads of the paper's six subjects (Table 5, columns 4 and 5). Subject 3's third column
/// contradicts the fourth, which Table 6 bears out.
pub const SUBJECTS: [Kelvin; 6] = [
    Kelvin {
        relaxation_s: 1.42,
        creep_s: 2.14,
    },
    Kelvin {
        relaxation_s: 3.90,
        creep_s: 6.11,
    },
    Kelvin {
        relaxation_s: 2.71,
        creep_s: 3.82,
    },
    Kelvin {
        relaxation_s: 2.81,
        creep_s: 3.65,
    },
    Kelvin {
        relaxation_s: 3.38,
        creep_s: 4.78,
    },
    Kelvin {
        relaxation_s: 3.88,
        creep_s: 4.39,
    },
];

/// A viscoelastic solid with one spring beside a spring and a damper in series (figure 3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kelvin {
    relaxation_s: f64,
    creep_s: f64,
}

impl Kelvin {
    /// With the relaxation times for constant strain and for constant stress, seconds: 0.001 to
    /// 1000, the first not above the second.
    pub fn new(relaxation_s: f64, creep_s: f64) -> Result<Self, Error> {
        within("creep_s", creep_s, 1e-3, 1e3)?;
        within("relaxation_s", relaxation_s, 1e-3, creep_s)?;
        Ok(Self {
            relaxation_s,
            creep_s,
        })
    }

    /// Relaxation time for constant strain, seconds.
    pub const fn relaxation_s(&self) -> f64 {
        self.relaxation_s
    }

    /// Relaxation time for constant stress, seconds.
    pub const fn creep_s(&self) -> f64 {
        self.creep_s
    }

    /// Force `t_s` >= 0 after a unit step of deformation, over the relaxed modulus (equation 7): 1
    /// in the end.
    pub fn relaxation(&self, t_s: f64) -> f64 {
        1.0 + (self.creep_s / self.relaxation_s - 1.0) * (-t_s / self.relaxation_s).exp()
    }

    /// Deformation `t_s` >= 0 after a unit step of force, times the relaxed modulus: 1 in the end.
    pub fn creep(&self, t_s: f64) -> f64 {
        1.0 - (1.0 - self.relaxation_s / self.creep_s) * (-t_s / self.creep_s).exp()
    }

    /// Deformation `off_s` after a force of `on_s` seconds, over that at its end, by superposition.
    pub fn retained(&self, on_s: f64, off_s: f64) -> f64 {
        (self.creep(on_s + off_s) - self.creep(off_s)) / self.creep(on_s)
    }

    /// Retained deformation as in the paper's Table 6: all of it fades with the time constant of
    /// creep.
    pub fn retained_by_creep_time(&self, off_s: f64) -> f64 {
        (-off_s / self.creep_s).exp()
    }
}
