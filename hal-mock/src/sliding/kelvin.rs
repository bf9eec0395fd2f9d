//! Delayed responses: a first-order lag, and the Kelvin body made of one.

/// A first-order lag: its value approaches its input with a time constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lag {
    time_s: f64,
    value: f64,
}

impl Lag {
    /// At rest at 0.
    pub(crate) fn new(time_s: f64) -> Self {
        Self { time_s, value: 0.0 }
    }

    /// Lets `dt_s` > 0 seconds pass in which the input goes along a straight line, for which this
    /// is exact.
    pub(crate) fn advance(&mut self, dt_s: f64, from: f64, to: f64) -> f64 {
        // In the end the value trails a ramp by the time constant.
        let behind = (to - from) / dt_s * self.time_s;
        self.value = to - behind + (self.value - from + behind) * libm::exp(-dt_s / self.time_s);
        self.value
    }
}

/// A viscoelastic solid: a spring beside a spring and a damper in series (Fung; Moy et al.,
/// equations 5 to 8).
///
/// Under a constant force its deformation jumps to `relaxation_s` / `creep_s` of its final value
/// and creeps on with the time constant `creep_s`. When the force is gone it creeps back as slowly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KelvinBody {
    /// The part of the deformation that follows the force without delay.
    at_once: f64,
    delayed: Lag,
}

impl KelvinBody {
    /// At rest. Time constants in seconds: of the force at constant deformation, and of deformation
    /// at constant force.
    pub(crate) fn new(relaxation_s: f64, creep_s: f64) -> Self {
        Self {
            at_once: relaxation_s / creep_s,
            delayed: Lag::new(creep_s),
        }
    }

    /// As [`Lag::advance`] for the force. Returns the deformation, relative to the final one under
    /// the same force.
    pub(crate) fn advance(&mut self, dt_s: f64, from: f64, to: f64) -> f64 {
        let delayed = self.delayed.advance(dt_s, from, to);
        self.at_once * to + (1.0 - self.at_once) * delayed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A, B in N, c in 1/s, and the time constants of relaxation and creep in s (Moy et al., table
    /// 5), then what is left of the deformation 1.8 s after a force of 3 s (table 6).
    const SUBJECTS: [([f64; 3], [f64; 2], f64); 6] = [
        ([2.29, 1.15, 0.70], [1.42, 2.14], 0.43),
        ([1.95, 1.10, 0.26], [3.90, 6.11], 0.74),
        ([2.20, 0.89, 0.58], [2.71, 3.82], 0.62),
        ([2.24, 0.67, 0.35], [2.81, 3.65], 0.61),
        ([2.04, 0.85, 0.30], [3.38, 4.78], 0.69),
        ([2.59, 0.34, 0.26], [3.88, 4.39], 0.66),
    ];

    #[test]
    fn the_parameters_of_table_5_give_the_retained_deformations_of_table_6() {
        for (subject, (_, [relaxation_s, creep_s], retained)) in SUBJECTS.into_iter().enumerate() {
            let mut body = KelvinBody::new(relaxation_s, creep_s);
            body.advance(3.0, 1.0, 1.0);
            // What springs back at once is left out of account there.
            let released = body.advance(1e-9, 0.0, 0.0);
            let later = body.advance(1.8, 0.0, 0.0);
            assert!(
                (later / released - retained).abs() < 0.0051,
                "subject {}: {}",
                subject + 1,
                later / released
            );
        }
    }

    #[test]
    fn relaxation_is_equation_15() {
        // Under a step of deformation the force is A + B exp(-c t): put in, it must give the step
        // back.
        for (subject, ([a, b, c], [relaxation_s, creep_s], _)) in SUBJECTS.into_iter().enumerate() {
            assert!(
                (creep_s / relaxation_s - 1.0 - b / a).abs() < 0.01,
                "subject {}",
                subject + 1
            );
            // Subject 3's printed c contradicts his printed time constant, which table 6 bears out.
            assert!(
                subject == 2 || (c * relaxation_s - 1.0).abs() < 0.02,
                "subject {}",
                subject + 1
            );
            let force = |t_s: f64| (a + b * (-t_s / relaxation_s).exp()) / a;
            let mut body = KelvinBody::new(relaxation_s, relaxation_s * (1.0 + b / a));
            for step in 0..10_000 {
                let t_s = f64::from(step) * 1e-3;
                let deformation = body.advance(1e-3, force(t_s), force(t_s + 1e-3));
                assert!(
                    (deformation - 1.0).abs() < 1e-6,
                    "subject {}: {deformation} at {t_s} s",
                    subject + 1
                );
            }
        }
    }

    #[test]
    fn a_step_of_force_jumps_and_creeps() {
        let mut body = KelvinBody::new(1.42, 2.14);
        assert!((body.advance(1e-9, 1.0, 1.0) - 1.42 / 2.14).abs() < 1e-6);
        assert!((body.advance(30.0, 1.0, 1.0) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_lag_is_a_single_pole() {
        // 390 Hz at 390 Hz: half the power.
        let (tau_s, hz) = (1.0 / (core::f64::consts::TAU * 390.0), 390.0);
        let mut lag = Lag::new(tau_s);
        let wave = |t_s: f64| (core::f64::consts::TAU * hz * t_s).sin();
        let dt_s = 1e-6;
        let power: f64 = (0..100_000)
            .map(|k| {
                lag.advance(
                    dt_s,
                    wave(f64::from(k) * dt_s),
                    wave(f64::from(k + 1) * dt_s),
                )
                .powi(2)
            })
            .sum();
        assert!((power / 100_000.0 - 0.25).abs() < 0.002, "{power}");
    }
}
