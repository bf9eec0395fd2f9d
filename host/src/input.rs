//! What the simulated chip feels: a scene, or a recording played to it.

use crate::output::Progress;
use crate::samples::Samples;
use anyhow::{Context, Result, ensure};
use hal_mock::{Constant, Failure, Options, Playback, Scene, Sliding, SlidingScene, Trace, Truth};
use ridgetone_finger::CONVERSION_NS;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Estimate, Event};
use ridgetone_tone::FRAMES_MIN;

/// Reference of the simulated chip, volts; the library's default settings expect the same.
pub const REFERENCE_V: f64 = 4.096;

/// From power-up to the chip's first answer, clock cycles (SBAS297G, power-up).
const POWER_UP_CYCLES: u64 = ads1258::POWER_UP_TICKS as u64;

/// Overload, as a multiple of the reference: the chip clips and sets a status bit (SBAS297G, data
/// format).
const OVERLOAD: f64 = 1.06;

#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "only one exists at a time")]
pub enum Source {
    /// A grating slid over the finger.
    Scene(Sliding),
    /// A recording, one column for each taxel.
    Trace {
        samples: Samples,
        /// Rows per second where it has no `time_s`; the scan's own rate if none.
        rate_hz: Option<f64>,
        volts_per_unit: f64,
    },
}

/// A source and the chip in front of it.
#[derive(Clone, Debug)]
pub struct Input {
    pub source: Source,
    /// Whether the converter adds its own noise, 4.5 uV rms at the scan's data rate; a scene may
    /// switch it off too.
    pub converter_noise: bool,
    /// Seed of that noise. A scene's own is in [`Sliding`].
    pub seed: u64,
}

impl Default for Input {
    fn default() -> Self {
        Self {
            source: Source::Scene(Sliding::default()),
            converter_noise: true,
            seed: 1,
        }
    }
}

/// The scene of a first look: a physical fingertip, over which the period comes out right. The
/// plain scene, [`Sliding::default`], gives each channel a phase of its own: it is for tests.
pub fn first_scene() -> Result<Sliding> {
    hal_mock::parse_scene(
        "hal-mock/scenes/c1.toml",
        include_str!("../../hal-mock/scenes/c1.toml"),
        frame_rate_hz(),
    )
    .context("the first scene")
}

pub struct Opened {
    /// Voltages that the chip converts.
    pub scene: Box<dyn Scene>,
    pub options: Options,
    pub end_s: f64,
    /// True values of a scene.
    pub truth: Option<Truth>,
    pub warning: Option<String>,
    /// What was guessed of how a table is written.
    pub guessed: Option<String>,
    pub uncertainty: Uncertainty,
    /// Why a recording ended early while it was played, if it did.
    pub failure: Option<Failure>,
}

/// What a recording adds to the standard deviations of estimates: the library assumes exactly timed
/// scans. That neighbouring scans of a slow recording are alike it sees in the noise next to the tone.
#[derive(Clone, Copy, Debug, Default)]
pub struct Uncertainty {
    /// Standard deviation of the rows' rate as a share of it.
    pub rate_share: f64,
}

impl Uncertainty {
    /// Enlarges the uncertainties of an estimate.
    pub fn apply(&self, event: &mut Event) {
        if let Event::Estimate(Estimate {
            sigma, frequency, ..
        }) = event
        {
            *sigma = sigma.hypot(self.rate_share as f32 * *frequency);
        }
    }
}

impl Opened {
    /// Inputs at 0 V for ever, with the converter's noise.
    pub fn untouched() -> Self {
        let (scene, options) = (Box::new(Constant::default()), Input::default().options());
        let uncertainty = Uncertainty::default();
        Self {
            scene,
            options,
            end_s: f64::INFINITY,
            truth: None,
            warning: None,
            guessed: None,
            uncertainty,
            failure: None,
        }
    }
}

/// From one input of a scan to the next, seconds.
pub const SLOT_S: f64 = CONVERSION_NS as f64 * 1e-9;

/// Frames per second of the default scan, nominal.
pub fn frame_rate_hz() -> f64 {
    rate_of(&Plan::PAPER)
}

/// Frames per second of a plan, nominal.
pub fn rate_of(plan: &Plan) -> f64 {
    f64::from(plan.adc_clock_hz) / f64::from(plan.frame_ticks)
}

impl Input {
    /// The chip in front of any source.
    fn options(&self) -> Options {
        Options {
            noise: self.converter_noise,
            seed: self.seed,
            power_up_cycles: POWER_UP_CYCLES,
            ..Options::default()
        }
    }

