//! Stepwise linear regression: which variables explain a score.
//!
//! The procedure is that of SPSS. The variable with the greatest p leaves the model if its p is above
//! one criterion. If none leaves, the variable with the least p enters if its p is below another.
//! This is repeated until nothing changes. p is that of the F test of one coefficient.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use std::collections::HashSet;

/// When variables enter and leave.
#[derive(Clone, Copy, Debug)]
pub struct Criteria {
    /// A variable enters below this p.
    pub enter: f64,
    /// It leaves above this p, which is no less.
    pub remove: f64,
}

impl Default for Criteria {
    /// The paper's: p < 0.10 (section 2.5).
    fn default() -> Self {
        Self {
            enter: 0.10,
            remove: 0.10,
        }
    }
}

/// The least share of a variable's variance that the model's variables must leave unexplained
/// (SPSS: 0.0001).
const TOLERANCE: f64 = 1e-4;

/// Shares of the score's variance below this are rounding.
const ROUNDING: f64 = 1e-12;

#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// None if the variable is not in the model.
    pub coefficient: Option<f64>,
    /// Significance of the coefficient, or of the one that it would have; none if the variable is a
    /// combination of the model's.
    pub p: Option<f64>,
}

/// The model where no variable enters or leaves any more.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    pub constant: f64,
    pub variables: Vec<Variable>,
    /// Share of the score's variance that it explains; 0 without a variable.
    pub r2: f64,
    /// Significance of the model as a whole.
    pub p: f64,
    /// Standard deviation of the scores around the line.
    pub sigma: f64,
    /// Covariance of the constant and of all variables' coefficients, zeros for those outside.
    pub covariance: Vec<Vec<f64>>,
}

/// Regresses `scores` on the rows of `observed`, one row a score. None if the scores or all
/// variables are constant.
pub fn stepwise(observed: &[Vec<f64>], scores: &[f64], criteria: Criteria) -> Option<Model> {
    let (count, variables) = (scores.len(), observed.first()?.len());
    let column = |v: usize| -> Vec<f64> { observed.iter().map(|row| row[v]).collect() };
    let columns: Vec<Vec<f64>> = (0..variables)
        .map(column)
        .chain([scores.to_vec()])
        .collect();
    let means: Vec<f64> = columns
        .iter()
        .map(|column| column.iter().sum::<f64>() / count as f64)
        .collect();
    let product = |a: usize, b: usize| -> f64 {
        columns[a]
            .iter()
            .zip(&columns[b])
            .map(|(x, y)| (x - means[a]) * (y - means[b]))
            .sum()
    };
    // Roots of the sums of squares; a constant is left out below.
    let norms: Vec<f64> = (0..=variables)
        .map(|v| product(v, v).sqrt())
        .zip(&means)
        .map(|(norm, mean)| if norm > 1e-9 * mean.abs() { norm } else { 0.0 })
        .collect();
    let score_norm = norms[variables];
    if score_norm == 0.0 || norms[..variables].iter().all(|norm| *norm == 0.0) {
        return None;
    }
    let correlation = |a: usize, b: usize| {
        if norms[a] * norms[b] > 0.0 {
            product(a, b) / (norms[a] * norms[b])
        } else {
            0.0
        }
    };
    let mut swept: Vec<Vec<f64>> = (0..=variables)
        .map(|a| (0..=variables).map(|b| correlation(a, b)).collect())
        .collect();
    let mut inside = vec![false; variables];
    let mut seen = HashSet::new();
    // The two bounds keep it from going round in circles, except through rounding.
    while seen.insert(inside.clone()) {
        let by_p = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0);
        let all = |is_inside: bool| {
            let those = (0..variables).filter(|v| inside[*v] == is_inside);
            those
                .filter_map(|v| Some((p_of(&swept, &inside, v, count)?, v)))
                .collect::<Vec<_>>()
        };
        let leaves = all(true)
            .into_iter()
            .max_by(by_p)
            .filter(|(p, _)| *p > criteria.remove);
        let enters = || {
            all(false)
                .into_iter()
                .min_by(by_p)
                .filter(|(p, _)| *p < criteria.enter)
        };
        let Some((_, v)) = leaves.or_else(enters) else {
            break;
        };
        sweep(&mut swept, v);
        inside[v] = !inside[v];
    }

    let chosen: Vec<usize> = (0..variables).filter(|v| inside[*v]).collect();
    let left = swept[variables][variables].max(0.0);
    let freedom = (count - 1 - chosen.len()) as f64;
    let sigma = score_norm * (left / freedom).sqrt();
    let coefficient = |v: usize| swept[v][variables] * score_norm / norms[v];
    // The coefficients' covariance, and with the means the constant's.
    let mut covariance = vec![vec![0.0; variables + 1]; variables + 1];
    covariance[0][0] = sigma * sigma / count as f64;
    for &a in &chosen {
        for &b in &chosen {
            let of_both = sigma * sigma * swept[a][b] / (norms[a] * norms[b]);
            covariance[a + 1][b + 1] = of_both;
            covariance[0][a + 1] -= means[b] * of_both;
            covariance[a + 1][0] -= means[b] * of_both;
            covariance[0][0] += means[a] * means[b] * of_both;
        }
    }
    Some(Model {
        constant: means[variables]
            - chosen
                .iter()
                .map(|v| coefficient(*v) * means[*v])
                .sum::<f64>(),
        variables: (0..variables)
            .map(|v| Variable {
                coefficient: inside[v].then(|| coefficient(v)),
                p: p_of(&swept, &inside, v, count),
            })
            .collect(),
        r2: 1.0 - left,
        p: tail(
            chosen.len() as f64,
            freedom,
            (1.0 - left) / chosen.len() as f64,
            left / freedom,
        )
        .unwrap_or(1.0),
        sigma,
        covariance,
    })
}

