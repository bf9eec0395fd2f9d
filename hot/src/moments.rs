//! Sums over a stretch: all that the fit needs to know of it at one frequency, one pass each.

use crate::levels::Levels;
use crate::nuisance::{Columns, NUISANCES_MAX, Nuisances};
use crate::settings::TAXELS;
use crate::stretch::{BLOCK, Block, Stretch};
use crate::waves::{Centre, Oscillator, Trigonometric, WING, Waves, Wing, Wings};
use crate::window::Values;

/// Most harmonics, the fundamental included.
pub const HARMONICS_MAX: usize = 5;

/// Columns that meet the waves: the taxels, and behind them the nuisances.
const COLUMNS: usize = TAXELS + NUISANCES_MAX;

/// One sum for each taxel, and behind them one for each nuisance.
pub type Row = [f32; COLUMNS];

/// What one pass at one frequency gives. y is a channel less its [`Levels::offset`], or a nuisance.
#[derive(Clone, Debug)]
pub struct Moments {
    /// Sums of the harmonics alone.
    pub trigonometric: Trigonometric,
    /// Sums of y cos(h theta), h from 1.
    pub cos: [Row; HARMONICS_MAX],
    /// Sums of y sin(h theta).
    pub sin: [Row; HARMONICS_MAX],
    /// Sums of u y cos(h theta).
    pub u_cos: [Row; HARMONICS_MAX],
    /// Sums of u y sin(h theta).
    pub u_sin: [Row; HARMONICS_MAX],
}

impl Moments {
    /// No sums yet; `const`, so that they can live in a static.
    pub const fn new() -> Self {
        let rows = [[0.0; COLUMNS]; HARMONICS_MAX];
        Self { trigonometric: Trigonometric::new(), cos: rows, sin: rows, u_cos: rows, u_sin: rows }
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
        // Rows of harmonics that are not asked for are left as they were: nobody reads them.
        self.trigonometric.clear(oscillator.harmonics);
        for rows in [&mut self.cos, &mut self.sin, &mut self.u_cos, &mut self.u_sin] {
            rows.iter_mut().take(oscillator.harmonics).for_each(|row| *row = [0.0; COLUMNS]);
        }
        let (abscissa, frames, in_time) = (stretch.abscissa(), stretch.frames, stretch.is_in_time());
        let (mut centre, mut waves, mut folded) = (Centre::new(), Waves::new(), [[[0.0; GROUP]; 2]; WING]);
        let mut columns: Columns = [[0.0; NUISANCES_MAX]; BLOCK];
        stretch.blocks(&levels.offset, &mut |block| {
            oscillator.centre(block.at, &mut centre);
            if block.whole && in_time {
                self.trigonometric.add_block(&centre, &oscillator);
            } else {
                oscillator.fill(block.at, &mut waves);
                self.trigonometric.add_frames(&block, &waves, oscillator.harmonics);
            }
            for group in 0..TAXELS / GROUP {
                let first = GROUP * group;
                if levels.usable >> first & ((1 << GROUP) - 1) != 0 {
                    let row = rows(&block, &levels.offset, group);
                    match in_time {
                        true => {
                            fold(&mut folded, row);
                            self.add_folded(first, &folded, &oscillator.wings, &centre);
                        }
                        false => {
                            self.add_along(first, &part(&block, &levels.offset, group), &waves, oscillator.harmonics)
                        }
                    }
                }
            }
            if nuisances.count() > 0 {
                let u = abscissa.block(block.at, frames);
                nuisances.fill(&block, &u, &mut columns);
                match in_time {
                    true => {
                        fold(&mut folded, |i| columns[i]);
                        self.add_folded(TAXELS, &folded, &oscillator.wings, &centre);
                    }
                    false => self.add_along(TAXELS, &columns, &waves, oscillator.harmonics),
                }
            }
        })?;
        // A taxel that takes no part may hold anything, NaN too, and no weight takes that away.
        for c in (0..TAXELS).filter(|c| levels.usable & 1 << c == 0) {
            for rows in [&mut self.cos, &mut self.sin, &mut self.u_cos, &mut self.u_sin] {
                rows.iter_mut().for_each(|row| row[c] = 0.0);
            }
        }
        Some(())
    }

    /// A block in time: what is even and odd about its centre meets the harmonics' halves that are.
    fn add_folded(&mut self, first: usize, folded: &Folded, wings: &Wings, centre: &Centre) {
        for (h, (c, s)) in centre.turns().iter().enumerate() {
            self.add_harmonic(first, h, folded, wings, [*c, *s, centre.u]);
        }
    }