    /// As [`open`](Self::open), of an input that has to fill a window.
    pub fn open_for(&self, settings: &Settings) -> Result<Opened> {
        let window_s = settings.window_s;
        let input = self.open_in(&settings.plan)?;
        if let Source::Trace { samples, .. } = &self.source {
            let (file, end_s) = (samples.name(), input.end_s);
            let fills = end_s >= f64::from(window_s);
            ensure!(
                fills,
                "{file}: {end_s:.3} s of data do not fill a window of {window_s} s: choose a shorter one (--window)"
            );
        }
        Ok(input)
    }

    /// Reads the file or builds the scene, for the default plan.
    pub fn open(&self) -> Result<Opened> {
        self.open_in(&Plan::PAPER)
    }

    /// Reads the file or builds the scene, for a plan.
    pub fn open_in(&self, plan: &Plan) -> Result<Opened> {
        let rate_of_scan_hz = rate_of(plan);
        let mut options = self.options();
        options.clock_hz = plan.adc_clock_hz;
        match &self.source {
            Source::Scene(parameters) => {
                let scene = SlidingScene::new(parameters.clone()).context("scene")?;
                let (truth, end_s) = (scene.truth(), scene.end_s());
                options.noise &= parameters.converter.converter_noise;
                options.clock_error_ppm = parameters.converter.clock_error_ppm;
                check_length("the scene", end_s, SCENE_MAX_S)?;
                let warning = aliased(&truth, rate_of_scan_hz);
                let uncertainty = Uncertainty::default();
                Ok(Opened {
                    scene: Box::new(scene),
                    options,
                    end_s,
                    truth: Some(truth),
                    warning,
                    guessed: None,
                    uncertainty,
                    failure: None,
                })
            }
            Source::Trace {
                samples,
                rate_hz,
                volts_per_unit,
            } => {
                let playback = Playback {
                    row_rate_hz: *rate_hz,
                    scan_rate_hz: rate_of_scan_hz,
                    volts_per_unit: *volts_per_unit,
                    limit_v: OVERLOAD * REFERENCE_V,
                };
                let mut progress = Progress::default();
                let mut show = |read| progress.show(format_args!("{read} rows checked"));
                let trace = Trace::new(samples.opener(), playback, &mut show);
                progress.end();
                let (trace, file) = (trace?, samples.name());
                let (warning, end_s) = (overload(&trace, file), trace.end_s());
                check_length(file, end_s, RECORDING_MAX_S)?;
                check_rate(file, trace.rate_hz(), plan)?;
                options.clock_error_ppm = trace.clock_error_ppm();
                let uncertainty = Uncertainty {
                    rate_share: trace.rate_share(),
                };
                let guessed = trace.guessed().map(str::to_owned);
                let failure = Some(trace.failure());
                Ok(Opened {
                    scene: Box::new(trace),
                    options,
                    end_s,
                    truth: None,
                    warning,
                    guessed,
                    uncertainty,
                    failure,
                })
            }
        }
    }
}

/// Longest scene that is played, seconds: a longer one comes from a wrong speed.
pub const SCENE_MAX_S: f64 = 3600.0;

/// Longest recording that is played, seconds: a longer one has another unit of time.
const RECORDING_MAX_S: f64 = 86_400.0;

/// Share of the frame rate up to which a tone is not aliased, with a margin.
const TONE_MAX: f64 = 0.45;

/// Refuses an input that would play for hours.
pub fn check_length(what: &str, end_s: f64, most_s: f64) -> Result<()> {
    ensure!(
        end_s <= most_s,
        "{what} would last {end_s:.4e} s, and at most {most_s} s are played: check its speed, or its unit of time"
    );
    Ok(())
}

/// Refuses a recording whose rows are too far apart for any window of a plan to be fitted: playing
/// it would make thousands of frames of each row.
fn check_rate(file: &str, rate_hz: f64, plan: &Plan) -> Result<()> {
    let window_s = f64::from(plan.ring_frames()) / rate_of(plan);
    let min_hz = f64::from(FRAMES_MIN) / window_s;
    ensure!(
        rate_hz >= min_hz,
        "{file}: a row every {:.3} s is too slow for touch: the longest window, {window_s:.1} s, needs {FRAMES_MIN} rows ({min_hz:.1} a second); `ridgetone fit --whole {file}` fits rows of any rate",
        rate_hz.recip()
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

/// Warns of the first value outside the chip's range.
fn overload(trace: &Trace, file: &str) -> Option<String> {
    let beyond = trace.beyond()?;
    let (row, column, volts, limit_v) = (
        beyond.row,
        &beyond.column,
        beyond.volts,
        OVERLOAD * REFERENCE_V,
    );
    Some(format!(
        "{file}: row {row}, column {column}: {volts:.4e} V is beyond the chip's +-{limit_v:.2} V and will clip; scale the file with --scale"
    ))
}
