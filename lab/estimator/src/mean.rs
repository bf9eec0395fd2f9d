//! The mean frequency over the window and its uncertainty: an average over a phase that is steady
//! and over three kinds of walk of all strengths, each by its evidence.
//!
//! Walks are white noise that is integrated once, twice or three times, written in Legendre
//! polynomials, in which integrating is tridiagonal.

use crate::limits::DEGREES_MAX;
use crate::matrix::{Factor, Square};

/// Degrees that a walk is followed to.
const DEGREES_WALK: usize = 47;
/// Kinds of walk.
const WALKS: usize = 3;
/// Strengths of a walk, each twice the one before, from half the noise of the second degree on.
const STRENGTHS: usize = 20;
/// Largest second degree of a walk, radians.
const WALK_MAX: f32 = 8.0;

/// What is known of a phase, by degree from 1 on.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// Its coefficients, radians.
    pub phase: [f32; DEGREES_MAX],
    /// Their covariance.
    pub covariance: Square<DEGREES_MAX>,
    /// How many there are.
    pub count: usize,
    /// Degrees of freedom of the noise.
    pub freedom: f32,
    /// Prior probability that the phase does not move.
    pub steady: f32,
}

/// What the phase gains over the window, half of it, in radians.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeanPhase {
    /// Its mean.
    pub mean: f32,
    /// Its variance, with what is not fitted.
    pub variance: f32,
    /// Mean square of the phase that is not followed.
    pub unfollowed: f32,
    /// Probability that the phase does not move.
    pub steady: f32,
}

/// A walk's coefficient of degree `k`, by the white noise's of degrees k - order, k - order + 2...
fn row(order: usize, k: usize) -> [f32; WALKS + 1] {
    // From the white noise of the degrees around k up to the walk of degree k.
    let mut rows = [[0.0; WALKS + 1]; 2 * WALKS + 1];
    for (i, row) in rows.iter_mut().enumerate().take(2 * order + 1).step_by(2) {
        row[0] = match (k + i).checked_sub(order) {
            Some(degree) => libm::sqrtf(degree as f32 + 0.5),
            None => 0.0,
        };
    }
    for level in 1..=order {
        for i in (level..=2 * order - level).step_by(2) {
            // In the place of a degree are the walks of one order less beside it.
            let (below, above) = (rows[i - 1], rows[i + 1]);
            let degree = (k + i) as f32 - order as f32;
            let mut row = [0.0; WALKS + 1];
            for j in 0..=level {
                if j < level {
                    row[j] += below[j] / (2.0 * degree - 1.0);
                }
                if j > 0 {
                    row[j] -= above[j - 1] / (2.0 * degree + 3.0);
                }
            }
            rows[i] = if degree > 0.0 { row } else { [0.0; WALKS + 1] };
        }
    }
    rows[order]
}

/// Twice the sum of all odd degrees above `n`: what they add to the ends; as a row of the returned
/// degree.
fn ends(order: usize, n: usize) -> (usize, [f32; WALKS + 1]) {
    let k = if n.is_multiple_of(2) { n + 1 } else { n + 2 };
    (k, row(order - 1, k - 1).map(|x| x / (2 * k - 1) as f32))
}

/// Covariance of a walk whose second degree has variance 1: of degrees 2 to n, and of the ends.
struct Walk {
    covariance: Square<DEGREES_MAX>,
    /// Mean square of the degrees above n.
    tail: f32,
}

impl Walk {
    fn new(order: usize, n: usize) -> Self {
        let at = |i: usize| {
            if i + 1 == n {
                ends(order, n)
            } else {
                (i + 2, row(order, i + 2))
            }
        };
        let second = row(order, 2);
        let scale = 1.0 / second.iter().map(|x| x * x).sum::<f32>();
        let mut covariance = [[0.0; DEGREES_MAX]; DEGREES_MAX];
        for i in 0..n {
            let (k, one) = at(i);
            for j in 0..n {
                let (l, other) = at(j);
                if k.abs_diff(l) % 2 != 0 {
                    continue;
                }
                for (a, x) in one.iter().enumerate() {
                    let b = a as isize + (k as isize - l as isize) / 2;
                    let y = usize::try_from(b).ok().and_then(|b| other.get(b));
                    covariance[i][j] += scale * x * y.unwrap_or(&0.0);
                }
            }
        }
        let square = |k: usize| row(order, k).iter().map(|x| x * x).sum::<f32>();
        let tail = (n + 1..=DEGREES_WALK).map(|k| square(k) / (2 * k + 1) as f32);
        Self {
            covariance,
            tail: scale * tail.sum::<f32>(),
        }
    }
}

/// One model's answer.
#[derive(Clone, Copy, Default)]
struct Answer {
    log_weight: f32,
    mean: f32,
    variance: f32,
    unfollowed: f32,
}