    /// One harmonic of that. Apart, so that the compiler does not carry all the columns in registers around
    /// the loop, which it has not enough of.
    #[inline(never)]
    fn add_harmonic(&mut self, first: usize, h: usize, folded: &Folded, wings: &Wings, [c, s, u]: [f32; 3]) {
        let h = h.min(HARMONICS_MAX - 1);
        // The distance from the centre is odd: times it, the cosine's half is odd and the sine's even.
        let [even_half, far_even_half] = wing_products::<0>(folded, &wings.cos[h], &wings.far_sin[h]);
        let [odd_half, far_odd_half] = wing_products::<1>(folded, &wings.sin[h], &wings.far_cos[h]);
        let (cos, sin) = turn(even_half, odd_half, c, s);
        let (far_cos, far_sin) = turn(far_odd_half, far_even_half, c, s);
        let u_cos = core::array::from_fn(|k| u * cos[k] + far_cos[k]);
        let u_sin = core::array::from_fn(|k| u * sin[k] + far_sin[k]);
        self.add_sums(first, h, [cos, sin, u_cos, u_sin]);
    }

    /// A block along a path, where no two are alike.
    #[inline(never)]
    fn add_along(&mut self, first: usize, part: &Part, waves: &Waves, harmonics: usize) {
        for h in 0..harmonics.min(HARMONICS_MAX) {
            let (cos, sin) = (&waves.cos[h], &waves.sin[h]);
            let (mut u_cos, mut u_sin) = (*cos, *sin);
            for i in 0..BLOCK {
                u_cos[i] *= waves.u[i];
                u_sin[i] *= waves.u[i];
            }
            self.add_sums(first, h, [cos, sin, &u_cos, &u_sin].map(|function| products(part, function)));
        }
    }

    #[inline(always)]
    fn add_sums(&mut self, first: usize, h: usize, sums: [Sums; 4]) {
        let rows = [&mut self.cos[h], &mut self.sin[h], &mut self.u_cos[h], &mut self.u_sin[h]];
        for (row, sums) in rows.into_iter().zip(sums) {
            let Some(row) = row[first..].first_chunk_mut::<GROUP>() else { return };
            for c in 0..GROUP {
                row[c] += sums[c];
            }
        }
    }
}

/// Columns that are taken together.
pub(crate) const GROUP: usize = 4;

/// Some columns of a block.
pub(crate) type Part = [[f32; GROUP]; BLOCK];

/// A sum for each of them.
pub(crate) type Sums = [f32; GROUP];

/// Sums and differences of what lies as far before and behind a block's centre.
type Folded = [[Sums; 2]; WING];

#[inline(always)]
fn fold(folded: &mut Folded, row: impl Fn(usize) -> Sums) {
    for (i, folded) in folded.iter_mut().enumerate() {
        let (before, behind) = (row(WING - 1 - i), row(WING + i));
        for c in 0..GROUP {
            (folded[0][c], folded[1][c]) = (behind[c] + before[c], behind[c] - before[c]);
        }
    }
}

/// Sums of columns, even (0) or odd (1), times two functions.
#[inline(never)]
fn wing_products<const PARITY: usize>(folded: &Folded, first: &Wing, second: &Wing) -> [Sums; 2] {
    let mut sums = [[0.0; GROUP]; 2];
    for ((row, first), second) in folded.iter().zip(first).zip(second) {
        for c in 0..GROUP {
            sums[0][c] += row[PARITY][c] * first;
            sums[1][c] += row[PARITY][c] * second;
        }
    }
    sums
}

/// A frame of a group of taxels, less its offsets.
#[inline(always)]
fn rows<'a>(block: &'a Block, offset: &Values, group: usize) -> impl Fn(usize) -> Sums + use<'a> {
    let of = move |values: &Values| -> Sums { values.as_chunks().0[group] };
    let (zero, values) = (of(offset), block.values);
    move |i| {
        let values = of(&values[i]);
        core::array::from_fn(|c| values[c] - zero[c])
    }
}

/// All frames of them.
pub(crate) fn part(block: &Block, offset: &Values, group: usize) -> Part {
    core::array::from_fn(rows(block, offset, group))
}

/// Sums of columns times a function.
// Of the slower ways, and called from several: one copy is enough.
#[inline(never)]
pub(crate) fn products(part: &Part, function: &[f32; BLOCK]) -> Sums {
    let mut sums = [0.0; GROUP];
    for (row, factor) in part.iter().zip(function) {
        for c in 0..GROUP {
            sums[c] += row[c] * factor;
        }
    }
    sums
}

/// Sums with cosine and sine about a centre, turned to the phase of that centre.
#[inline(always)]
fn turn(even: Sums, odd: Sums, c: f32, s: f32) -> (Sums, Sums) {
    (core::array::from_fn(|k| c * even[k] - s * odd[k]), core::array::from_fn(|k| s * even[k] + c * odd[k]))
}

impl Default for Moments {
    fn default() -> Self {
        Self::new()
    }
}
