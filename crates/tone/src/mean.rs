//! Mean frequency over the window and its uncertainty: an average over models (a steady phase, and
//! three kinds of random walk of various strengths), each weighted by its evidence.
//!
//! A walk is white noise integrated once, twice or three times. Both are expanded in Legendre
//! polynomials, for which integration is a tridiagonal matrix.

use crate::limits::DEGREES_MAX;
use crate::matrix::{Factor, Square};
use crate::normal::MOVEMENT_MAX;

/// Highest degree in the sums over the tail of a walk.
const DEGREES_WALK: usize = 47;
const WALKS: usize = 3;
/// Maximum number of times a walk's strength is doubled, starting from half the sigma of the second
/// degree.
const STRENGTHS: usize = 20;
/// Maximum strength of a random walk: the standard deviation of its second-degree Legendre
/// coefficient, radians.
const WALK_MAX: f32 = 8.0;

/// Estimated phase, by degree from 1 on.
#[derive(Clone, Debug)]
pub struct Evidence<'e> {
    /// Coefficients, radians.
    pub phase: [f32; DEGREES_MAX],
    /// Covariance of the coefficients, up to `scale`.
    pub covariance: &'e Square<MOVEMENT_MAX>,
    pub scale: f32,
    pub count: usize,
    /// Degrees of freedom of the noise.
    pub freedom: f32,
    /// Prior probability of a steady phase.
    pub steady: f32,
}

/// Half of the phase gained over the window relative to the trajectory, radians.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeanPhase {
    pub mean: f32,
    /// Variance, including the degrees that are not fitted.
    pub variance: f32,
    /// Mean square of the phase beyond the fitted degrees.
    pub unfollowed: f32,
    /// Posterior probability of a steady phase.
    pub steady: f32,
}

/// Weights of the white noise of degrees k - order, k - order + 2... that make up degree k of a
/// walk. Degree j of white noise has the variance j + 1/2.
type Row = [f32; WALKS + 1];

const fn row(order: usize, k: isize) -> Row {
    let mut row = [0.0; WALKS + 1];
    if order == 0 {
        row[0] = if k < 0 { 0.0 } else { 1.0 };
    } else if k > 0 {
        // Integration maps a polynomial to the degrees just below and above.
        let (below, above) = (self::row(order - 1, k - 1), self::row(order - 1, k + 1));
        let mut a = 0;
        while a <= order {
            if a < order {
                row[a] += below[a] / (2 * k - 1) as f32;
            }
            if a > 0 {
                row[a] -= above[a - 1] / (2 * k + 3) as f32;
            }
            a += 1;
        }
    }
    row
}

/// Variance of a walk's coefficient of degree k.
const fn square(order: usize, k: isize) -> f32 {
    let (row, mut sum, mut a) = (row(order, k), 0.0, 0);
    while a <= order {
        sum += row[a] * row[a] * ((k - order as isize + 2 * a as isize) as f32 + 0.5);
        a += 1;
    }
    sum
}

/// Rows of all walks, white noise included.
const ROWS: [[Row; DEGREES_MAX + 3]; WALKS + 1] = {
    let mut rows = [[[0.0; WALKS + 1]; DEGREES_MAX + 3]; WALKS + 1];
    let mut order = 0;
    while order <= WALKS {
        let mut k = 0;
        while k < DEGREES_MAX + 3 {
            rows[order][k] = row(order, k as isize);
            k += 1;
        }
        order += 1;
    }
    rows
};

/// Mean square of a walk beyond each degree, for a variance of 1 of the second degree.
const TAILS: [[f32; DEGREES_MAX + 1]; WALKS + 1] = {
    let mut tails = [[0.0; DEGREES_MAX + 1]; WALKS + 1];
    let mut order = 1;
    while order <= WALKS {
        let (mut sum, mut k) = (0.0, DEGREES_WALK);
        while k > 0 {
            if k <= DEGREES_MAX {
                tails[order][k] = sum / square(order, 2);
            }
            sum += square(order, k as isize) / (2 * k + 1) as f32;
            k -= 1;
        }
        order += 1;
    }
    tails
};

/// Entry of a table; zero outside the table.
fn entry<T: Copy + Default, const N: usize>(table: &[[T; N]], row: usize, column: usize) -> T {
    let entry = table.get(row).and_then(|row| row.get(column));
    entry.copied().unwrap_or_default()
}

