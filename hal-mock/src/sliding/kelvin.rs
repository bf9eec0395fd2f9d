//! Delayed responses: a first-order lag, and the Kelvin body built from it.

/// A first-order lag: its value approaches its input with a time constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lag {
    time_s: f64,
    value: f64,
}

impl Lag {
    /// Starts at rest at 0.
    pub(crate) fn new(time_s: f64) -> Self {
        Self { time_s, value: 0.0 }
    }

    /// Advances by `dt_s` > 0 seconds and returns the value, which is exact for an input that moves
    /// linearly from `from` to `to`.
    pub(crate) fn advance(&mut self, dt_s: f64, from: f64, to: f64) -> f64 {
        // The value follows a steady ramp with a delay of one time constant.
        let behind = (to - from) / dt_s * self.time_s;
        self.value = to - behind + (self.value - from + behind) * libm::exp(-dt_s / self.time_s);
        self.value
    }
}

/// A viscoelastic solid: a spring in parallel with a spring and a damper in series (Fung; Moy et
/// al., equations 5 to 8).
///
/// Under a constant force its deformation jumps to `relaxation_s` / `creep_s` of its final value
/// and creeps on with the time constant `creep_s`. After the force is removed, it creeps back just
/// as slowly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KelvinBody {
    /// The part of the deformation that follows the force without delay.
    at_once: f64,
    delayed: Lag,
}

impl KelvinBody {
    /// Starts at rest. Time constants in seconds: of the force at constant deformation, and of the
    /// deformation at constant force.
    pub(crate) fn new(relaxation_s: f64, creep_s: f64) -> Self {
        Self {
            at_once: relaxation_s / creep_s,
            delayed: Lag::new(creep_s),
        }
    }

    /// Advances the force like [`Lag::advance`]. Returns the deformation relative to its final
    /// value under a force of 1.
    pub(crate) fn advance(&mut self, dt_s: f64, from: f64, to: f64) -> f64 {
        let delayed = self.delayed.advance(dt_s, from, to);
        self.at_once * to + (1.0 - self.at_once) * delayed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Under a step of deformation the force is A + B exp(-t / relaxation) (Moy et al., equation
    /// 15), so applying this force must produce the step again. A and B are from their subject 1.
    #[test]
    fn relaxation_is_equation_15() {
        let (a, b, relaxation_s) = (2.29, 1.15, 1.42);
        let force = |t_s: f64| (a + b * (-t_s / relaxation_s).exp()) / a;
        let mut body = KelvinBody::new(relaxation_s, relaxation_s * (1.0 + b / a));
        for step in 0..10_000 {
            let t_s = f64::from(step) * 1e-3;
            let deformation = body.advance(1e-3, force(t_s), force(t_s + 1e-3));
            assert!((deformation - 1.0).abs() < 1e-6, "{deformation} at {t_s} s");
        }
    }

    /// The deformation left after the force is removed fades with the creep time.
    #[test]
    fn a_released_body_creeps_back() {
        let mut body = KelvinBody::new(1.42, 2.14);
        body.advance(3.0, 1.0, 1.0);
        // Skip the part that springs back at once.
        let released = body.advance(1e-9, 0.0, 0.0);
        let later = body.advance(1.8, 0.0, 0.0);
        assert!((later / released - (-1.8f64 / 2.14).exp()).abs() < 1e-6);
    }

    #[test]
    fn a_step_of_force_jumps_and_creeps() {
        let mut body = KelvinBody::new(1.42, 2.14);
        assert!((body.advance(1e-9, 1.0, 1.0) - 1.42 / 2.14).abs() < 1e-6);
        assert!((body.advance(30.0, 1.0, 1.0) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_lag_is_a_single_pole() {
        // 390 Hz at a pole of 390 Hz: half the power.
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