impl Evidence {
    /// The answer of a walk of variance `variance`, whose prior is `prior`.
    fn answer(&self, walk: Option<&Walk>, variance: f32, prior: f32) -> Answer {
        let n = self.count;
        let moved = |i: usize, j: usize| walk.map_or(0.0, |walk| variance * walk.covariance[i][j]);
        // What counts for the mean: odd degrees, and the ends.
        let counts = |i: usize| if i + 1 == n || i % 2 == 1 { 1.0 } else { 0.0 };
        let mut matrix = [[0.0; DEGREES_MAX]; DEGREES_MAX];
        let (mut z, mut q) = ([0.0; DEGREES_MAX], [0.0; DEGREES_MAX]);
        let mut all = 0.0;
        for i in 0..n {
            let row: f32 = (0..n).map(|j| moved(i, j) * counts(j)).sum();
            all += counts(i) * row;
            if i + 1 < n {
                for j in 0..n - 1 {
                    matrix[i][j] = self.covariance[i + 1][j + 1] + moved(i, j);
                }
                z[i] = self.phase[i + 1];
                q[i] = row - self.covariance[0][i + 1];
            }
        }
        let factor = Factor::new(&mut matrix, n - 1);
        factor.forward(&mut z);
        factor.forward(&mut q);
        let square: f32 = z.iter().map(|z| z * z).sum();
        let both: f32 = z.iter().zip(&q).map(|(z, q)| z * q).sum();
        let known: f32 = q.iter().map(|q| q * q).sum();
        let unlikely = 0.5 * (self.freedom + n as f32) * libm::log1pf(square / self.freedom);
        Answer {
            log_weight: libm::logf(prior) - 0.5 * factor.log_det() - unlikely,
            mean: self.phase[0] + both,
            variance: (self.covariance[0][0] + all - known).max(0.0),
            unfollowed: walk.map_or(0.0, |walk| variance * walk.tail),
        }
    }

    /// The average over all models.
    #[inline(never)]
    pub fn mean_phase(&self) -> MeanPhase {
        let least = 0.5 * libm::sqrtf(self.covariance[1][1]);
        let mut answers = [Answer::default(); 1 + WALKS * (STRENGTHS + 1)];
        answers[0] = self.answer(None, 0.0, self.steady);
        let strengths = (0..=STRENGTHS)
            .map(|j| least * (1u32 << j) as f32)
            .take_while(|strength| *strength < WALK_MAX)
            .count()
            .max(1);
        let prior = (1.0 - self.steady) / (WALKS * strengths) as f32;
        let mut count = 1;
        for order in 1..=WALKS {
            let walk = Walk::new(order, self.count);
            for j in 0..strengths {
                let strength = least * (1u32 << j) as f32;
                answers[count] = self.answer(Some(&walk), strength * strength, prior);
                count += 1;
            }
        }
        let answers = &answers[..count];
        let best = answers
            .iter()
            .map(|one| one.log_weight)
            .fold(f32::NEG_INFINITY, f32::max);
        let weight = |one: &Answer| libm::expf(one.log_weight - best);
        let sum: f32 = answers.iter().map(weight).sum();
        let average = |of: &dyn Fn(&Answer) -> f32| {
            answers.iter().map(|one| weight(one) * of(one)).sum::<f32>() / sum
        };
        let mean = average(&|one| one.mean);
        MeanPhase {
            mean,
            variance: average(&|one| one.variance + (one.mean - mean) * (one.mean - mean)),
            unfollowed: average(&|one| one.unfollowed),
            steady: weight(&answers[0]) / sum,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evidence(second: f32) -> Evidence {
        let mut covariance = [[0.0; DEGREES_MAX]; DEGREES_MAX];
        for (k, row) in covariance.iter_mut().enumerate() {
            row[k] = 1e-4 * (2 * k + 3) as f32;
        }
        let mut phase = [0.0; DEGREES_MAX];
        phase[0] = 0.01;
        phase[1] = second;
        Evidence {
            phase,
            covariance,
            count: 4,
            freedom: 200.0,
            steady: 0.95,
        }
    }

    #[test]
    fn a_steady_phase_pays_little_and_a_moving_one_what_is_not_seen() {
        let steady = evidence(0.0).mean_phase();
        assert!(steady.steady > 0.95, "{steady:?}");
        assert!((steady.mean - 0.01).abs() < 1e-3, "{steady:?}");
        assert!((1.0..1.2).contains(&(steady.variance / 3e-4)), "{steady:?}");
        let moving = evidence(1.0).mean_phase();
        assert!(
            moving.steady < 1e-3 && moving.variance > 2.0 * steady.variance,
            "{moving:?}"
        );
    }

    /// A phase that is white noise integrated once has the covariance of Brownian motion: its gain
    /// over the window has twice the variance of what the noise has at each end.
    #[test]
    fn degrees_of_a_walk_add_up_to_its_ends() {
        for order in 1..=WALKS {
            let n = 5;
            let (k, ends) = ends(order, n);
            let mut sum = [0.0f32; 64];
            for degree in (k..40).step_by(2) {
                for (i, x) in row(order, degree).iter().enumerate() {
                    sum[degree + 2 * i - order] += x;
                }
            }
            for (i, x) in ends.iter().enumerate().take(order) {
                assert!((sum[k + 2 * i - order] - x).abs() < 1e-5, "{order} {i}");
            }
        }
    }
}
