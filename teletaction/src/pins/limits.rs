//! Limits of a real display: force, stroke, updates, levels, slew.

use super::Error;
use crate::stimulus::within;

/// Limits of a display of identical pins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Maximum force of a pin, newtons, 0.001 to 100.
    pub force_n: f32,
    /// Maximum travel of a pin, millimetres, 0.001 to 100.
    pub stroke_mm: f32,
    /// Stiffness of the finger under a pin, newtons per millimetre, 0.001 to 1000; together with
    /// the stroke it limits the force.
    pub stiffness_n_mm: f32,
    /// Updates per second, 0.1 to 10,000; 8 to 50 in the paper's displays.
    pub update_hz: f32,
    /// Levels between no force and the maximum, 1 to 65,535; 1 is a pin that is up or down.
    pub levels: u16,
    /// Maximum change of a force, newtons per second, 0.001 to 1,000,000.
    pub slew_n_s: f32,
}

impl Limits {
    /// Limits of an ideal display for a finger (paper, section 1): 50 N/cm^2, 4 mm and 50 Hz; here
    /// with pins 2 mm apart, a hundred levels, and the whole range in 0.1 s. The finger's stiffness
    /// per pin is 0.5 N/mm: 3000 N/m at 2 N (section 3.1) over about six pins.
    pub const IDEAL: Self = Self {
        force_n: 2.0,
        stroke_mm: 4.0,
        stiffness_n_mm: 0.5,
        update_hz: 50.0,
        levels: 100,
        slew_n_s: 20.0,
    };

    /// Maximum force that the force and stroke limits allow, newtons.
    pub fn max_n(&self) -> f32 {
        self.force_n.min(self.stroke_mm * self.stiffness_n_mm)
    }

    fn check(&self) -> Result<(), Error> {
        within("force_n", self.force_n, 1e-3, 100.0)?;
        within("stroke_mm", self.stroke_mm, 1e-3, 100.0)?;
        within("stiffness_n_mm", self.stiffness_n_mm, 1e-3, 1e3)?;
        within("update_hz", self.update_hz, 0.1, 1e4)?;
        within("levels", f32::from(self.levels), 1.0, f32::from(u16::MAX))?;
        within("slew_n_s", self.slew_n_s, 1e-3, 1e6)?;
        if self.steps() == 0 {
            return Err(Error::Frozen {
                level_n: self.level_n(),
                step_n: self.slew_n_s / self.update_hz,
            });
        }
        Ok(())
    }

    pub fn level_n(&self) -> f32 {
        self.max_n() / f32::from(self.levels)
    }

    /// Maximum change of a force in an update, in whole levels.
    fn steps(&self) -> u16 {
        // Add a millionth, to allow a slew of exactly one level per update.
        ((self.slew_n_s / self.update_hz / self.level_n() * 1.000_001) as u16).min(self.levels)
    }
}

/// Pins of a display, kept within its limits for any target.
///
/// After every call each force is a whole number of levels from 0 to the maximum, and within the
/// slew limit of the previous force.
#[derive(Clone, Debug)]
pub struct Pins {
    limits: Limits,
    forces_n: Vec<f32>,
    since_s: f32,
}

impl Pins {
    /// Creates `count` pins that do not press.
    pub fn new(limits: Limits, count: usize) -> Result<Self, Error> {
        limits.check()?;
        Ok(Self {
            limits,
            forces_n: vec![0.0; count],
            since_s: f32::INFINITY,
        })
    }

    pub fn forces_n(&self) -> &[f32] {
        &self.forces_n
    }

    /// Advances time by `dt_s` seconds, 0 to 1000, and moves towards the target forces if an update
    /// is due. Returns the number of pins whose target exceeds the limits, or `None` if no update
    /// was due. On an error the pins do not move.
    pub fn advance(&mut self, dt_s: f32, target_n: &[f64]) -> Result<Option<usize>, Error> {
        assert_eq!(target_n.len(), self.forces_n.len());
        if let Some(index) = target_n.iter().position(|n| !n.is_finite()) {
            return Err(Error::NotFinite {
                what: "wanted force",
                index,
            });
        }
        if !self.is_due(dt_s)? {
            return Ok(None);
        }
        let limits = self.limits;
        for (n, target) in self.forces_n.iter_mut().zip(target_n) {
            *n = moved(&limits, *n, *target as f32);
        }
        let allowed = 0.0..=f64::from(limits.max_n());
        Ok(Some(
            target_n.iter().filter(|n| !allowed.contains(*n)).count(),
        ))
    }

    /// Releases all pins, as for a silent line, as fast as the slew allows.
    pub fn release(&mut self, dt_s: f32) -> Result<(), Error> {
        if self.is_due(dt_s)? {
            let limits = self.limits;
            self.forces_n
                .iter_mut()
                .for_each(|n| *n = moved(&limits, *n, 0.0));
        }
        Ok(())
    }

    fn is_due(&mut self, dt_s: f32) -> Result<bool, Error> {
        within("dt_s", dt_s, 0.0, 1e3)?;
        self.since_s += dt_s;
        // Allow a thousandth less, so that time steps that add up to an update period trigger the
        // update despite rounding.
        let is_due = self.since_s >= 0.999 / self.limits.update_hz;
        if is_due {
            self.since_s = 0.0;
        }
        Ok(is_due)
    }
}

/// Returns the force after an update towards a target, newtons: in whole levels, within the slew
/// limit.
fn moved(limits: &Limits, from_n: f32, target_n: f32) -> f32 {
    let (level_n, steps) = (limits.level_n(), limits.steps());
    let from = (from_n / level_n).round() as u16;
    // Round to the nearest level; `as` saturates out of range.
    let target = (target_n / level_n + 0.5) as u16;
    let max = from.saturating_add(steps).min(limits.levels);
    level_n * f32::from(target.max(from.saturating_sub(steps)).min(max))
}
