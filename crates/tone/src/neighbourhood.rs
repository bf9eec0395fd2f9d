//! What the residuals about a line say of the noise there, and of how the tone moves.
//!
//! The solution takes noise as white and independent in each channel. Touch is neither. What counts
//! for the frequency is one series: each channel's residual times the derivative of its model by
//! the frequency, weighted and summed over channels (the score's density). Its slow part, a few
//! cycles a window, is the noise next to the lines as the frequency meets it: coloured, and with
//! all that the channels share. Noise that is white and independent gives a known power there. A
//! tone that moves has its movement there.

use crate::blocks::{Blocks, Lines, product};
use crate::colour::{Colour, LAGS};
use crate::covariance::{Covariance, may_share};
use crate::curves::curves;
use crate::limits::{BLOCKS_MAX, CHANNELS_MAX, CURVES_MAX, HARMONICS_MAX, LINES_MAX, UNKNOWNS_MAX};
use crate::normal::{dot, subtract};
use crate::phase::{cos_sin, from_turns};
use crate::solve::{Solution, WAVES};
use crate::source::Values;

/// Cycles a window up to which the slow part goes.
const SLOW_CYCLES: usize = 5;
/// Degrees of the phase's deviation beyond a line: with sixteen blocks higher ones are not apart.
pub const PHASE_DEGREES: usize = 12;
/// Least share of the information of the strongest harmonic.
const INFORMATION_SHARE_MIN: f32 = 0.3;

/// The noise next to a solution's lines, as ratios to what noise that is white and independent
/// gives.
#[derive(Clone, Copy, Debug)]
pub struct Neighbourhood {
    /// Power of the slow part of the score's density, with about ten degrees of freedom.
    pub slow_power: f32,
    /// Power of the density, over that of as much noise that is independent: above 1 if channels
    /// share their noise with the signs of their tone.
    pub coherence: f32,
    /// Spectral density of the noise at the main line, and its power in the blocks' band about it.
    pub colour: f32,
    pub band: f32,
    /// The phase's deviation, cycles, as factors of Legendre's polynomials from the second degree
    /// on, each with its variance in noise that is white and independent. Zeros of what so few
    /// blocks do not show.
    pub phase: [[f32; 2]; PHASE_DEGREES],
    /// Power of the amplitude's deviation from block to block, over that of such noise: movement
    /// has no part in it.
    pub of_amplitude: f32,
    /// Whether the channels may share noise that is not the tone's; false if that was not
    /// requested.
    pub may_share: bool,
}

/// The series of the blocks.
struct Series<'s> {
    density: [f32; BLOCKS_MAX],
    /// The same of the amplitude in place of the phase.
    of_amplitude: [f32; BLOCKS_MAX],
    expected: [f32; BLOCKS_MAX],
    /// The derivative of each wave by the frequency, times the channels' weights.
    weighted: [Values; WAVES],
    /// Its products with each unknown.
    products: [[f32; UNKNOWNS_MAX]; WAVES],
    /// Of each harmonic what white noise of unit weight adds to the score's variance; 0 where it is
    /// left out.
    powers: [f32; HARMONICS_MAX],
    /// The harmonic of which the residuals' correlation is taken: it says most of the frequency.
    main: usize,
    lags: [f32; LAGS],
    /// Residuals of the latest two blocks: by channel, and wave.
    latest: [[[f32; LAGS - 1]; 2]; CHANNELS_MAX],
    /// One over the standard deviation of each channel's residuals, and the covariance of these
    /// residuals in that unit.
    roots: Values,
    covariance: &'s mut Covariance,
    is_shared_wanted: bool,
}

/// The neighbourhood of a window's solution; on request also whether channels may share noise.
#[inline(never)]
pub fn neighbourhood(
    blocks: &Blocks,
    solution: &Solution,
    is_shared_wanted: bool,
) -> Neighbourhood {
    let mut covariance = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
    let mut series = Series::new(&mut covariance, is_shared_wanted);
    series.fill(blocks, solution, false);
    series.end(blocks.u.get(..blocks.count).unwrap_or(&blocks.u), solution)
}

/// The covariance of a solution's channels in its neighbourhood, and what it is in units of; the
/// main harmonic.
#[inline(never)]
pub fn covariance(
    blocks: &Blocks,
    solution: &Solution,
    covariance: &mut Covariance,
    roots: &mut Values,
) -> usize {
    *covariance = [[0.0; CHANNELS_MAX]; CHANNELS_MAX];
    let mut series = Series::new(covariance, true);
    series.fill(blocks, solution, true);
    *roots = series.roots;
    series.main
}

