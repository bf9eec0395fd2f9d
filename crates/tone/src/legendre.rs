//! Legendre polynomials, for baselines and for phase and amplitude modulation.

use crate::limits::{DEGREE_MAX, DEGREES_MAX};

/// P_0 to P_(N - 1) at `u`.
pub fn legendre<const N: usize>(u: f32) -> [f32; N] {
    let mut p = [1.0; N];
    fill_legendre(u, &mut p);
    p
}

/// Fills in the polynomials from degree 1 on; `p[0]` must be 1.
pub fn fill_legendre(u: f32, p: &mut [f32]) {
    for k in 1..p.len() {
        let before = if k > 1 { p[k - 2] } else { 0.0 };
        p[k] = legendre_after(k - 1, u, [before, p[k - 1]]);
    }
}

/// P_(k + 1) at `u`, from P_(k - 1) and P_k.
pub fn legendre_after(k: usize, u: f32, [before, p]: [f32; 2]) -> f32 {
    let [own, other] = RECURSION[k % RECURSION.len()];
    own * u * p - other * before
}

/// Coefficients (2 k + 1) / (k + 1) and k / (k + 1) of the recursion.
const RECURSION: [[f32; 2]; DEGREES_MAX + 1] = {
    let mut recursion = [[0.0; 2]; DEGREES_MAX + 1];
    let mut k = 0;
    while k <= DEGREES_MAX {
        recursion[k] = [
            (2 * k + 1) as f32 / (k + 1) as f32,
            k as f32 / (k + 1) as f32,
        ];
        k += 1;
    }
    recursion
};

/// Derivatives of P_0 to P_(N - 1) at `u`: P'_k = P'_(k - 2) + (2 k - 1) P_(k - 1).
pub fn slopes<const N: usize>(u: f32) -> [f32; N] {
    let p = legendre::<N>(u);
    let mut slopes = [0.0; N];
    for k in 1..N {
        let before = if k > 1 { slopes[k - 2] } else { 0.0 };
        slopes[k] = before + (2 * k - 1) as f32 * p[k - 1];
    }
    slopes
}

/// Values and slopes of the baselines' polynomials at `u`.
pub fn baselines(u: f32) -> [[f32; 2]; DEGREE_MAX + 1] {
    let square = u * u;
    let second = 1.5 * square - 0.5;
    let third = u * (2.5 * square - 1.5);
    let fourth = 0.125 * (square * (35.0 * square - 30.0) + 3.0);
    [
        [1.0, 0.0],
        [u, 1.0],
        [second, 3.0 * u],
        [third, 5.0 * second + 1.0],
        [fourth, 7.0 * third + 3.0 * u],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_slopes_are_those_of_the_closed_forms() {
        let u = 0.3f32;
        let [.., p2, p3] = legendre::<4>(u);
        assert!((p2 - 0.5 * (3.0 * u * u - 1.0)).abs() < 1e-6);
        assert!((p3 - 0.5 * (5.0 * u * u * u - 3.0 * u)).abs() < 1e-6);
        let [zero, one, d2, d3] = slopes::<4>(u);
        assert_eq!((zero, one), (0.0, 1.0));
        assert!((d2 - 3.0 * u).abs() < 1e-6 && (d3 - 0.5 * (15.0 * u * u - 3.0)).abs() < 1e-6);
        let pairs = legendre::<5>(u).into_iter().zip(slopes::<5>(u));
        for ([value, slope], (p, d)) in baselines(u).into_iter().zip(pairs) {
            assert!((value - p).abs() < 1e-6 && (slope - d).abs() < 1e-6);
        }
    }
}
