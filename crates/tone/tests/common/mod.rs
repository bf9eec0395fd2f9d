//! Numbers that are the same in every run.
// Not every program of tests uses all of it.
#![allow(dead_code)]

/// Evenly from 0 to 1: a linear congruential generator (D. E. Knuth, MMIX).
pub fn even(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1 << 24) as f64
    }
}

/// With mean 0 and variance 1: a sum of twelve even numbers is nearly normal.
pub fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut even = even(seed);
    move || (0..12).map(|_| even()).sum::<f64>() - 6.0
}