impl<'s> Series<'s> {
    #[inline(always)]
    const fn new(covariance: &'s mut Covariance, is_shared_wanted: bool) -> Self {
        Self {
            density: [0.0; BLOCKS_MAX],
            of_amplitude: [0.0; BLOCKS_MAX],
            expected: [0.0; BLOCKS_MAX],
            weighted: [[0.0; CHANNELS_MAX]; WAVES],
            products: [[0.0; UNKNOWNS_MAX]; WAVES],
            powers: [0.0; HARMONICS_MAX],
            main: 0,
            lags: [0.0; LAGS],
            latest: [[[0.0; LAGS - 1]; 2]; CHANNELS_MAX],
            roots: [0.0; CHANNELS_MAX],
            covariance,
            is_shared_wanted,
        }
    }

    /// On request without harmonics beside the main one: a covariance is of that alone.
    #[inline(never)]
    fn fill(&mut self, blocks: &Blocks, solution: &Solution, is_main_alone: bool) {
        self.roots = solution.weights.map(libm::sqrtf);
        self.begin(solution, is_main_alone);
        for b in 0..blocks.count.min(BLOCKS_MAX) {
            self.add(blocks, b, solution);
        }
        for c in 0..CHANNELS_MAX {
            for other in c + 1..CHANNELS_MAX {
                self.covariance[c][other] = self.covariance[other][c];
            }
        }
    }

    #[inline(never)]
    fn begin(&mut self, solution: &Solution, is_main_alone: bool) {
        let information = &solution.line_information;
        let lines = solution.shape.harmonics.min(HARMONICS_MAX);
        let mut most = 0.0;
        for (h, information) in information.iter().enumerate().take(lines) {
            if *information > most {
                (self.main, most) = (h, *information);
            }
        }
        // Harmonics that say little of the frequency are left out.
        let least = INFORMATION_SHARE_MIN * information[self.main % HARMONICS_MAX];
        for wave in 0..2 * lines {
            let h = wave / 2 % HARMONICS_MAX;
            if h != self.main && (is_main_alone || information[h] <= least) {
                continue;
            }
            let (factor, amplitudes) = solution.derivative(wave);
            let weighted = &mut self.weighted[wave % WAVES];
            for (c, (weighted, amplitude)) in weighted
                .iter_mut()
                .zip(amplitudes)
                .enumerate()
                .take(solution.width)
            {
                let derivative = factor * amplitude;
                *weighted = solution.weights[c] * derivative;
                self.powers[h] += *weighted * derivative;
            }
            let products = self.products[wave % WAVES]
                .iter_mut()
                .zip(&solution.unknowns);
            products
                .take(solution.shape.unknowns())
                .for_each(|(product, unknown)| *product = dot(weighted, unknown));
        }
    }

    /// Adds block `b`: the residuals about its lines, turned to the window's centre.
    #[inline(never)]
    fn add(&mut self, blocks: &Blocks, b: usize, solution: &Solution) {
        let (shape, b) = (&solution.shape, b % BLOCKS_MAX);
        let (u, products, waves) = (
            blocks.u[b],
            blocks.products(b),
            blocks.rows[b].as_chunks::<2>().0,
        );
        let (nu, count) = Lines {
            nu: solution.nu,
            ..blocks.lines
        }
        .all(false);
        let mut turns = [(1.0, 0.0); LINES_MAX];
        for (turn, nu) in turns.iter_mut().zip(nu).take(count) {
            *turn = cos_sin(from_turns(nu * u));
        }
        let curves = if shape.curves > 0 {
            curves(u)
        } else {
            [[0.0; 2]; CURVES_MAX]
        };
        let (mut density, mut of_amplitude, mut expected) = (0.0, 0.0, 0.0);
        let powers = self.powers;
        for (h, ((rows, (cos, sin)), power)) in
            waves.iter().skip(1).zip(&turns).zip(&powers).enumerate()
        {
            if !(*power > 0.0) {
                continue;
            }
            // What each unknown contributes to the block's sums with the line's cosine and sine.
            let mut factors = [[0.0; UNKNOWNS_MAX]; 2];
            for (p, factors) in factors.iter_mut().enumerate() {
                let wave = 2 + 2 * h + p;
                let own = |column: usize| products[product(wave.max(column), wave.min(column))];
                (factors[0], factors[1]) = (own(0), u * own(0) + own(1));
                for (line, (cos, sin)) in turns.iter().enumerate().take(count) {
                    let first = match line {
                        _ if line < shape.harmonics => shape.first_wave() + 2 * line,
                        _ if line >= blocks.lines.harmonics && shape.interferer => 2,
                        _ => continue,
                    };
                    let (with_cos, with_sin) = (own(2 + 2 * line), own(3 + 2 * line));
                    if let Some([of_cos, of_sin, ..]) = factors.get_mut(first..) {
                        (*of_cos, *of_sin) = (
                            cos * with_cos - sin * with_sin,
                            sin * with_cos + cos * with_sin,
                        );
                    }
                }
                let of_curves = factors.iter_mut().skip(shape.first_curve()).zip(&curves);
                for (factor, [value, along]) in of_curves.take(shape.curves) {
                    *factor = value * own(0) + along * own(1);
                }
            }
            // Of the derivative by either wave with the rests of both.
            let mut rests = [[0.0; 2]; 2];
            for (p, rests) in rests.iter_mut().enumerate() {
                let weighted = &self.weighted[(2 * h + p) % WAVES];
                *rests = [dot(weighted, &rows[0]), dot(weighted, &rows[1])];
                for (rest, factors) in rests.iter_mut().zip(&factors) {
                    let products = self.products[(2 * h + p) % WAVES]
                        .iter()
                        .zip(factors)
                        .take(shape.unknowns());
                    *rest = products.fold(*rest, |rest, (product, factor)| rest - factor * product);
                }
            }
            let [of_cos, of_sin] = rests;
            let (along, across) = (of_cos[0] + of_sin[1], of_sin[0] - of_cos[1]);
            density += cos * along + sin * across;
            of_amplitude += sin * along - cos * across;
            expected += power;
            if h == self.main {
                // Blocks of fewer frames have as much noise by frame.
                let unit = 1.0 / libm::sqrtf(products[product(0, 0)].max(1.0));
                self.correlate(rows, (unit * cos, unit * sin), &factors, solution);
            }
        }
        self.of_amplitude[b] = of_amplitude;
        // Half the frames for a cosine or a sine.
        (self.density[b], self.expected[b]) = (density, expected * 0.5 * products[product(0, 0)]);
    }