/// p of a variable's coefficient, or of the one it would have if it entered.
fn p_of(swept: &[Vec<f64>], inside: &[bool], v: usize, count: usize) -> Option<f64> {
    let last = inside.len();
    let own = swept[v][v];
    if !inside[v] && own < TOLERANCE {
        return None;
    }
    let explained = swept[v][last] * swept[v][last] / own;
    let used = inside.iter().filter(|inside| **inside).count() + usize::from(!inside[v]);
    let left = swept[last][last] - if inside[v] { 0.0 } else { explained };
    if explained < ROUNDING {
        return Some(1.0);
    }
    let freedom = count.checked_sub(1 + used).filter(|freedom| *freedom > 0)? as f64;
    tail(1.0, freedom, explained, left / freedom)
}

/// Probability of an F ratio as great or greater by chance.
fn tail(of: f64, freedom: f64, explained: f64, left: f64) -> Option<f64> {
    let ratio = explained / left.max(ROUNDING * explained);
    Some(FisherSnedecor::new(of, freedom).ok()?.sf(ratio))
}

/// Takes a variable into the model or out of it (Goodnight 1979): in rows of the model's variables
/// are then the inverse of their correlations and their coefficients, in the others what the model
/// leaves.
fn sweep(matrix: &mut [Vec<f64>], at: usize) {
    let pivot = matrix[at][at];
    matrix[at].iter_mut().for_each(|value| *value /= pivot);
    let row = matrix[at].clone();
    for (_, values) in matrix
        .iter_mut()
        .enumerate()
        .filter(|(other, _)| *other != at)
    {
        let factor = values[at];
        values
            .iter_mut()
            .zip(&row)
            .for_each(|(value, of_row)| *value -= factor * of_row);
        values[at] = -factor / pivot;
    }
    matrix[at][at] = 1.0 / pivot;
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    /// y over x of 1 to 5 by hand: slope 0.6, constant 2.2, explained 3.6 of 6, F = 3.6 / (2.4 / 3)
    /// = 4.5, p = 0.124.
    #[test]
    fn a_line_that_is_not_significant_stays_out() {
        let x: Vec<Vec<f64>> = (1..=5).map(|x| vec![f64::from(x)]).collect();
        let model = stepwise(&x, &[2.0, 4.0, 5.0, 4.0, 5.0], Criteria::default()).expect("a model");
        assert_eq!(
            (model.variables[0].coefficient, model.r2.abs() < 1e-12),
            (None, true)
        );
        assert!(
            (model.variables[0].p.expect("a p") - 0.124).abs() < 5e-4
                && (model.constant - 4.0).abs() < 1e-12
        );
        assert_eq!(model.p, 1.0);
    }

    /// A line whose p is 0.124 enters where more is let in.
    #[test]
    fn criteria_say_what_enters() {
        let x: Vec<Vec<f64>> = (1..=5).map(|x| vec![f64::from(x)]).collect();
        for (enter, is_in) in [(0.12, false), (0.13, true)] {
            let criteria = Criteria {
                enter,
                remove: 0.13,
            };
            let model = stepwise(&x, &[2.0, 4.0, 5.0, 4.0, 5.0], criteria).expect("a model");
            assert_eq!(model.variables[0].coefficient.is_some(), is_in, "{enter}");
        }
    }

    /// Each point twice: F = 7.2 / (4.8 / 8) = 12, p = 0.0085; the residual variance is 0.6, that of
    /// the slope 0.6 / 20.
    #[test]
    fn a_line_by_hand() {
        let x: Vec<Vec<f64>> = (0..10)
            .map(|row| vec![f64::from(row % 5 + 1), 7.0])
            .collect();
        let model = stepwise(
            &x,
            &[2.0, 4.0, 5.0, 4.0, 5.0].repeat(2),
            Criteria::default(),
        )
        .expect("a model");
        let [line, constant] = &model.variables[..] else {
            panic!("two")
        };
        assert!(
            (line.coefficient.expect("in") - 0.6).abs() < 1e-12
                && (model.constant - 2.2).abs() < 1e-12
        );
        assert!(
            (model.r2 - 0.6).abs() < 1e-12 && (model.p - 0.0085).abs() < 5e-5,
            "{model:?}"
        );
        assert!(
            (line.p.expect("a p") - model.p).abs() < 1e-12
                && *constant
                    == Variable {
                        coefficient: None,
                        p: None
                    }
        );
        assert!(
            (model.sigma.powi(2) - 0.6).abs() < 1e-12
                && (model.covariance[1][1] - 0.03).abs() < 1e-12
        );
        // At the mean of x the line is known to sigma^2 over the number of scores.
        let at_3 =
            model.covariance[0][0] + 6.0 * model.covariance[0][1] + 9.0 * model.covariance[1][1];
        assert!((at_3 - 0.06).abs() < 1e-12, "{at_3}");
    }

    /// z = x + 0.7 y with a little noise enters first, y and x follow, and z leaves. The figures
    /// are those of a least-squares solver and an F distribution that share no code with this one
    /// (numpy and scipy).
    #[test]
    fn a_variable_that_others_replace_leaves() {
        let row = |i: usize| {
            let (x, y) = ((i % 4) as f64, (i * 7 % 5) as f64);
            vec![x, y, x + 0.7 * y + 0.5 * ((i * 5 % 7) as f64 - 3.0) / 3.0]
        };
        let observed: Vec<Vec<f64>> = (0..20).map(row).collect();
        let noise = (0..20).map(|i| 0.2 * ((i * 11 % 13) as f64 - 6.0) / 6.0);
        let scores: Vec<f64> = observed
            .iter()
            .zip(noise)
            .map(|(row, noise)| 1.0 + 2.0 * row[0] + 2.0 * row[1] + noise)
            .collect();
        let model = stepwise(&observed, &scores, Criteria::default()).expect("a model");
        let [x, y, z] = &model.variables[..] else {
            panic!("three")
        };
        let close = |found: f64, expected: f64| {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}")
        };
        close(x.coefficient.expect("x is in"), 2.02);
        close(y.coefficient.expect("y is in"), 2.020_833_333);
        close(model.constant, 0.918_333_333);
        assert_eq!(z.coefficient, None);
        close(z.p.expect("a p"), 0.916_754_624_9);
        close(model.sigma, 0.130_753_222_6);
        close(model.r2, 0.998_905_938_5);
        for (k, sigma) in [0.064_055_74, 0.026_150_64, 0.020_673_9]
            .into_iter()
            .enumerate()
        {
            close(model.covariance[k][k].sqrt(), sigma);
        }
    }

    /// Coefficients of eight observations scatter as their covariance says: with five degrees of
    /// freedom the share has the variance 5 / 3.
    #[test]
    fn coefficients_scatter_as_their_covariance_says() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut normal = || {
            (0..12)
                .map(|_| (random.next_u32() as f64) / 2f64.powi(32))
                .sum::<f64>()
                - 6.0
        };
        let observed: Vec<Vec<f64>> = (0..8)
            .map(|i| vec![f64::from(i), f64::from(i * 3 % 8) + 5.0])
            .collect();
        let (mut shares, mut chosen) = ([0.0; 3], 0.0);
        for _ in 0..2000 {
            let scores: Vec<f64> = observed
                .iter()
                .map(|row| 4.0 + row[0] - 2.0 * row[1] + 0.3 * normal())
                .collect();
            let model = stepwise(&observed, &scores, Criteria::default()).expect("a model");
            let [Some(a), Some(b)] = [0, 1].map(|v: usize| model.variables[v].coefficient) else {
                continue;
            };
            chosen += 1.0;
            for (k, off) in [model.constant - 4.0, a - 1.0, b + 2.0]
                .into_iter()
                .enumerate()
            {
                shares[k] += off * off / model.covariance[k][k];
            }
        }
        assert!(chosen > 1990.0, "{chosen}");
        let ratios = shares.map(|share| share / chosen / (5.0 / 3.0));
        assert!(
            ratios.iter().all(|ratio| (0.8..1.25).contains(ratio)),
            "{ratios:?}"
        );
    }

    #[test]
    fn what_cannot_be_regressed_is_refused() {
        assert_eq!(
            stepwise(&[vec![1.0], vec![2.0]], &[3.0, 3.0], Criteria::default()),
            None
        );
        assert_eq!(
            stepwise(&[vec![1.0], vec![1.0]], &[3.0, 4.0], Criteria::default()),
            None
        );
        assert_eq!(stepwise(&[], &[], Criteria::default()), None);
        // Two points are on a line, but there is nothing to tell its p.
        let model =
            stepwise(&[vec![1.0], vec![2.0]], &[3.0, 4.0], Criteria::default()).expect("a model");
        assert_eq!(
            model.variables[0],
            Variable {
                coefficient: None,
                p: None
            }
        );
    }
}
