//! Phase trajectory of the tone over the window: a steady part and Legendre polynomials.

use crate::legendre::legendre_after;
use crate::limits::MOVES_MAX;
use crate::phase::from_turns;
use core::f32::consts::{FRAC_1_PI, PI};

/// The phase of the unit line at `u`: pi x cycles x u + sum of moved[k] P_k(u), radians.
#[derive(Clone, Copy, Debug)]
pub struct Trajectory {
    /// Frequency of the linear term, cycles per window; polynomials of odd degree add to it.
    pub cycles: f32,
    /// Coefficients by degree, radians; 0 and 1 are unused.
    pub moved: [f32; MOVES_MAX + 1],
    /// Highest degree in use; 1 is steady.
    pub degrees: usize,
}

impl Trajectory {
    pub fn steady(cycles: f32) -> Self {
        Self {
            cycles,
            moved: [0.0; MOVES_MAX + 1],
            degrees: 1,
        }
    }

    /// Phase modulation at `u`, radians.
    pub fn movement(&self, u: f32) -> f32 {
        if self.degrees < 2 {
            return 0.0;
        }
        let (mut before, mut p, mut movement) = (1.0, u, 0.0);
        for (k, moved) in self.moved.iter().enumerate().take(self.degrees + 1).skip(2) {
            (before, p) = (p, legendre_after(k - 1, u, [before, p]));
            movement += moved * p;
        }
        movement
    }

    /// `scale` times the phase at `u`, as a 32-bit fraction of a turn.
    pub fn at(&self, u: f32, scale: f32) -> u32 {
        let turns = 0.5 * scale * self.cycles * u;
        let steady = from_turns(turns);
        if self.degrees < 2 {
            return steady;
        }
        steady.wrapping_add(from_turns(0.5 * FRAC_1_PI * scale * self.movement(u)))
    }

    /// Adds a step to the phase; `step` is by degree, from 1 on.
    pub fn step(&mut self, step: &[f32]) {
        for (k, x) in step.iter().enumerate() {
            if k == 0 {
                self.cycles += x / PI;
            } else if k < MOVES_MAX {
                self.moved[k + 1] += x;
            }
        }
        self.degrees = self.degrees.max(step.len().min(MOVES_MAX));
    }

    /// Trajectory of a unit line at `times` the frequency.
    pub fn times(&self, times: f32) -> Self {
        Self {
            cycles: times * self.cycles,
            moved: self.moved.map(|c| times * c),
            degrees: self.degrees,
        }
    }
}