    /// Adds a block to the correlation of the residuals about a line.
    fn correlate(
        &mut self,
        [cosines, sines]: &[Values; 2],
        (cos, sin): (f32, f32),
        [of_cos, of_sin]: &[[f32; UNKNOWNS_MAX]; 2],
        solution: &Solution,
    ) {
        let (mut with_cos, mut with_sin) = (*cosines, *sines);
        let unknowns = solution
            .unknowns
            .get(..solution.shape.unknowns())
            .unwrap_or_default();
        subtract(&mut with_cos, unknowns, of_cos, 1.0, solution.width);
        subtract(&mut with_sin, unknowns, of_sin, 1.0, solution.width);
        let [mut zero_lag, mut one_lag, mut two_lags] = self.lags;
        for (c, latest) in self.latest.iter_mut().enumerate().take(solution.width) {
            let (with_cos, with_sin) = (with_cos[c], with_sin[c]);
            let both = [
                cos * with_cos - sin * with_sin,
                sin * with_cos + cos * with_sin,
            ];
            for (residual, latest) in both.into_iter().zip(latest) {
                let [one, two] = *latest;
                let weighted = solution.weights[c] * residual;
                zero_lag += weighted * residual;
                one_lag += weighted * one;
                two_lags += weighted * two;
                *latest = [residual, one];
            }
        }
        self.lags = [zero_lag, one_lag, two_lags];
        if self.is_shared_wanted {
            self.add_covariance(solution.width);
        }
    }

    /// Adds the latest residuals to the lower triangle of the covariance, four columns at a time.
    #[inline(never)]
    fn add_covariance(&mut self, width: usize) {
        let mut of_unit = [[0.0; CHANNELS_MAX]; 2];
        for (quadrature, of_unit) in of_unit.iter_mut().enumerate() {
            for ((of_unit, root), latest) in of_unit
                .iter_mut()
                .zip(&self.roots)
                .zip(&self.latest)
                .take(width)
            {
                *of_unit = root * latest[quadrature][0];
            }
        }
        let [cosines, sines] = of_unit.each_ref().map(|of_unit| of_unit.as_chunks::<4>().0);
        for (c, row) in self.covariance.iter_mut().enumerate().take(width) {
            let (with_cos, with_sin) = (of_unit[0][c % CHANNELS_MAX], of_unit[1][c % CHANNELS_MAX]);
            let fours = row
                .as_chunks_mut::<4>()
                .0
                .iter_mut()
                .zip(cosines)
                .zip(sines);
            for ((sums, cosines), sines) in fours.take(c / 4 + 1) {
                for ((sum, cos), sin) in sums.iter_mut().zip(cosines).zip(sines) {
                    *sum = *sum + with_cos * cos + with_sin * sin;
                }
            }
        }
    }