/// Returns the sum of all odd degrees above `n`, as a degree and a row: half the phase that they
/// add from end to end of the window.
fn ends(order: usize, n: usize) -> (usize, Row) {
    let k = if n.is_multiple_of(2) { n + 1 } else { n + 2 };
    let factor = 1.0 / (2 * k - 1) as f32;
    (k, entry(&ROWS, order - 1, k - 1).map(|x| x * factor))
}

/// True if entry `i` contributes to the mean: an odd degree (entry 0 is degree 2), or the last
/// entry, that of [`ends`].
fn counts(i: usize, n: usize) -> bool {
    i + 1 == n || i % 2 == 1
}

/// Covariance of a walk whose second degree has variance 1: of degrees 2 to n, then of [`ends`].
struct Walk {
    covariance: Square<DEGREES_MAX>,
    /// Covariance of each entry with the mean.
    mean: [f32; DEGREES_MAX],
    variance: f32,
    /// Mean square of the degrees above n.
    tail: f32,
}

impl Walk {
    const NONE: Self = Self {
        covariance: [[0.0; DEGREES_MAX]; DEGREES_MAX],
        mean: [0.0; DEGREES_MAX],
        variance: 0.0,
        tail: 0.0,
    };

    fn new(order: usize, n: usize) -> Self {
        let at = |i: usize| {
            if i + 1 == n {
                ends(order, n)
            } else {
                (i + 2, entry(&ROWS, order, i + 2))
            }
        };
        let scale = 1.0 / square(order, 2);
        let mut walk = Self {
            tail: entry(&TAILS, order, n),
            ..Self::NONE
        };
        for i in 0..n.min(DEGREES_MAX) {
            let (k, one) = at(i);
            for j in 0..=i {
                let (l, other) = at(j);
                // Offset between the rows, whose entries are two degrees apart.
                let shift = k.abs_diff(l) / 2;
                if k.abs_diff(l) % 2 != 0 || shift > order {
                    continue;
                }
                let (high, low, first) = if k >= l {
                    (&one, &other, k)
                } else {
                    (&other, &one, l)
                };
                let degree = |a: usize| (first + 2 * a) as f32 - order as f32 + 0.5;
                let pairs = high.iter().zip(low.iter().skip(shift)).enumerate();
                let sum: f32 = pairs.map(|(a, (x, y))| x * y * degree(a)).sum();
                walk.covariance[i][j] = scale * sum;
                if counts(j, n) {
                    walk.mean[i] += scale * sum;
                }
                if i != j && counts(i, n) {
                    walk.mean[j] += scale * sum;
                }
            }
        }
        let mean = walk.mean.iter().enumerate().take(n);
        walk.variance = mean
            .filter(|(i, _)| counts(*i, n))
            .map(|(_, mean)| mean)
            .sum();
        walk
    }
}

/// Estimate under one model.
#[derive(Clone, Copy, Default)]
struct Answer {
    log_weight: f32,
    /// Mean, relative to the coefficient of the first degree.
    mean: f32,
    variance: f32,
    unfollowed: f32,
}

/// Weighted average of estimates.
struct Average {
    /// Largest log weight.
    best: f32,
    /// Sum of the weights, relative to the largest.
    sum: f32,
    mean: f32,
    square: f32,
    unfollowed: f32,
}

impl Average {
    fn add(&mut self, answer: &Answer) {
        let above = answer.log_weight - self.best;
        let weight = if above > 0.0 {
            let factor = libm::expf(-above);
            self.best = answer.log_weight;
            self.sum *= factor;
            self.mean *= factor;
            self.square *= factor;
            self.unfollowed *= factor;
            1.0
        } else {
            libm::expf(above)
        };
        self.sum += weight;
        self.mean += weight * answer.mean;
        self.square += weight * (answer.variance + answer.mean * answer.mean);
        self.unfollowed += weight * answer.unfollowed;
    }
}

