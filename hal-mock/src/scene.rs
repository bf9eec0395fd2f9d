//! The voltages at the chip's inputs as a function of input and time.

use crate::random::{Random, Stream};

/// Number of analogue inputs of the chip, AIN0 to AIN15.
pub const INPUTS: usize = 16;

/// A source of input voltages.
pub trait Scene: Send {
    /// Voltage in volts against ground on input AIN`input` (0 to 15) at `t_s` seconds of scene
    /// time.
    ///
    /// The simulated chip calls this once per conversion (twice for a differential one) with `t_s`
    /// never decreasing, so a scene may draw its noise here. Times before 0 and after
    /// [`end_s`](Self::end_s) must return the values at the scene's ends. NaN means no reading: the
    /// conversion ends without a new result.
    fn volts(&mut self, input: u8, t_s: f64) -> f64;

    /// Scene time in seconds at which the scene ends.
    fn end_s(&self) -> f64;
}

impl<S: Scene + ?Sized> Scene for Box<S> {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        (**self).volts(input, t_s)
    }

    fn end_s(&self) -> f64 {
        (**self).end_s()
    }
}

/// Constant voltages, for tests of the chip itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// Volts on AIN0 to AIN15.
    pub volts: [f64; INPUTS],
    /// Duration in seconds; may be infinite.
    pub end_s: f64,
}

impl Default for Constant {
    /// 0 V on every input, without end.
    fn default() -> Self {
        Self {
            volts: [0.0; INPUTS],
            end_s: f64::INFINITY,
        }
    }
}

impl Scene for Constant {
    fn volts(&mut self, input: u8, _t_s: f64) -> f64 {
        self.volts.get(usize::from(input)).copied().unwrap_or(0.0)
    }

    fn end_s(&self) -> f64 {
        self.end_s
    }
}

/// A scene that repeats for ever.
#[derive(Clone, Debug)]
pub struct Repeated<S>(pub S);

impl<S: Scene> Scene for Repeated<S> {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        let end_s = self.0.end_s();
        self.0.volts(input, t_s % end_s)
    }

    fn end_s(&self) -> f64 {
        f64::INFINITY
    }
}

/// A scene with white Gaussian noise added to every reading.
///
/// The generator is sequential: the same seed and the same sequence of readings produce the same
/// noise.
#[derive(Clone, Debug)]
pub struct Noisy<S> {
    scene: S,
    sigma_v: f64,
    random: Random,
}

impl<S: Scene> Noisy<S> {
    /// Adds noise of standard deviation `sigma_v` volts to `scene`.
    pub fn new(scene: S, sigma_v: f64, seed: u64) -> Self {
        Self {
            scene,
            sigma_v,
            random: Random::new(seed, Stream::SceneNoise),
        }
    }
}

impl<S: Scene> Scene for Noisy<S> {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        self.scene.volts(input, t_s) + self.sigma_v * self.random.gaussian()
    }

    fn end_s(&self) -> f64 {
        self.scene.end_s()
    }
}
