//! Sums over a stretch: all that the fit needs to know of it at one frequency, one pass each.

use crate::frame_span::{BLOCK, Block, FrameSpan};
use crate::levels::Levels;
use crate::nuisance::{Columns, NUISANCES_MAX, Nuisances};
use crate::source::CHANNELS_MAX;
use crate::source::Values;
use crate::waves::{Centre, Meets, Oscillator, Trigonometric, WING, Waves, Wings};

/// Most harmonics, the fundamental included.
pub const HARMONICS_MAX: usize = 5;

/// Columns that meet the waves: the taxels, and behind them the nuisances.
const COLUMNS: usize = CHANNELS_MAX + NUISANCES_MAX;

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
    #[inline(always)]
    pub const fn new() -> Self {
        let rows = [[0.0; COLUMNS]; HARMONICS_MAX];
        Self { trigonometric: Trigonometric::new(), cos: rows, sin: rows, u_cos: rows, u_sin: rows }
    }

    /// One pass at frequency `nu` with `harmonics` harmonics (1 to [`HARMONICS_MAX`]). None if the
    /// frames were overwritten.
    pub fn collect(
        &mut self,
        span: &mut FrameSpan,
        levels: &Levels,
        nuisances: &Nuisances,
        nu: f32,
        harmonics: usize,
    ) -> Option<()> {
        self.collect_of(levels.usable, span, levels, nuisances, nu, harmonics)
    }

    /// The sums of other nuisances in place of those that the latest pass had, at its `nu` and with its `harmonics`.
    pub fn exchange(
        &mut self,
        span: &mut FrameSpan,
        levels: &Levels,
        nuisances: &Nuisances,
        nu: f32,
        harmonics: usize,
    ) -> Option<()> {
        self.collect_of(0, span, levels, nuisances, nu, harmonics)
    }

    /// The sums of some `taxels` and the nuisances.
    #[inline(never)]
    fn collect_of(
        &mut self,
        taxels: u16,
        span: &mut FrameSpan,
        levels: &Levels,
        nuisances: &Nuisances,
        nu: f32,
        harmonics: usize,
    ) -> Option<()> {
        let mut oscillator = Oscillator::new(span, nu, harmonics);
        oscillator.find_wings();
        let first = if taxels == 0 { CHANNELS_MAX } else { 0 };
        // Rows of harmonics that are not asked for are left as they were: nobody reads them.
        self.trigonometric.clear(oscillator.harmonics);
        for rows in [&mut self.cos, &mut self.sin, &mut self.u_cos, &mut self.u_sin] {
            rows.iter_mut().take(oscillator.harmonics).for_each(|row| row[first..].fill(0.0));
        }
        let (abscissa, frames, in_time) = (span.abscissa(), span.frames, span.is_in_time());
        let (mut centre, mut waves, mut folded) = (Centre::new(), Waves::new(), [[[0.0; GROUP]; 2]; WING]);
        let mut halves = [[[[0.0; GROUP]; 2]; 2]; 2];
        let mut columns: Columns = [[0.0; NUISANCES_MAX]; BLOCK];
        span.blocks(&levels.offset, &mut |block| {
            oscillator.centre(block.at, &mut centre);
            if block.whole && in_time {
                self.trigonometric.add_block(&centre, &oscillator);
            } else {
                oscillator.fill(&block, &mut waves);
                self.trigonometric.add_frames(&block, &waves, oscillator.harmonics);
            }
            for group in 0..CHANNELS_MAX / GROUP {
                let first = GROUP * group;
                if taxels >> first & ((1 << GROUP) - 1) == 0 {
                    continue;
                }
                match in_time {
                    true if oscillator.harmonics == 1 => {
                        let [even, odd] = fundamental(&block, &levels.offset, group, &oscillator.wings);
                        self.add_parts(first, 0, &even, &odd, &centre);
                    }
                    true => {
                        fold(&mut folded, &block, &levels.offset, group);
                        self.add_folded(first, &folded, &mut halves, &oscillator.wings, &centre);
                    }
                    false => self.add_along(first, &part(&block, &levels.offset, group), &waves, oscillator.harmonics),
                }
            }
            if nuisances.count() > 0 {
                let u = abscissa.block(block.at, frames);
                nuisances.fill(&block, &u, &mut columns);
                match in_time {
                    true => {
                        fold_columns(&mut folded, &columns);
                        self.add_folded(CHANNELS_MAX, &folded, &mut halves, &oscillator.wings, &centre);
                    }
                    false => self.add_along(CHANNELS_MAX, &columns, &waves, oscillator.harmonics),
                }
            }
        })?;
        // A taxel that takes no part may hold anything, NaN too, and no weight takes that away.
        for c in (0..CHANNELS_MAX).filter(|c| levels.usable & 1 << c == 0) {
            for rows in [&mut self.cos, &mut self.sin, &mut self.u_cos, &mut self.u_sin] {
                rows.iter_mut().for_each(|row| row[c] = 0.0);
            }
        }
        Some(())
    }

    /// A block in time: what is even and odd about its centre meets the harmonics' halves that are, two of them at
    /// a time: as many sums as there are registers for.
    fn add_folded(
        &mut self,
        first: usize,
        folded: &Folded,
        halves: &mut [[Halves; 2]; 2],
        wings: &Wings,
        centre: &Centre,
    ) {
        let harmonics = centre.turns().len();
        for h in (0..harmonics).step_by(2) {
            // Both kinds of halves, of two harmonics; filled before they are read.
            let [even, odd] = &mut *halves;
            if h + 1 < harmonics {
                meet::<0, 2>(even, folded, h, &wings.even);
                meet::<1, 2>(odd, folded, h, &wings.odd);
                self.add_parts(first, h, &even[0], &odd[0], centre);
                self.add_parts(first, h + 1, &even[1], &odd[1], centre);
            } else {
                let ([even, _], [odd, _]) = (even, odd);
                meet::<0, 1>(core::array::from_mut(even), folded, h, &wings.even);
                meet::<1, 1>(core::array::from_mut(odd), folded, h, &wings.odd);
                self.add_parts(first, h, even, odd, centre);
            }
        }
    }

    /// One harmonic of that, turned from the phase of the block's centre.
    #[inline(never)]
    fn add_parts(&mut self, first: usize, h: usize, even: &Halves, odd: &Halves, centre: &Centre) {
        let h = h.min(HARMONICS_MAX - 1);
        let (u, (c, s)) = (centre.u, centre.turn(h));
        let rows = [&mut self.cos[h], &mut self.sin[h], &mut self.u_cos[h], &mut self.u_sin[h]];
        let [Some(to_cos), Some(to_sin), Some(to_u_cos), Some(to_u_sin)] =
            rows.map(|row| row.get_mut(first..).and_then(|row| row.first_chunk_mut::<GROUP>()))
        else {
            return;
        };
        for k in 0..GROUP {
            let (even, far_even, odd, far_odd) = (even[0][k], even[1][k], odd[0][k], odd[1][k]);
            let (cos, sin) = (c * even - s * odd, s * even + c * odd);
            let (far_cos, far_sin) = (c * far_odd - s * far_even, s * far_odd + c * far_even);
            to_cos[k] += cos;
            to_sin[k] += sin;
            to_u_cos[k] += u * cos + far_cos;
            to_u_sin[k] += u * sin + far_sin;
        }
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

/// What the even (or odd) parts of some columns have in common with one harmonic about the block's centre: with the
/// cosine, and with the distance times the sine (or the other way round).
type Halves = [Sums; 2];

/// Some taxels of a frame.
#[inline(always)]
fn some(values: &Values, group: usize) -> &Sums {
    &values.as_chunks().0[group % (CHANNELS_MAX / GROUP)]
}

/// Sum, less twice the offset, and difference of two values of a taxel. Offset first: it is next to both.
#[inline(always)]
fn fold_two(before: f32, behind: f32, twice: f32) -> (f32, f32) {
    ((before - twice) + behind, behind - before)
}

/// Folds a group of taxels.
#[inline(never)]
fn fold(folded: &mut Folded, block: &Block, offset: &Values, group: usize) {
    let twice = some(offset, group).map(|offset| 2.0 * offset);
    let (before, behind) = block.values.split_at(WING);
    for ((folded, before), behind) in folded.iter_mut().zip(before.iter().rev()).zip(behind) {
        let (before, behind) = (some(before, group), some(behind, group));
        for c in 0..GROUP {
            (folded[0][c], folded[1][c]) = fold_two(before[c], behind[c], twice[c]);
        }
    }
}

/// Folds columns that have no offset.
#[inline(never)]
fn fold_columns(folded: &mut Folded, columns: &Part) {
    let (before, behind) = columns.split_at(WING);
    for ((folded, before), behind) in folded.iter_mut().zip(before.iter().rev()).zip(behind) {
        for c in 0..GROUP {
            (folded[0][c], folded[1][c]) = fold_two(before[c], behind[c], 0.0);
        }
    }
}

/// What a group of taxels has in common with the first harmonic, folded on the way.
#[inline(never)]
fn fundamental(block: &Block, offset: &Values, group: usize, wings: &Wings) -> [Halves; 2] {
    let twice = some(offset, group).map(|offset| 2.0 * offset);
    let (mut with_cos, mut with_far_sin, mut with_sin, mut with_far_cos) =
        ([0.0; GROUP], [0.0; GROUP], [0.0; GROUP], [0.0; GROUP]);
    let (before, behind) = block.values.split_at(WING);
    let wings = wings.even.iter().zip(&wings.odd);
    for ((before, behind), (with_even, with_odd)) in before.iter().rev().zip(behind).zip(wings) {
        let (before, behind) = (some(before, group), some(behind, group));
        let ([cos, far_sin], [sin, far_cos]) = (with_even[0], with_odd[0]);
        for c in 0..GROUP {
            let (even, odd) = fold_two(before[c], behind[c], twice[c]);
            with_cos[c] += even * cos;
            with_far_sin[c] += even * far_sin;
            with_sin[c] += odd * sin;
            with_far_cos[c] += odd * far_cos;
        }
    }
    [[with_cos, with_far_sin], [with_sin, with_far_cos]]
}

/// Even (0) or odd (1) parts times what they meet of `N` harmonics from `h` on.
#[inline(never)]
fn meet<const PARITY: usize, const N: usize>(out: &mut [Halves; N], folded: &Folded, h: usize, meets: &[Meets; WING]) {
    let of = |meets: &'_ Meets| meets.get(h..).and_then(|meets| meets.first_chunk::<N>()).copied();
    let mut rows = folded.iter().zip(meets);
    let Some((row, meets)) = rows.next() else { return };
    let Some(meets) = of(meets) else { return };
    // From the first row on, not from zero: the compiler would call for it.
    let mut sums: [Halves; N] =
        core::array::from_fn(|n| meets[n].map(|meets| core::array::from_fn(|c| row[PARITY][c] * meets)));
    for (row, meets) in rows {
        let Some(meets) = of(meets) else { return };
        for n in 0..N {
            for c in 0..GROUP {
                sums[n][0][c] += row[PARITY][c] * meets[n][0];
                sums[n][1][c] += row[PARITY][c] * meets[n][1];
            }
        }
    }
    *out = sums;
}

/// All frames of a group of taxels, less their offsets.
pub(crate) fn part(block: &Block, offset: &Values, group: usize) -> Part {
    let zero = some(offset, group);
    block.values.each_ref().map(|values| {
        let values = some(values, group);
        core::array::from_fn(|c| values[c] - zero[c])
    })
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

impl Default for Moments {
    fn default() -> Self {
        Self::new()
    }
}