impl Evidence<'_> {
    fn covariance(&self, i: usize, j: usize) -> f32 {
        self.scale * self.covariance[i][j]
    }

    /// Estimates the mean for a walk of variance `variance`; the log weight does not include the
    /// prior.
    #[inline(never)]
    fn answer(&self, walk: &Walk, variance: f32, matrix: &mut Square<DEGREES_MAX>) -> Answer {
        // The degrees above the first, which is the one to estimate.
        let n = self.count.min(DEGREES_MAX).saturating_sub(1);
        let (mut z, mut q) = ([0.0; DEGREES_MAX], [0.0; DEGREES_MAX]);
        let own_rows = self.covariance.iter().map(|row| &row[1..]);
        let rows = matrix.iter_mut().zip(&walk.covariance);
        for (i, ((row, walk), own)) in rows.zip(own_rows.skip(1)).enumerate().take(n) {
            let places = row.iter_mut().zip(walk).zip(own);
            for ((place, walk), own) in places.take(i + 1) {
                *place = self.scale * own + variance * walk;
            }
        }
        let places = z.iter_mut().zip(&mut q).zip(&self.phase[1..]);
        let first = walk.mean.iter().zip(&self.covariance[0][1..]);
        for (((z, q), phase), (mean, own)) in places.zip(first).take(n) {
            *z = *phase;
            *q = variance * mean - self.scale * own;
        }
        let factor = Factor::new(matrix, n);
        factor.forward(&mut z);
        factor.forward(&mut q);
        let square: f32 = z.iter().map(|z| z * z).sum();
        let both: f32 = z.iter().zip(&q).map(|(z, q)| z * q).sum();
        let known: f32 = q.iter().map(|q| q * q).sum();
        let unlikely =
            0.5 * (self.freedom + self.count as f32) * libm::log1pf(square / self.freedom);
        Answer {
            log_weight: -0.5 * factor.log_det() - unlikely,
            mean: both,
            variance: (self.covariance(0, 0) + variance * walk.variance - known).max(0.0),
            unfollowed: variance * walk.tail,
        }
    }

    #[inline(never)]
    pub fn mean_phase(&self) -> MeanPhase {
        let mut matrix = [[0.0; DEGREES_MAX]; DEGREES_MAX];
        let mut steady = self.answer(&Walk::NONE, 0.0, &mut matrix);
        steady.log_weight += libm::logf(self.steady);
        let mut average = Average {
            best: f32::NEG_INFINITY,
            sum: 0.0,
            mean: 0.0,
            square: 0.0,
            unfollowed: 0.0,
        };
        average.add(&steady);
        let min = 0.5 * crate::sqrt(self.covariance(1, 1));
        let strengths = (0..=STRENGTHS)
            .map(|j| min * (1u32 << j) as f32)
            .take_while(|strength| *strength < WALK_MAX)
            .count()
            .max(1);
        let prior = libm::logf((1.0 - self.steady) / (WALKS * strengths) as f32);
        for order in 1..=WALKS {
            let walk = Walk::new(order, self.count);
            for j in 0..strengths {
                let strength = min * (1u32 << j) as f32;
                let mut answer = self.answer(&walk, strength * strength, &mut matrix);
                answer.log_weight += prior;
                average.add(&answer);
            }
        }
        let mean = average.mean / average.sum;
        MeanPhase {
            mean: self.phase[0] + mean,
            variance: (average.square / average.sum - mean * mean).max(0.0),
            unfollowed: average.unfollowed / average.sum,
            steady: libm::expf(steady.log_weight - average.best) / average.sum,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean_phase(second: f32) -> MeanPhase {
        let mut covariance = [[0.0; MOVEMENT_MAX]; MOVEMENT_MAX];
        for (k, row) in covariance.iter_mut().enumerate() {
            row[k] = (2 * k + 3) as f32;
        }
        let mut phase = [0.0; DEGREES_MAX];
        phase[0] = 0.01;
        phase[1] = second;
        Evidence {
            phase,
            covariance: &covariance,
            scale: 1e-4,
            count: 4,
            freedom: 200.0,
            steady: 0.95,
        }
        .mean_phase()
    }

    #[test]
    fn a_steady_phase_pays_little_and_a_moving_one_what_is_not_seen() {
        let steady = mean_phase(0.0);
        assert!(steady.steady > 0.95, "{steady:?}");
        assert!((steady.mean - 0.01).abs() < 1e-3, "{steady:?}");
        assert!((1.0..1.2).contains(&(steady.variance / 3e-4)), "{steady:?}");
        let moving = mean_phase(1.0);
        assert!(
            moving.steady < 1e-3 && moving.variance > 2.0 * steady.variance,
            "{moving:?}"
        );
    }

    /// The odd degrees above `n` add up to the row that `ends` returns.
    #[test]
    fn degrees_of_a_walk_add_up_to_its_ends() {
        for order in 1..=WALKS {
            let n = 5;
            let (k, ends) = ends(order, n);
            let mut sum = [0.0f32; 64];
            for degree in (k..40).step_by(2) {
                for (i, x) in row(order, degree as isize).iter().enumerate() {
                    sum[degree + 2 * i - order] += x;
                }
            }
            for (i, x) in ends.iter().enumerate().take(order) {
                assert!((sum[k + 2 * i - order] - x).abs() < 1e-5, "{order} {i}");
            }
        }
    }
}
