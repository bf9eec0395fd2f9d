//! Sums over a span at one frequency, one pass each: all that the least-squares solution there needs of the frames.

use crate::frame_span::{BLOCK, Block, FrameSpan};
use crate::groups::{GROUP, Part, Sums, group_of, part, products};
use crate::levels::Levels;
use crate::limits::{CHANNELS_MAX, HARMONICS_MAX, NUISANCES_MAX};
use crate::nuisance::{Columns, Nuisances};
use crate::source::{Overwritten, Values};
use crate::waves::{Centre, CentredWaves, Factors, HALF_BLOCK, Oscillator, Trigonometric, Waves};

/// Columns that are multiplied with the waves: the channels, and behind them the nuisances.
const COLUMNS: usize = CHANNELS_MAX + NUISANCES_MAX;

/// One sum for each channel, and behind them one for each nuisance.
pub type Row = [f32; COLUMNS];

/// The sums of one pass. y is a channel less its [`Levels::offset`], or a nuisance.
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

    /// One pass at frequency `nu` with `harmonics` harmonics (1 to [`HARMONICS_MAX`]).
    pub fn collect(
        &mut self,
        span: &mut FrameSpan,
        levels: &Levels,
        nuisances: &Nuisances,
        nu: f32,
        harmonics: usize,
    ) -> Result<(), Overwritten> {
        self.collect_of(levels.usable, span, levels, nuisances, nu, harmonics)
    }

    /// Replaces the sums of the nuisances of the latest pass, at its `nu` and with its `harmonics`.
    pub fn exchange(
        &mut self,
        span: &mut FrameSpan,
        levels: &Levels,
        nuisances: &Nuisances,
        nu: f32,
        harmonics: usize,
    ) -> Result<(), Overwritten> {
        self.collect_of(0, span, levels, nuisances, nu, harmonics)
    }

    /// The sums of some `channels` and the nuisances.
    #[inline(never)]
    fn collect_of(
        &mut self,
        channels: u16,
        span: &mut FrameSpan,
        levels: &Levels,
        nuisances: &Nuisances,
        nu: f32,
        harmonics: usize,
    ) -> Result<(), Overwritten> {
        let mut oscillator = Oscillator::new(span, nu, harmonics);
        oscillator.fill_centred();
        let first = if channels == 0 { CHANNELS_MAX } else { 0 };
        // Rows of other harmonics keep their values: nobody reads them.
        self.trigonometric.clear(oscillator.harmonics);
        for rows in [&mut self.cos, &mut self.sin, &mut self.u_cos, &mut self.u_sin] {
            rows.iter_mut().take(oscillator.harmonics).for_each(|row| row[first..].fill(0.0));
        }
        let (abscissa, frames, in_time) = (span.abscissa(), span.frames, span.is_in_time());
        let (mut centre, mut waves, mut folded) = (Centre::new(), Waves::new(), [[[0.0; GROUP]; 2]; HALF_BLOCK]);
        let mut halves = [[[[0.0; GROUP]; 2]; 2]; 2];
        let mut columns: Columns = [[0.0; NUISANCES_MAX]; BLOCK];
        span.blocks(&levels.offset, &mut |block| {
            oscillator.centre(block.first, &mut centre);
            if block.complete && in_time {
                self.trigonometric.add_block(&centre, &oscillator);
            } else {
                oscillator.fill(&block, &mut waves);
                self.trigonometric.add_frames(&block, &waves, oscillator.harmonics);
            }
            for group in 0..CHANNELS_MAX / GROUP {
                let first = GROUP * group;
                if channels >> first & ((1 << GROUP) - 1) == 0 {
                    continue;
                }
                match in_time {
                    true if oscillator.harmonics == 1 => {
                        let [even, odd] = fundamental(&block, &levels.offset, group, &oscillator.centred);
                        self.add_parts(first, 0, &even, &odd, &centre);
                    }
                    true => {
                        fold(&mut folded, &block, &levels.offset, group);
                        self.add_folded(first, &folded, &mut halves, &oscillator.centred, &centre);
                    }
                    false => self.add_along(first, &part(&block, &levels.offset, group), &waves, oscillator.harmonics),
                }
            }
            if nuisances.count() > 0 {
                let u = abscissa.block(block.first, frames);
                nuisances.fill(&block, &u, &mut columns);
                match in_time {
                    true => {
                        fold_columns(&mut folded, &columns);
                        self.add_folded(CHANNELS_MAX, &folded, &mut halves, &oscillator.centred, &centre);
                    }
                    false => self.add_along(CHANNELS_MAX, &columns, &waves, oscillator.harmonics),
                }
            }
        })?;
        // A channel that is not used may hold anything, NaN too, which no weight removes.
        for c in (0..CHANNELS_MAX).filter(|c| levels.usable & 1 << c == 0) {
            for rows in [&mut self.cos, &mut self.sin, &mut self.u_cos, &mut self.u_sin] {
                rows.iter_mut().for_each(|row| row[c] = 0.0);
            }
        }
        Ok(())
    }

    /// A block in time: its parts that are even and odd about its centre times the harmonics' even and odd parts, two
    /// harmonics at a time: as many sums as there are registers for.
    fn add_folded(
        &mut self,
        first: usize,
        folded: &Folded,
        halves: &mut [[Halves; 2]; 2],
        centred: &CentredWaves,
        centre: &Centre,
    ) {
        let harmonics = centre.turns().len();
        for h in (0..harmonics).step_by(2) {
            // Both kinds of halves, of two harmonics; filled before they are read.
            let [even, odd] = &mut *halves;
            if h + 1 < harmonics {
                multiply::<0, 2>(even, folded, h, &centred.even);
                multiply::<1, 2>(odd, folded, h, &centred.odd);
                self.add_parts(first, h, &even[0], &odd[0], centre);
                self.add_parts(first, h + 1, &even[1], &odd[1], centre);
            } else {
                let ([even, _], [odd, _]) = (even, odd);
                multiply::<0, 1>(core::array::from_mut(even), folded, h, &centred.even);
                multiply::<1, 1>(core::array::from_mut(odd), folded, h, &centred.odd);
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

    /// A block along a path, where no two have the same waves.
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

/// Sums and differences of values at the same distance before and behind a block's centre.
type Folded = [[Sums; 2]; HALF_BLOCK];

/// Sums of the even (or odd) parts of some columns times one harmonic about the block's centre: times the cosine, and
/// times the distance and the sine (or the other way round).
type Halves = [Sums; 2];

/// Sum, less twice the offset, and difference of two values of a channel. Offset first: it is next to both.
#[inline(always)]
fn fold_two(before: f32, behind: f32, twice: f32) -> (f32, f32) {
    ((before - twice) + behind, behind - before)
}

/// Folds a group of channels.
#[inline(never)]
fn fold(folded: &mut Folded, block: &Block, offset: &Values, group: usize) {
    let twice = group_of(offset, group).map(|offset| 2.0 * offset);
    let (before, behind) = block.values.split_at(HALF_BLOCK);
    for ((folded, before), behind) in folded.iter_mut().zip(before.iter().rev()).zip(behind) {
        let (before, behind) = (group_of(before, group), group_of(behind, group));
        for c in 0..GROUP {
            (folded[0][c], folded[1][c]) = fold_two(before[c], behind[c], twice[c]);
        }
    }
}

/// Folds columns that have no offset.
#[inline(never)]
fn fold_columns(folded: &mut Folded, columns: &Part) {
    let (before, behind) = columns.split_at(HALF_BLOCK);
    for ((folded, before), behind) in folded.iter_mut().zip(before.iter().rev()).zip(behind) {
        for c in 0..GROUP {
            (folded[0][c], folded[1][c]) = fold_two(before[c], behind[c], 0.0);
        }
    }
}

/// Sums of a group of channels times the first harmonic, folded meanwhile.
#[inline(never)]
fn fundamental(block: &Block, offset: &Values, group: usize, centred: &CentredWaves) -> [Halves; 2] {
    let twice = group_of(offset, group).map(|offset| 2.0 * offset);
    let (mut with_cos, mut with_far_sin, mut with_sin, mut with_far_cos) =
        ([0.0; GROUP], [0.0; GROUP], [0.0; GROUP], [0.0; GROUP]);
    let (before, behind) = block.values.split_at(HALF_BLOCK);
    let factors = centred.even.iter().zip(&centred.odd);
    for ((before, behind), (with_even, with_odd)) in before.iter().rev().zip(behind).zip(factors) {
        let (before, behind) = (group_of(before, group), group_of(behind, group));
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

/// Sums of even (0) or odd (1) parts times the factors of `N` harmonics from `h` on.
#[inline(never)]
fn multiply<const PARITY: usize, const N: usize>(
    out: &mut [Halves; N],
    folded: &Folded,
    h: usize,
    factors: &[Factors; HALF_BLOCK],
) {
    let of = |factors: &'_ Factors| factors.get(h..).and_then(|factors| factors.first_chunk::<N>()).copied();
    let mut rows = folded.iter().zip(factors);
    let Some((row, factors)) = rows.next() else { return };
    let Some(factors) = of(factors) else { return };
    // From the first row on, not from zero: the compiler would call for it.
    let mut sums: [Halves; N] =
        core::array::from_fn(|n| factors[n].map(|factor| core::array::from_fn(|c| row[PARITY][c] * factor)));
    for (row, factors) in rows {
        let Some(factors) = of(factors) else { return };
        for n in 0..N {
            for c in 0..GROUP {
                sums[n][0][c] += row[PARITY][c] * factors[n][0];
                sums[n][1][c] += row[PARITY][c] * factors[n][1];
            }
        }
    }
    *out = sums;
}

impl Default for Moments {
    fn default() -> Self {
        Self::new()
    }
}
