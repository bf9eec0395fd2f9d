//! What the channels share: disturbances that reach all of them, each with a gain of its own.
//!
//! Such a disturbance lives in one mixture of channels, or in two if its phases differ. Least
//! squares that takes channels as independent has all of it in its error. Mixtures at right angles
//! to it are free of it. So the blocks' channels are turned into mixtures that are independent and
//! of equal noise (whitened), by the covariance of the residuals next to the main line, and the
//! last steps are taken from there. Source: S. M. Kay, "Fundamentals of Statistical Signal
//! Processing: Estimation Theory" (1993), section 4.5.

use crate::blocks::Blocks;
use crate::covariance::{Covariance, SHARED_MIN};
use crate::limits::CHANNELS_MAX;
use crate::neighbourhood::covariance;
use crate::normal::channels_dot;
use crate::solve::{Equations, Shape, Solution};
use crate::source::Values;
use core::ops::Range;

/// Most directions that are shared: cosine and sine of a disturbance.
const DIRECTIONS: usize = 4;
/// Share of a direction's square that lies along the tone from which on it is the tone's own
/// movement.
const OWN_SHARE: f32 = 0.9;
/// Least power of a channel's own, over the mean of all channels'.
const OWN_MIN: f32 = 0.5;
/// Blocks' worth of residuals that the solution has taken, and what they lack as few as they are:
/// chosen so that intervals hold on other seeds than those of docs/results/noise.md. Each direction takes
/// one more.
const BLOCKS_TAKEN: f32 = 6.0;
/// Rounds in which shared and own power are parted.
const ROUNDS: usize = 2;
/// Most of a direction's square that one channel may bear: more is its own noise, which its weight
/// knows.
const ONE_CHANNEL: f32 = 0.7;
/// Turns of the power iteration.
const TURNS: usize = 8;
/// Most steps in a whitened window; from one to the next, standard deviations; and all together,
/// `nu`.
const STEPS: usize = 6;
const SIGMAS: f32 = 0.05;
/// Slopes of the steps by the frequency, with the sign reversed, that are a secant's; 1 where the
/// steps converge at once.
const SLOPES: Range<f32> = 0.25..3.0;
const MOVE_MAX: f32 = 0.25;

/// How channels are turned into independent ones.
#[derive(Clone, Copy, Debug)]
pub struct Mixture {
    /// Of each channel, one over the standard deviation of a mixture.
    factors: Values,
    /// Directions of unit length that are taken out; zeros are none.
    directions: [Values; DIRECTIONS],
}

impl Mixture {
    /// Of a covariance that adds up `blocks` blocks, of residuals in units of one over `roots`.
    /// None if channels share nothing.
    #[inline(never)]
    pub fn new(
        covariance: &Covariance,
        roots: &Values,
        solution: &Solution,
        main: usize,
        blocks: f32,
    ) -> Option<Self> {
        let width = solution.width.min(CHANNELS_MAX);
        let (cos, sin) = solution.harmonic(main);
        let mut out = Self {
            factors: *roots,
            directions: [[0.0; CHANNELS_MAX]; DIRECTIONS],
        };
        let (mut own, mut of_one) = ([1.0; CHANNELS_MAX], 0.0);
        // What is a channel's own shows once the shared part is known.
        for _ in 0..ROUNDS {
            let (mut units, mut of_tone) = ([0.0; CHANNELS_MAX], [[0.0; CHANNELS_MAX]; 2]);
            for (c, factor) in out.factors.iter_mut().enumerate().take(width) {
                *factor /= libm::sqrtf(own[c]);
                units[c] = if roots[c] > 0.0 {
                    *factor / roots[c]
                } else {
                    0.0
                };
                (of_tone[0][c], of_tone[1][c]) = (cos[c] * *factor, sin[c] * *factor);
            }
            let mut left = *covariance;
            for (row, unit) in left.iter_mut().zip(&units) {
                row.iter_mut()
                    .zip(&units)
                    .for_each(|(value, other)| *value *= unit * other);
            }
            at_right_angles(&mut of_tone);
            of_one = directions(&mut left, &of_tone, width, &mut out.directions);
            for (c, own) in own.iter_mut().enumerate().take(width) {
                // Its own noise has a part in the shared directions too.
                let within: f32 = out
                    .directions
                    .iter()
                    .map(|direction| direction[c] * direction[c])
                    .sum();
                *own = (left[c][c] / of_one + within).max(OWN_MIN);
            }
        }
        let count = out
            .directions
            .iter()
            .filter(|direction| direction.iter().any(|value| *value != 0.0))
            .count();
        let freedom = (blocks - BLOCKS_TAKEN - count as f32).max(1.0);
        let scale = libm::sqrtf(
            freedom * (1.0 - solution.shape.unknowns() as f32 / solution.frames) / of_one,
        );
        out.factors.iter_mut().for_each(|factor| *factor *= scale);
        (count > 0 && scale.is_finite()).then_some(out)
    }

