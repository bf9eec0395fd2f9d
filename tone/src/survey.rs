//! The candidates for a window of few cycles, at one frequency after the other: a baseline, with a tone or without.

use crate::descent::{CYCLES_FOR_SLOPE, CYCLES_MIN};
use crate::equations::Shape;
use crate::levels::Levels;
use crate::limits::{CURVE_FUNCTIONS, HARMONICS_MAX};
use crate::model::Model;
use crate::nuisance::{Curve, Nuisances};
use crate::source::Overwritten;
use crate::spectrum::TransformMemory;
use crate::window::{Window, Work};

/// Rates of a baseline that relaxes, per half window: the first, and the factor from one to the next.
const RATE_FIRST: f32 = 1.5;
const RATE_FACTOR: f32 = 3.0;
const RATES: usize = 2;
/// Cycles below which all frequencies are surveyed, whatever the periodogram's peak is.
const CYCLES_SURVEYED: f32 = 2.6;
/// From one frequency to the next, cycles per half window.
const NU_STEP: f32 = 0.1;

/// Kinds of baselines: level, slope, bend, relaxation.
const KINDS: usize = 4;

/// The likeliest models.
#[derive(Default)]
pub struct Survey {
    /// Of each kind of baseline without a tone.
    pub without: [Option<Model>; KINDS],
    /// Of each kind with one.
    pub tones: [[Option<Model>; HARMONICS_MAX]; KINDS],
}

impl Survey {
    #[inline(never)]
    fn add(&mut self, levels: &Levels, model: &Model) {
        let kind = match model.curve {
            Curve::None => model.shape.slope as usize,
            Curve::Bent => 2,
            Curve::Relaxing(_) => 3,
        };
        let place = match model.shape.harmonics.checked_sub(1) {
            None => self.without.get_mut(kind),
            Some(more) => self.tones.get_mut(kind).and_then(|tones| tones.get_mut(more)),
        };
        if let Some(place) = place {
            Model::replace_if_better(place, levels, model);
        }
    }

    /// Adds the models without a rate at a maximum of one model's likelihood.
    #[inline(never)]
    pub fn add_at_maximum(&mut self, window: &mut Window, nu: f32) -> Result<(), Overwritten> {
        let bent = window.nuisances(Curve::Bent)?;
        self.add_all_at(window, core::slice::from_ref(&bent), nu)
    }

    /// Adds all models of few cycles, and those at `line`.
    // Not inlined, as the next: their nuisances leave the stack when they are done.
    #[inline(never)]
    pub fn add_few_cycles(&mut self, window: &mut Window, line: f32) -> Result<(), Overwritten> {
        let (mut nuisances, mut rate) = (<[Nuisances; 1 + RATES]>::default(), RATE_FIRST);
        nuisances[0] = window.nuisances(Curve::Bent)?;
        for nuisances in &mut nuisances[1..] {
            *nuisances = window.nuisances(Curve::Relaxing(rate))?;
            rate *= RATE_FACTOR;
        }
        let mut nu = 0.5 * CYCLES_MIN;
        while 2.0 * nu < CYCLES_SURVEYED {
            self.add_all_at(window, &nuisances, nu)?;
            nu += NU_STEP;
        }
        if line > nu {
            self.add_all_at(window, &nuisances, line)?;
        }
        Ok(())
    }

    /// Adds all models at the strongest line on a drift like `curve`.
    #[inline(never)]
    pub fn add_on_drift(
        &mut self,
        window: &mut Window,
        mut memory: TransformMemory,
        curve: Curve,
    ) -> Result<(), Overwritten> {
        let mut nuisances = <[Nuisances; 2]>::default();
        for (nuisances, curve) in nuisances.iter_mut().zip([Curve::Bent, curve]) {
            *nuisances = window.nuisances(curve)?;
        }
        let [bent, drift] = &nuisances;
        let peak = memory.strongest(&mut window.span, window.levels, drift, CYCLES_FOR_SLOPE)?;
        let likely = if matches!(curve, Curve::Relaxing(_)) { &nuisances[..] } else { core::slice::from_ref(bent) };
        match peak.filter(|peak| 2.0 * peak >= CYCLES_FOR_SLOPE) {
            Some(peak) => self.add_all_at(window, likely, peak),
            None => Ok(()),
        }
    }

    /// Adds all models at `nu`.
    fn add_all_at(&mut self, window: &mut Window, nuisances: &[Nuisances], nu: f32) -> Result<(), Overwritten> {
        let harmonics = window.harmonics(nu);
        let Window { span, levels, work: Work { sums, solution }, .. } = window;
        for (k, nuisances) in nuisances.iter().enumerate() {
            match k {
                0 => sums.collect(span, levels, nuisances, nu, harmonics)?,
                _ => sums.exchange(span, levels, nuisances, nu, harmonics)?,
            }
            let straight = nuisances.count() - CURVE_FUNCTIONS;
            let shapes: &[_] = match nuisances.curve {
                Curve::Relaxing(_) => &[(true, 1)],
                _ => &[(false, 0), (true, 0), (true, CURVE_FUNCTIONS)],
            };
            for (slope, functions) in shapes {
                let shape = Shape { harmonics, slope: *slope, nuisances: straight + functions };
                let curve = if *functions > 0 { nuisances.curve } else { Curve::None };
                solution.residual_sums(sums, levels, nuisances, &shape, &mut |harmonics, residual_sum_of_squares| {
                    let nu = if harmonics > 0 { nu } else { 0.0 };
                    let (shape, residual_sum_of_squares) = (Shape { harmonics, ..shape }, *residual_sum_of_squares);
                    self.add(levels, &Model { nu, curve, shape, residual_sum_of_squares, refined: false });
                });
            }
        }
        Ok(())
    }
}
