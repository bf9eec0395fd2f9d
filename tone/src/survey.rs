//! All that a window of few cycles may hold, at one frequency after the other: a baseline, with a tone or without.

use crate::descent::{CYCLES_FOR_SLOPE, CYCLES_MIN, Work};
use crate::frame_span::FrameSpan;
use crate::fundamental::harmonics_below_nyquist;
use crate::levels::Levels;
use crate::model::Model;
use crate::moments::HARMONICS_MAX;
use crate::nuisance::{CURVE, Curve, Nuisances};
use crate::search::Place;
use crate::solve::Shape;
use crate::spectrum::strongest;

/// Rates of a baseline that relaxes, per half window: time constants of a half of the window, and less by
/// the factor from one to the next.
const RATE_FIRST: f32 = 1.5;
const RATE_FACTOR: f32 = 3.0;
const RATES: usize = 2;
/// Cycles up to which a periodogram's peak is not to be relied on at all.
const FEW: f32 = 2.6;
/// From one frequency to the next, cycles per half window.
const NEXT: f32 = 0.1;

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
        // There always is one.
        if let Some(place) = place {
            Model::keep(place, levels, model);
        }
    }

    /// All models without a rate at a summit.
    #[inline(never)]
    pub fn look_at_summit(
        &mut self,
        span: &mut FrameSpan,
        levels: &Levels,
        work: &mut Work,
        most: usize,
        nu: f32,
    ) -> Option<()> {
        let bent = Nuisances::new(span, levels, Curve::Bent)?;
        self.look_at(span, levels, work, core::slice::from_ref(&bent), nu, most)
    }

    /// All models of few cycles.
    // This and what follows are apart, so that their nuisances are off the stack when they are done.
    #[inline(never)]
    pub fn look_around(
        &mut self,
        span: &mut FrameSpan,
        levels: &Levels,
        work: &mut Work,
        most: usize,
        line: f32,
    ) -> Option<()> {
        let (mut nuisances, mut rate) = (<[Nuisances; 1 + RATES]>::default(), RATE_FIRST);
        nuisances[0] = Nuisances::new(span, levels, Curve::Bent)?;
        for nuisances in &mut nuisances[1..] {
            *nuisances = Nuisances::new(span, levels, Curve::Relaxing(rate))?;
            rate *= RATE_FACTOR;
        }
        let mut nu = 0.5 * CYCLES_MIN;
        while 2.0 * nu < FEW {
            self.look_at(span, levels, work, &nuisances, nu, most)?;
            nu += NEXT;
        }
        if line > nu {
            self.look_at(span, levels, work, &nuisances, line, most)?;
        }
        Some(())
    }

    /// All models at the strongest line on a drift like `curve`.
    #[inline(never)]
    pub fn look_on_drift(
        &mut self,
        span: &mut FrameSpan,
        levels: &Levels,
        work: &mut Work,
        most: usize,
        place: Place,
        curve: Curve,
    ) -> Option<()> {
        let mut nuisances = <[Nuisances; 2]>::default();
        for (nuisances, curve) in nuisances.iter_mut().zip([Curve::Bent, curve]) {
            *nuisances = Nuisances::new(span, levels, curve)?;
        }
        let [bent, drift] = &nuisances;
        let Place { channels, points, power } = place;
        let peak = strongest(span, levels, drift, CYCLES_FOR_SLOPE, channels, points, power)?;
        let likely = if matches!(curve, Curve::Relaxing(_)) { &nuisances[..] } else { core::slice::from_ref(bent) };
        match peak.filter(|peak| 2.0 * peak >= CYCLES_FOR_SLOPE) {
            Some(peak) => self.look_at(span, levels, work, likely, peak, most),
            None => Some(()),
        }
    }

    /// All models at `nu`.
    fn look_at(
        &mut self,
        span: &mut FrameSpan,
        levels: &Levels,
        work: &mut Work,
        nuisances: &[Nuisances],
        nu: f32,
        most: usize,
    ) -> Option<()> {
        let harmonics = harmonics_below_nyquist(span, nu, most);
        for (k, nuisances) in nuisances.iter().enumerate() {
            let Work { sums, solution } = &mut *work;
            match k {
                0 => sums.collect(span, levels, nuisances, nu, harmonics)?,
                _ => sums.exchange(span, levels, nuisances, nu, harmonics)?,
            }
            let straight = nuisances.count() - CURVE;
            let shapes: &[_] = match nuisances.curve {
                Curve::Relaxing(_) => &[(true, 1)],
                _ => &[(false, 0), (true, 0), (true, CURVE)],
            };
            for (slope, curve) in shapes {
                let shape = Shape { harmonics, slope: *slope, nuisances: straight + curve };
                let curve = if *curve > 0 { nuisances.curve } else { Curve::None };
                solution.residual_sums(sums, levels, nuisances, &shape, &mut |harmonics, residual_sum_of_squares| {
                    let nu = if harmonics > 0 { nu } else { 0.0 };
                    let model = Model {
                        nu,
                        curve,
                        shape: Shape { harmonics, ..shape },
                        residual_sum_of_squares: *residual_sum_of_squares,
                        refined: false,
                    };
                    self.add(levels, &model);
                });
            }
        }
        Some(())
    }
}