    /// Turns rows of channels into rows of mixtures.
    pub fn apply(&self, rows: &mut [Values]) {
        for row in rows {
            row.iter_mut()
                .zip(&self.factors)
                .for_each(|(value, factor)| *value *= factor);
            for direction in &self.directions {
                let along = channels_dot(row, direction);
                add(row, direction, -along);
            }
        }
    }
}

/// Takes the steps that are left from `start` with the noise that the channels share taken out.
/// Leaves that solution, and the blocks with mixtures in the channels' place. False if there is
/// none that is shared, or if the steps lead away.
#[inline(never)]
pub fn whiten(
    blocks: &mut Blocks,
    equations: &mut Equations,
    least: &Values,
    start: f32,
    shape: Shape,
) -> bool {
    // Harmonics that noise has hidden may show.
    let shape = Shape {
        harmonics: blocks.lines.harmonics,
        ..shape
    };
    // Of each mixture the noise is known: its residuals are as many as its degrees of freedom.
    let known = [equations.frames - shape.unknowns() as f32; CHANNELS_MAX];
    let (mut shared, mut roots) = ([[0.0; CHANNELS_MAX]; CHANNELS_MAX], [0.0; CHANNELS_MAX]);
    let (mut nu, mut last) = (start, None);
    for step in 1..=STEPS {
        // Residuals of a frequency that noise has moved look as if the noise had a part of the
        // tone: they are taken anew.
        equations.collect(blocks, nu, shape.curves > 0);
        if equations.solve(shape, least).is_none() {
            return false;
        }
        let main = covariance(blocks, &equations.solution, &mut shared, &mut roots);
        let mixture = Mixture::new(
            &shared,
            &roots,
            &equations.solution,
            main,
            blocks.count as f32,
        );
        // By reference: a copy would lie on the stack beside it.
        let Some(mixture) = &mixture else {
            return false;
        };
        equations.mix(|rows| mixture.apply(rows));
        if equations.solve(shape, &known).is_none() {
            return false;
        }
        let solution = &mut equations.solution;
        // What is shared follows the frequency, so that each step takes back only a part of the one
        // before: the secant leads further.
        let slope = last.map_or(1.0, |(at, step): (f32, f32)| {
            (step - solution.step) / (nu - at)
        });
        let change = solution.step / if SLOPES.contains(&slope) { slope } else { 1.0 };
        last = Some((nu, solution.step));
        nu += change;
        solution.nu = nu;
        if !((nu - start).abs() < MOVE_MAX) {
            return false;
        }
        if step == STEPS || change * change * solution.information < SIGMAS * SIGMAS {
            blocks
                .rows
                .iter_mut()
                .take(blocks.count)
                .for_each(|rows| mixture.apply(rows));
            return true;
        }
    }
    false
}

/// Finds directions that are shared and not the tone's, takes all that are shared out of the
/// covariance, and gives the mean power in the others.
#[inline(never)]
fn directions(
    covariance: &mut Covariance,
    of_tone: &[Values; 2],
    width: usize,
    found: &mut [Values; DIRECTIONS],
) -> f32 {
    *found = [[0.0; CHANNELS_MAX]; DIRECTIONS];
    let mut trace = covariance
        .iter()
        .enumerate()
        .map(|(c, row)| row[c % CHANNELS_MAX])
        .sum::<f32>();
    let mut left = width as f32;
    for found in found.as_chunks_mut::<2>().0 {
        let (plane, powers) = strongest(covariance);
        for ((found, direction), power) in found.iter_mut().zip(plane).zip(powers) {
            if !(power * (left - 1.0) > SHARED_MIN * (trace - power)) {
                return trace / left;
            }
            (left, trace) = (left - 1.0, trace - power);
            if take_out(covariance, &direction, power, of_tone) {
                *found = direction;
            }
        }
    }
    trace / left
}

