//! One formula for all tests: the normal deviate of an F ratio.
//!
//! E. Paulson, "An approximate normalization of the analysis of variance distribution", Annals of
//! Mathematical Statistics 13 (1942), 233-235.

/// Deviate of a ratio of two mean squares with `above` and `below` degrees of freedom: standard
/// normal where both estimate the same variance. With 8 or fewer below it saturates near 5.
pub fn deviate(ratio: f32, above: f32, below: f32) -> f32 {
    let (a, b) = (2.0 / (9.0 * above), 2.0 / (9.0 * below));
    let root = cube_root(ratio.max(f32::MIN_POSITIVE));
    ((1.0 - b) * root - (1.0 - a)) / libm::sqrtf(b * root * root + a)
}

/// Cube root of a positive number, to a few units in the last place. That of `libm` takes f64, which the
/// chip has to emulate.
fn cube_root(x: f32) -> f32 {
    let mut root = f32::from_bits(x.to_bits() / 3 + 0x2a51_0000);
    for _ in 0..3 {
        root = (2.0 * root + x / (root * root)) / 3.0;
    }
    root
}

/// A sum of some values.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sum {
    sum: f32,
    /// How many there are.
    pub count: f32,
}

impl Sum {
    /// Adds a value.
    pub fn add(&mut self, value: f32) {
        self.sum += value;
        self.count += 1.0;
    }

    /// Their mean.
    pub fn mean(&self) -> f32 {
        self.sum / self.count.max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Upper percentage points of F from tables: 1e-3 is a deviate of 3.09.
    #[test]
    fn agrees_with_tables_of_the_f_distribution() {
        for (ratio, above, below, deviation) in [
            (4.605, 2.0, 1e6, 2.326),
            (6.908, 2.0, 1e6, 3.090),
            (4.103, 2.0, 10.0, 1.645),
            (2.348, 10.0, 20.0, 1.645),
            (5.08, 10.0, 20.0, 3.09),
        ] {
            let got = deviate(ratio, above, below);
            assert!(
                (got - deviation).abs() < 0.06,
                "{ratio} {above} {below}: {got}"
            );
        }
    }

    #[test]
    fn equal_variances_have_a_deviate_near_zero_and_zero_a_low_one() {
        assert!(deviate(1.0, 40.0, 40.0).abs() < 1e-6);
        assert!(deviate(0.0, 2.0, 20.0) < -2.0);
        assert!(deviate(f32::MAX, 2.0, 20.0).is_finite());
    }
}
