//! The scene in front of the simulated chip.

use anyhow::{Context, Result, ensure};
use hal_mock::{Constant, Options, Scene, Sliding, SlidingScene, Truth};
use ridgetone_finger::CONVERSION_NS;
use ridgetone_proto::plan::Plan;

/// Reference of the simulated chip in volts; the library's default settings expect the same.
pub const REFERENCE_V: f64 = 4.096;

/// Time from power-up to the chip's first answer, clock cycles (SBAS297G, power-up).
const POWER_UP_CYCLES: u64 = ads1258::POWER_UP_TICKS as u64;

/// A scene in which a grating slides over the finger, to be read by the simulated chip.
#[derive(Clone, Debug)]
pub struct Input {
    pub scene: Sliding,
    /// Seed of the converter's own noise, 4.5 uV rms at the scan's data rate. The seed of the
    /// scene's noise is in [`Sliding`].
    pub seed: u64,
}

impl Default for Input {
    fn default() -> Self {
        Self {
            scene: Sliding::default(),
            seed: 1,
        }
    }
}

/// Returns the scene for a first look: a physical fingertip, for which the estimated period is
/// right. In the plain scene for tests, [`Sliding::default`], each channel has its own phase.
pub fn first_scene() -> Result<Sliding> {
    built_in(
        "hal-mock/scenes/c1.toml",
        include_str!("../../hal-mock/scenes/c1.toml"),
    )
}

pub fn demo_scene() -> Result<Sliding> {
    built_in(
        "hal-mock/scenes/demo.toml",
        include_str!("../../hal-mock/scenes/demo.toml"),
    )
}

fn built_in(name: &str, text: &str) -> Result<Sliding> {
    hal_mock::parse_scene(name, text, frame_rate_hz()).context("a built-in scene")
}

pub struct Opened {
    /// Voltages that the chip converts.
    pub scene: Box<dyn Scene>,
    pub options: Options,
    pub end_s: f64,
    /// True values of a single scene.
    pub truth: Option<Truth>,
    pub warning: Option<String>,
}

impl Opened {
    /// Returns inputs at 0 V for ever, with the converter's noise.
    pub fn untouched() -> Self {
        Self {
            scene: Box::new(Constant::default()),
            options: Input::default().options(),
            end_s: f64::INFINITY,
            truth: None,
            warning: None,
        }
    }
}

/// Time from one input of a scan to the next, seconds.
pub const SLOT_S: f64 = CONVERSION_NS as f64 * 1e-9;

/// Returns the nominal frames per second of the default scan.
pub fn frame_rate_hz() -> f64 {
    rate_of(&Plan::PAPER)
}

/// Returns the nominal frames per second of a plan.
pub fn rate_of(plan: &Plan) -> f64 {
    f64::from(plan.adc_clock_hz) / f64::from(plan.frame_ticks)
}

impl Input {
    /// Makes an input that uses the scene's seed for all noise.
    pub fn of(scene: Sliding) -> Self {
        Self {
            seed: scene.seed,
            scene,
        }
    }

    /// Returns the chip's options, which are the same for any scene.
    fn options(&self) -> Options {
        Options {
            seed: self.seed,
            power_up_cycles: POWER_UP_CYCLES,
            ..Options::default()
        }
    }

    /// Builds the scene, for the default plan.
    pub fn open(&self) -> Result<Opened> {
        self.open_in(&Plan::PAPER)
    }

    /// Builds the scene, for a plan.
    pub fn open_in(&self, plan: &Plan) -> Result<Opened> {
        let mut options = self.options();
        options.clock_hz = plan.adc_clock_hz;
        options.noise &= self.scene.converter.converter_noise;
        options.clock_error_ppm = self.scene.converter.clock_error_ppm;
        let scene = SlidingScene::new(self.scene.clone()).context("scene")?;
        let (truth, end_s) = (scene.truth(), scene.end_s());
        check_length(end_s)?;
        Ok(Opened {
            scene: Box::new(scene),
            options,
            end_s,
            truth: Some(truth),
            warning: aliased(&truth, rate_of(plan)),
        })
    }
}

/// Longest scene that is played, in seconds; a longer one most likely has a wrong speed.
const SCENE_MAX_S: f64 = 3600.0;

/// Highest tone that is not aliased, as a fraction of the frame rate, with a margin.
const TONE_MAX: f64 = 0.45;

/// Refuses a scene that would play for hours.
pub fn check_length(end_s: f64) -> Result<()> {
    ensure!(
        end_s <= SCENE_MAX_S,
        "the scene would last {end_s:.4e} s, and at most {SCENE_MAX_S} s are played: check its speed"
    );
    Ok(())
}

/// Warns of a scene whose tone is too fast for the scan.
fn aliased(truth: &Truth, rate_hz: f64) -> Option<String> {
    let max_hz = TONE_MAX * rate_hz;
    (truth.frequency_hz > max_hz).then(|| {
        format!(
            "the tone of {:.1} Hz is too fast for {rate_hz:.2} frames a second and will appear as a slower one; up to {max_hz:.1} Hz are reported correctly",
            truth.frequency_hz,
        )
    })
}