/// Takes the power of a direction out of a covariance. Whether it is neither the tone's nor a
/// single channel's.
#[inline(never)]
fn take_out(
    covariance: &mut Covariance,
    direction: &Values,
    power: f32,
    of_tone: &[Values; 2],
) -> bool {
    for (row, along) in covariance.iter_mut().zip(direction) {
        add(row, direction, -power * along);
    }
    let own: f32 = of_tone
        .iter()
        .map(|wave| channels_dot(wave, direction))
        .map(|along| along * along)
        .sum();
    own < OWN_SHARE && !direction.iter().any(|value| value * value > ONE_CHANNEL)
}

/// The two directions of most power of a covariance, the stronger first, and their power.
#[inline(never)]
fn strongest(covariance: &Covariance) -> ([Values; 2], [f32; 2]) {
    let mut plane = [covariance[0], covariance[CHANNELS_MAX / 2]];
    for _ in 0..TURNS {
        at_right_angles(&mut plane);
        plane = [times(covariance, &plane[0]), times(covariance, &plane[1])];
    }
    at_right_angles(&mut plane);
    let with = [times(covariance, &plane[0]), times(covariance, &plane[1])];
    let [one, two, both] = [
        channels_dot(&plane[0], &with[0]),
        channels_dot(&plane[1], &with[1]),
        channels_dot(&plane[0], &with[1]),
    ];
    // Turned within their plane to where they share nothing.
    let (sum, apart) = (0.5 * (one + two), 0.5 * (one - two));
    let span = libm::sqrtf(apart * apart + both * both);
    let cos = libm::sqrtf((0.5 + 0.5 * apart / span.max(f32::MIN_POSITIVE)).max(0.0));
    let sin = libm::sqrtf((1.0 - cos * cos).max(0.0)) * if both < 0.0 { -1.0 } else { 1.0 };
    let mut turned = [[0.0; CHANNELS_MAX]; 2];
    for (turned, (of_first, of_second)) in turned.iter_mut().zip([(cos, sin), (-sin, cos)]) {
        add(turned, &plane[0], of_first);
        add(turned, &plane[1], of_second);
    }
    (turned, [sum + span, sum - span])
}

/// Makes two vectors such of unit length, at right angles to each other, in the same plane.
#[inline(never)]
fn at_right_angles(plane: &mut [Values; 2]) {
    let along = channels_dot(&plane[0], &plane[1])
        / channels_dot(&plane[0], &plane[0]).max(f32::MIN_POSITIVE);
    let first = plane[0];
    add(&mut plane[1], &first, -along);
    for vector in plane {
        let length = libm::sqrtf(channels_dot(vector, vector)).max(f32::MIN_POSITIVE);
        vector.iter_mut().for_each(|value| *value /= length);
    }
}

#[inline(never)]
fn times(covariance: &Covariance, direction: &Values) -> Values {
    let mut out = [0.0; CHANNELS_MAX];
    out.iter_mut()
        .zip(covariance)
        .for_each(|(out, row)| *out = channels_dot(row, direction));
    out
}

