//! What a solution leaves of the frames, a block of them at a time.

use crate::curves::curves;
use crate::frame_span::{BLOCK, FrameSpan};
use crate::limits::{CHANNELS_MAX, CURVES_MAX, LINES_MAX};
use crate::phase::{cos_sin, from_turns};
use crate::solve::Solution;
use crate::source::Values;
use crate::statistics::Statistics;

/// Frames over which a curve is straight.
const PART: usize = 4;

/// The middle of a part.
fn middle(u: &[f32; PART]) -> f32 {
    0.5 * (u[0] + u[PART - 1])
}

/// Cosine and sine of a line at the places `u`; `turn` is by one frame, where all are as far apart.
#[inline(never)]
pub fn along(
    nu: f32,
    turn: Option<(f32, f32)>,
    u: &[f32; BLOCK],
    [cosines, sines]: [&mut [f32; BLOCK]; 2],
) {
    let (mut cos, mut sin) = cos_sin(from_turns(nu * u[0]));
    for (i, (to_cos, to_sin)) in cosines.iter_mut().zip(sines).enumerate() {
        (*to_cos, *to_sin) = (cos, sin);
        (cos, sin) = match turn {
            Some((by_cos, by_sin)) => (cos * by_cos - sin * by_sin, sin * by_cos + cos * by_sin),
            None => cos_sin(from_turns(nu * u[(i + 1) % BLOCK])),
        };
    }
}

/// A solution over a block of frames: `u`, cosine and sine of each line, and the curves about the
/// middle of each part.
pub struct Waves<'s> {
    statistics: &'s Statistics,
    pub solution: &'s Solution,
    nu: f32,
    harmonics: usize,
    interferer: Option<f32>,
    /// By one frame, where all are as far apart.
    turn: Option<(f32, f32)>,
    pub u: [f32; BLOCK],
    cos: [[f32; BLOCK]; LINES_MAX],
    sin: [[f32; BLOCK]; LINES_MAX],
    curves: [[[f32; 2]; CURVES_MAX]; BLOCK / PART],
}

impl<'s> Waves<'s> {
    /// Of a solution whose unknowns are those at `nu`, with an interferer.
    pub fn new(
        span: &FrameSpan,
        statistics: &'s Statistics,
        solution: &'s Solution,
        (nu, interferer): (f32, Option<f32>),
    ) -> Self {
        let none = [[0.0; BLOCK]; LINES_MAX];
        let shape = &solution.shape;
        Self {
            statistics,
            solution,
            nu,
            harmonics: shape.harmonics.min(LINES_MAX - shape.interferer as usize),
            interferer: interferer.filter(|_| shape.interferer),
            turn: span
                .abscissa()
                .step()
                .map(|step| cos_sin(from_turns(nu * step))),
            u: [0.0; BLOCK],
            cos: none,
            sin: none,
            curves: [[[0.0; 2]; CURVES_MAX]; BLOCK / PART],
        }
    }

    /// Goes to the places `u`.
    #[inline(never)]
    pub fn go(&mut self, u: [f32; BLOCK]) {
        self.u = u;
        let ([first_cos, cosines @ ..], [first_sin, sines @ ..]) = (&mut self.cos, &mut self.sin);
        along(self.nu, self.turn, &u, [first_cos, first_sin]);
        let (mut of_cos, mut of_sin) = (&*first_cos, &*first_sin);
        for (cos, sin) in cosines
            .iter_mut()
            .zip(sines)
            .take(self.harmonics.saturating_sub(1))
        {
            for i in 0..BLOCK {
                let (c, s) = (of_cos[i], of_sin[i]);
                (cos[i], sin[i]) = (
                    c * first_cos[i] - s * first_sin[i],
                    s * first_cos[i] + c * first_sin[i],
                );
            }
            (of_cos, of_sin) = (cos, sin);
        }
        if let (Some(interferer), Some(cos), Some(sin)) =
            (self.interferer, self.cos.last_mut(), self.sin.last_mut())
        {
            for (i, u) in u.iter().enumerate() {
                (cos[i], sin[i]) = cos_sin(from_turns(interferer * u));
            }
        }
        if self.solution.shape.curves > 0 {
            for (at, u) in self.curves.iter_mut().zip(u.as_chunks::<PART>().0) {
                *at = curves(middle(u));
            }
        }
    }

    fn unknown(&self, index: usize, k: usize) -> f32 {
        self.solution
            .unknowns
            .get(index)
            .map_or(0.0, |row| row[k % CHANNELS_MAX])
    }

    /// Residuals of the solution's channel `k`, which is channel `c` of the frames, in units of its
    /// scale.
    #[inline(never)]
    pub fn residuals(&self, values: &[Values; BLOCK], c: usize, k: usize) -> [f32; BLOCK] {
        let (shape, c) = (&self.solution.shape, c % CHANNELS_MAX);
        let scale = self.statistics.scale[c];
        let (level, slope) = (
            self.unknown(0, k),
            self.unknown(1, k) + self.statistics.slope[c] * scale,
        );
        let offset = self.statistics.offset[c];
        let mut residual: [f32; BLOCK] =
            core::array::from_fn(|i| (values[i][c] - offset) * scale - level - slope * self.u[i]);
        let interferer = self.interferer.map(|_| (LINES_MAX - 1, 2));
        let lines = (0..self.harmonics)
            .map(|h| (h, shape.first_wave() + 2 * h))
            .chain(interferer);
        for (line, first) in lines {
            let (with_cos, with_sin) = (self.unknown(first, k), self.unknown(first + 1, k));
            let (cos, sin) = (&self.cos[line % LINES_MAX], &self.sin[line % LINES_MAX]);
            for i in 0..BLOCK {
                residual[i] -= with_cos * cos[i] + with_sin * sin[i];
            }
        }
        let parts = residual
            .as_chunks_mut::<PART>()
            .0
            .iter_mut()
            .zip(self.u.as_chunks::<PART>().0);
        for ((residual, u), curves) in
            parts
                .zip(&self.curves)
                .take(if shape.curves > 0 { BLOCK } else { 0 })
        {
            for (curve, [value, along]) in curves.iter().enumerate().take(shape.curves) {
                let factor = self.unknown(shape.first_curve() + curve, k);
                for (residual, at) in residual.iter_mut().zip(u) {
                    *residual -= factor * (value + along * (at - middle(u)));
                }
            }
        }
        residual
    }

    /// The model's derivative by the frequency in channel `k`, over 2 pi `u`.
    pub fn derivatives(&self, k: usize) -> [f32; BLOCK] {
        let mut derivative = [0.0; BLOCK];
        for h in 0..self.harmonics {
            let (first, order) = (self.solution.shape.first_wave() + 2 * h, (h + 1) as f32);
            let (of_cos, of_sin) = (
                order * self.unknown(first + 1, k),
                order * self.unknown(first, k),
            );
            let (cos, sin) = (&self.cos[h % LINES_MAX], &self.sin[h % LINES_MAX]);
            for i in 0..BLOCK {
                derivative[i] += of_cos * cos[i] - of_sin * sin[i];
            }
        }
        derivative
    }
}
