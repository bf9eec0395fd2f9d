//! Sums over a stretch: all that the fit needs to know of it at one frequency, one pass each.

use crate::levels::Levels;
use crate::nuisance::{Columns, NUISANCES_MAX, Nuisances};
use crate::settings::TAXELS;
use crate::stretch::{BLOCK, Stretch};
use crate::waves::{Centre, Oscillator, Trigonometric, WING, Waves};

/// Most harmonics, the fundamental included.
pub const HARMONICS_MAX: usize = 5;

/// Columns that meet the waves: the taxels, and behind them the nuisances.
const COLUMNS: usize = TAXELS + NUISANCES_MAX;

/// One sum for each taxel, and behind them one for each nuisance.
pub type Row = [f32; COLUMNS];

/// Stretches of at least so many frames take one lever for a block of frames.
const LONG: u32 = 160;

/// What one pass at one frequency gives. y is a channel less its [`Levels::offset`], or a nuisance.
#[derive(Clone, Debug)]
pub struct Moments {
    /// Sums of the harmonics alone.
    pub trigonometric: Trigonometric,
    /// Sums of y cos(h theta), h from 1.
    pub cos: [Row; HARMONICS_MAX],
    /// Sums of y sin(h theta).
    pub sin: [Row; HARMONICS_MAX],
    /// Sums of lever y cos(h theta).
    pub lever_cos: [Row; HARMONICS_MAX],
    /// Sums of lever y sin(h theta).
    pub lever_sin: [Row; HARMONICS_MAX],
}

/// A column about its block's centre: sums and differences of what lies as far before and behind it.
#[inline(always)]
fn fold(y: &[f32; BLOCK]) -> ([f32; WING], [f32; WING]) {
    let (mut even, mut odd) = ([0.0; WING], [0.0; WING]);
    for i in 0..WING {
        let (before, behind) = (y[WING - 1 - i], y[WING + i]);
        (even[i], odd[i]) = (behind + before, behind - before);
    }
    (even, odd)
}

#[inline(always)]
fn dot(a: &[f32; WING], b: &[f32; WING]) -> f32 {
    let mut sum = a[0] * b[0];
    for i in 1..WING {
        sum += a[i] * b[i];
    }
    sum
}

impl Moments {
    /// No sums yet; `const`, so that they can live in a static.
    pub const fn new() -> Self {
        let rows = [[0.0; COLUMNS]; HARMONICS_MAX];
        Self { trigonometric: Trigonometric::new(true), cos: rows, sin: rows, lever_cos: rows, lever_sin: rows }
    }

    /// One pass at frequency `nu` with `harmonics` harmonics (1 to [`HARMONICS_MAX`]). None if the
    /// frames were overwritten.
    #[inline(never)]
    pub fn collect(
        &mut self,
        stretch: &mut Stretch,
        levels: &Levels,
        nuisances: &Nuisances,
        nu: f32,
        harmonics: usize,
    ) -> Option<()> {
        let oscillator = Oscillator::new(stretch, nu, harmonics);
        let exact = stretch.frames < LONG || !stretch.is_in_time();
        *self = Self { trigonometric: Trigonometric::new(exact), ..Self::new() };
        let (abscissa, frames, in_time) = (stretch.abscissa(), stretch.frames, stretch.is_in_time());
        let mut waves = Waves::new();
        let mut columns: Columns = [[0.0; BLOCK]; NUISANCES_MAX];
        stretch.blocks(&levels.offset, &mut |block| {
            let centre = oscillator.centre(block.at);
            if block.whole && in_time {
                self.trigonometric.add_block(&oscillator, &centre);
            } else {
                oscillator.fill(block.at, &mut waves);
                self.trigonometric.add_frames(&block, &waves, centre.u, oscillator.harmonics);
            }
            if nuisances.count() > 0 {
                nuisances.fill(&block, &abscissa.block(block.at, frames), &mut columns);
            }
            let mut add = |column, y: &[f32; BLOCK]| match (in_time, exact) {
                (false, _) => self.add_along(column, y, &waves, oscillator.harmonics),
                (true, true) => self.add_short(column, y, &oscillator, &centre),
                (true, false) => self.add_long(column, y, &oscillator, &centre),
            };
            for c in 0..TAXELS {
                if levels.usable & 1 << c == 0 {
                    continue;
                }
                let mut y = [0.0; BLOCK];
                for i in 0..BLOCK {
                    y[i] = block.values[i][c] - levels.offset[c];
                }
                add(c, &y);
            }
            for (k, column) in columns.iter().enumerate().take(nuisances.count()) {
                add(TAXELS + k, column);
            }
        })
    }

    #[inline(always)]
    fn add_long(&mut self, column: usize, y: &[f32; BLOCK], oscillator: &Oscillator, centre: &Centre) {
        let (even, odd) = fold(y);
        for h in 0..oscillator.harmonics.min(HARMONICS_MAX) {
            let (c, s) = (centre.cos[h + 1], centre.sin[h + 1]);
            let (cos, sin) = (dot(&even, &oscillator.cos[h]), dot(&odd, &oscillator.sin[h]));
            let (cos, sin) = (c * cos - s * sin, s * cos + c * sin);
            self.add(column, h, cos, sin, centre.u * cos, centre.u * sin);
        }
    }

    #[inline(always)]
    fn add_short(&mut self, column: usize, y: &[f32; BLOCK], oscillator: &Oscillator, centre: &Centre) {
        let (even, odd) = fold(y);
        for h in 0..oscillator.harmonics.min(HARMONICS_MAX) {
            let (c, s) = (centre.cos[h + 1], centre.sin[h + 1]);
            let (cos, sin) = (dot(&even, &oscillator.cos[h]), dot(&odd, &oscillator.sin[h]));
            // The distance from the centre is odd: it swaps what is even and what is odd.
            let (far_cos, far_sin) = (dot(&odd, &oscillator.far_cos[h]), dot(&even, &oscillator.far_sin[h]));
            let (cos, sin) = (c * cos - s * sin, s * cos + c * sin);
            let (far_cos, far_sin) = (c * far_cos - s * far_sin, s * far_cos + c * far_sin);
            self.add(column, h, cos, sin, centre.u * cos + far_cos, centre.u * sin + far_sin);
        }
    }

    /// Along a path no two blocks are alike.
    #[inline(never)]
    fn add_along(&mut self, column: usize, y: &[f32; BLOCK], waves: &Waves, harmonics: usize) {
        for h in 0..harmonics.min(HARMONICS_MAX) {
            let (mut cos, mut sin, mut u_cos, mut u_sin) = (0.0, 0.0, 0.0, 0.0);
            for i in 0..BLOCK {
                let (y_cos, y_sin) = (y[i] * waves.cos[h][i], y[i] * waves.sin[h][i]);
                cos += y_cos;
                sin += y_sin;
                u_cos += waves.u[i] * y_cos;
                u_sin += waves.u[i] * y_sin;
            }
            self.add(column, h, cos, sin, u_cos, u_sin);
        }
    }

    #[inline(always)]
    fn add(&mut self, column: usize, h: usize, cos: f32, sin: f32, lever_cos: f32, lever_sin: f32) {
        self.cos[h][column] += cos;
        self.sin[h][column] += sin;
        self.lever_cos[h][column] += lever_cos;
        self.lever_sin[h][column] += lever_sin;
    }
}

impl Default for Moments {
    fn default() -> Self {
        Self::new()
    }
}