/// Adds a multiple of a vector to another.
#[inline(never)]
fn add(to: &mut Values, of: &Values, factor: f32) {
    to.iter_mut()
        .zip(of)
        .for_each(|(to, of)| *to += factor * of);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::covariance::may_share;
    use crate::normal::dot;

    const BLOCKS: f32 = 16.0;

    /// A disturbance of so much power along a direction of gains, over noise of each channel's own.
    fn covariance(gains: &Values, power: f32, own: impl Fn(usize) -> f32) -> Covariance {
        core::array::from_fn(|c| {
            core::array::from_fn(|d| {
                BLOCKS * (power * gains[c] * gains[d] + if c == d { own(c) } else { 0.0 })
            })
        })
    }

    fn gains() -> Values {
        core::array::from_fn(|c| 0.5 + 0.0625 * c as f32)
    }

    /// A tone whose cosines are `cos`, and whose sines alternate.
    fn solution(cos: &Values) -> Solution {
        let mut solution = Solution {
            width: CHANNELS_MAX,
            frames: 240.0,
            nu: 3.0,
            ..Solution::NONE
        };
        solution.shape = Shape {
            harmonics: 1,
            ..Shape::default()
        };
        solution.unknowns[2] = *cos;
        solution.unknowns[3] = core::array::from_fn(|c| if c % 2 == 0 { 1.0 } else { -1.0 });
        solution
    }

    fn mixture(covariance: &Covariance, cos: &Values) -> Option<Mixture> {
        Mixture::new(covariance, &[1.0; CHANNELS_MAX], &solution(cos), 0, BLOCKS)
    }

    const SWINGS: Values = {
        let mut swings = [1.0; CHANNELS_MAX];
        let mut c = 0;
        while c < CHANNELS_MAX {
            if c / 2 % 2 == 0 {
                swings[c] = -1.0;
            }
            c += 1;
        }
        swings
    };

    /// Generalized least squares weighs with the inverse of the covariance. What is left of it is
    /// that inverse without the shared direction, but for the factor of the few blocks.
    #[test]
    fn mixtures_have_equal_noise_and_nothing_of_what_is_shared() {
        for own in [|_| 1.0, |c: usize| if c < 8 { 0.7 } else { 1.4 }] {
            let covariance = covariance(&gains(), 100.0, own);
            let mixture = mixture(&covariance, &SWINGS).expect("it is shared");
            let mut shared = [gains()];
            mixture.apply(&mut shared);
            assert!(
                dot(&shared[0], &shared[0]) < 1e-3 * dot(&gains(), &gains()),
                "{shared:?}"
            );
            // The noise of channel c in all mixtures, and of all channels in one.
            let mut turned: Covariance = core::array::from_fn(|c| {
                core::array::from_fn(|d| if c == d { libm::sqrtf(own(c)) } else { 0.0 })
            });
            mixture.apply(&mut turned);
            let powers: Values =
                core::array::from_fn(|d| turned.iter().map(|row| row[d] * row[d]).sum());
            let mean = powers.iter().sum::<f32>() / 15.0;
            assert!(
                powers
                    .iter()
                    .all(|power| (0.7..1.2).contains(&(power / mean))),
                "{powers:?}"
            );
        }
    }

    #[test]
    fn what_is_the_tones_own_or_one_channels_is_left() {
        let of_tone = covariance(&SWINGS, 100.0, |_| 1.0);
        assert!(mixture(&of_tone, &SWINGS).is_none());
        let of_one: Values = core::array::from_fn(|c| if c == 3 { 4.0 } else { 0.1 });
        assert!(mixture(&covariance(&of_one, 100.0, |_| 1.0), &SWINGS).is_none());
    }

    #[test]
    fn independent_noise_shares_nothing() {
        let independent = covariance(&gains(), 0.0, |c| 1.0 + 0.1 * c as f32);
        assert!(!may_share(&independent, &solution(&SWINGS)));
        assert!(mixture(&independent, &SWINGS).is_none());
        let shared = covariance(&gains(), 100.0, |_| 1.0);
        assert!(may_share(&shared, &solution(&SWINGS)));
        let few_cycles = Solution {
            nu: 0.7,
            ..solution(&SWINGS)
        };
        let few_frames = Solution {
            frames: 39.0,
            ..solution(&SWINGS)
        };
        let two_channels = Solution {
            width: 2,
            ..solution(&SWINGS)
        };
        for solution in [few_cycles, few_frames, two_channels] {
            assert!(!may_share(&shared, &solution), "{solution:?}");
        }
    }

    /// Of a covariance of two directions of known power.
    #[test]
    fn the_strongest_directions_are_the_eigenvectors() {
        let alternating = solution(&SWINGS).unknowns[3];
        let mut both = covariance(&alternating, 3.0, |_| 0.5);
        for (row, one) in both.iter_mut().zip(&SWINGS) {
            add(row, &SWINGS, 2.0 * BLOCKS * one);
        }
        let (plane, powers) = strongest(&both);
        for (power, expected) in powers.iter().zip([48.5, 32.5]) {
            assert!(
                (power / (BLOCKS * expected) - 1.0).abs() < 1e-3,
                "{powers:?}"
            );
        }
        assert!(
            (dot(&plane[0], &alternating) / 4.0).abs() > 0.999,
            "{plane:?}"
        );
        assert!((dot(&plane[1], &SWINGS) / 4.0).abs() > 0.999, "{plane:?}");
    }
}
