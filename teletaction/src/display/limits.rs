//! What a real display can do: force, stroke, updates, levels, slew.

use crate::display::error::{Error, finite, length, within};

/// Limits of a display whose pins are all alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Greatest force of a pin, newtons, 0.001 to 100.
    pub force_n: f32,
    /// Greatest way of a pin, millimetres, 0.001 to 100.
    pub stroke_mm: f32,
    /// What a finger opposes to a pin, newtons per millimetre, 0.001 to 1000: with it the stroke
    /// bounds the force.
    pub stiffness_n_mm: f32,
    /// Updates a second, 0.1 to 10,000; the paper's displays have 8 to 50.
    pub update_hz: f32,
    /// Levels between no force and the greatest one, 1 to 65,535; 1 is a pin that is up or down.
    pub levels: u16,
    /// Greatest change of a force, newtons per second, 0.001 to 1,000,000.
    pub slew_n_s: f32,
}

impl Limits {
    /// What an ideal display needs for a finger (paper, section 1): 50 N/cm^2, 4 mm and 50 Hz; here
    /// at pins 2 mm apart, in a hundred levels, over the whole range in 0.1 s. The stiffness of a
    /// pin's share of the finger is 0.5 N/mm: the finger's 3000 N/m at 2 N (section 3.1) over about
    /// six pins.
    pub const IDEAL: Self = Self {
        force_n: 2.0,
        stroke_mm: 4.0,
        stiffness_n_mm: 0.5,
        update_hz: 50.0,
        levels: 100,
        slew_n_s: 20.0,
    };

    /// Greatest force that both force and stroke allow, newtons.
    pub fn greatest_n(&self) -> f32 {
        self.force_n.min(self.stroke_mm * self.stiffness_n_mm)
    }

    fn check(&self) -> Result<(), Error> {
        let within =
            |name, value: f32, least, greatest| within(name, f64::from(value), least, greatest);
        within("force_n", self.force_n, 1e-3, 100.0)?;
        within("stroke_mm", self.stroke_mm, 1e-3, 100.0)?;
        within("stiffness_n_mm", self.stiffness_n_mm, 1e-3, 1e3)?;
        within("update_hz", self.update_hz, 0.1, 1e4)?;
        within("levels", f32::from(self.levels), 1.0, f64::from(u16::MAX))?;
        within("slew_n_s", self.slew_n_s, 1e-3, 1e6)?;
        // More steps than levels would be as many.
        if self.steps() == 0 {
            let quantum_n = self.quantum_n();
            return Err(Error::Frozen {
                quantum_n,
                step_n: self.slew_n_s / self.update_hz,
            });
        }
        Ok(())
    }

    /// Force of one level, newtons.
    fn quantum_n(&self) -> f32 {
        self.greatest_n() / f32::from(self.levels)
    }

    /// Whole levels by which an update may change a force.
    fn steps(&self) -> u16 {
        // A millionth more: a slew of just one level an update is meant to be possible.
        ((self.slew_n_s / self.update_hz / self.quantum_n() * 1.000_001) as u16).min(self.levels)
    }
}

/// How a force moves from update to update: in whole levels, and no more of them than the slew
/// allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    quantum_n: f32,
    steps: u16,
    levels: u16,
}

impl Steps {
    /// Steps within limits that [`Pins::new`] accepts.
    pub fn new(limits: &Limits) -> Self {
        Self {
            quantum_n: limits.quantum_n(),
            steps: limits.steps(),
            levels: limits.levels,
        }
    }

    /// Force of one level, newtons.
    pub const fn quantum_n(&self) -> f32 {
        self.quantum_n
    }

    /// Level after an update, from a level towards a wanted force, newtons. What is no number is no
    /// force.
    pub fn towards(&self, from: u16, wanted_n: f32) -> u16 {
        // To the nearest level; beyond the numbers to the next one, and NaN to 0.
        let wanted = (wanted_n / self.quantum_n + 0.5) as u16;
        let from = from.min(self.levels);
        let (least, most) = (
            from.saturating_sub(self.steps),
            from.saturating_add(self.steps).min(self.levels),
        );
        wanted.max(least).min(most)
    }
}

/// The pins of a display, within its limits whatever is wanted; the memory is the caller's.
///
/// After every call each force is a whole number of levels from none to the greatest, and no more
/// than the slew away from the last.
#[derive(Debug)]
pub struct Pins<'a> {
    limits: Limits,
    steps: Steps,
    forces_n: &'a mut [f32],
    /// Seconds since the last update.
    since_s: f32,
}

impl<'a> Pins<'a> {
    /// Pins that do not press. `forces_n` has a value for each pin.
    pub fn new(limits: Limits, forces_n: &'a mut [f32]) -> Result<Self, Error> {
        limits.check()?;
        forces_n.fill(0.0);
        Ok(Self {
            limits,
            steps: Steps::new(&limits),
            forces_n,
            since_s: f32::INFINITY,
        })
    }

    /// The limits.
    pub const fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Forces of the pins, newtons.
    pub fn forces_n(&self) -> &[f32] {
        self.forces_n
    }

    /// Lets `dt_s` seconds pass, 0 to 1000, then moves towards the wanted forces if an update is
    /// due. Gives the number of pins whose wanted force was beyond the limits; none if no update
    /// was due. On an error the pins stay as they are.
    pub fn advance(&mut self, dt_s: f32, wanted_n: &[f32]) -> Result<Option<usize>, Error> {
        length("wanted forces", wanted_n.len(), self.forces_n.len())?;
        finite("wanted force", wanted_n)?;
        if !self.is_due(dt_s)? {
            return Ok(None);
        }
        let greatest_n = self.limits.greatest_n();
        let steps = self.steps;
        self.forces_n
            .iter_mut()
            .zip(wanted_n)
            .for_each(|(n, wanted)| *n = moved(*n, *wanted, &steps));
        Ok(Some(
            wanted_n
                .iter()
                .filter(|wanted| !(0.0..=greatest_n).contains(*wanted))
                .count(),
        ))
    }

    /// Releases all pins, for a silent line or wrong data. They go down as fast as the slew allows.
    pub fn release(&mut self, dt_s: f32) -> Result<(), Error> {
        if self.is_due(dt_s)? {
            let steps = self.steps;
            self.forces_n
                .iter_mut()
                .for_each(|n| *n = moved(*n, 0.0, &steps));
        }
        Ok(())
    }

    fn is_due(&mut self, dt_s: f32) -> Result<bool, Error> {
        within("dt_s", f64::from(dt_s), 0.0, 1e3)?;
        self.since_s += dt_s;
        // A thousandth less: steps of time that add up to an update are an update.
        let is_due = self.since_s >= 0.999 / self.limits.update_hz;
        if is_due {
            self.since_s = 0.0;
        }
        Ok(is_due)
    }
}

/// Force after an update, from a force towards a wanted one, newtons.
fn moved(from_n: f32, wanted_n: f32, steps: &Steps) -> f32 {
    steps.quantum_n * f32::from(steps.towards((from_n / steps.quantum_n).round() as u16, wanted_n))
}