    fn end(&mut self, u: &[f32], solution: &Solution) -> Neighbourhood {
        let blocks = u.len() as f32;
        let unknowns = solution.shape.unknowns() as f32;
        let freedom = solution.frames / (solution.frames - unknowns).max(1.0);
        let all = self.expected.iter().sum::<f32>().max(f32::MIN_POSITIVE);
        let (mut slow, mut share) = (0.0, 0.0);
        for cycles in 1..=SLOW_CYCLES {
            let cycles = cycles as f32;
            if 2.0 * cycles > blocks - 2.0 {
                break;
            }
            let [mut cos, mut sin] = [[0.0; BLOCKS_MAX]; 2];
            for ((cos, sin), u) in cos.iter_mut().zip(&mut sin).zip(u) {
                (*cos, *sin) = cos_sin(from_turns(0.5 * cycles * u));
            }
            let [(with_cos, of_cos), (with_sin, of_sin)] =
                [self.product(&cos, u), self.product(&sin, u)];
            slow += with_cos * with_cos + with_sin * with_sin;
            share += of_cos + of_sin;
        }
        let Colour {
            density: colour,
            band,
            residual,
        } = Colour::new(&self.lags, self.main, solution, u);
        let squares = self
            .density
            .iter()
            .map(|density| density * density)
            .sum::<f32>();
        let both = self.of_amplitude.iter().zip(&self.expected).take(u.len());
        let of_amplitude =
            both.map(|(density, expected)| density * density / expected.max(f32::MIN_POSITIVE));
        let of_amplitude = of_amplitude.sum::<f32>() / (blocks - 1.0).max(1.0);
        let phase = self.degrees(u);
        Neighbourhood {
            may_share: self.is_shared_wanted && may_share(self.covariance, solution),
            slow_power: freedom * slow / share.max(f32::MIN_POSITIVE),
            coherence: squares / (all * residual).max(f32::MIN_POSITIVE) * blocks
                / (blocks - 2.0).max(1.0),
            colour,
            band,
            phase,
            of_amplitude,
        }
    }

    /// The phase's deviation, a degree after the other: what one describes is taken out of the
    /// density. A line is not in it.
    #[inline(never)]
    fn degrees(&mut self, u: &[f32]) -> [[f32; 2]; PHASE_DEGREES] {
        let mut out = [[0.0; 2]; PHASE_DEGREES];
        let (mut before, mut last) = ([1.0; BLOCKS_MAX], [0.0; BLOCKS_MAX]);
        last.iter_mut().zip(u).for_each(|(last, u)| *last = *u);
        for (degree, out) in (1u8..).zip(&mut out).take(u.len().saturating_sub(3)) {
            // Bonnet's recursion.
            let (of_last, of_before) = (
                2.0 - 1.0 / f32::from(degree + 1),
                1.0 - 1.0 / f32::from(degree + 1),
            );
            let (mut with, mut variance) = (0.0, f32::MIN_POSITIVE);
            let places = before.iter_mut().zip(&mut last).zip(u);
            for (((before, last), u), (density, expected)) in
                places.zip(self.density.iter().zip(&self.expected))
            {
                (*before, *last) = (*last, of_last * u * *last - of_before * *before);
                (with, variance) = (with + density * *last, variance + expected * *last * *last);
            }
            *out = [with / variance, 1.0 / variance];
            for ((density, expected), last) in
                self.density.iter_mut().zip(&self.expected).zip(&last)
            {
                *density -= out[0] * expected * last;
            }
        }
        out
    }

    /// The density's product with a function, and its variance in white noise. Frequency and phase
    /// are fitted: the density's sum is zero, and its product with `u`, and of a function only what
    /// a line does not describe counts.
    #[inline(never)]
    fn product(&self, function: &[f32; BLOCKS_MAX], u: &[f32]) -> (f32, f32) {
        let (mut n, mut x, mut xx, mut y, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for ((f, e), u) in function.iter().zip(&self.expected).zip(u) {
            (n, x, xx, y, xy) = (n + e, x + e * u, xx + e * u * u, y + e * f, xy + e * u * f);
        }
        let spread = (n * xx - x * x).max(f32::MIN_POSITIVE);
        let (slope, level) = ((n * xy - x * y) / spread, (xx * y - x * xy) / spread);
        let (mut with, mut variance) = (0.0, 0.0);
        for (((f, e), g), u) in function
            .iter()
            .zip(&self.expected)
            .zip(&self.density)
            .zip(u)
        {
            let rest = f - level - slope * u;
            (with, variance) = (with + g * rest, variance + e * rest * rest);
        }
        (with, variance)
    }
}
