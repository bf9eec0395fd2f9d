//! Frames of the simulated finger, with the true values of the scene.

use crate::raised;
use anyhow::{Context, Result, ensure};
use hal_mock::{Scene, Sliding, SlidingScene, Truth, parse_scene};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use ridgetone_host::input::{Input, check_length, rate_of};
use ridgetone_host::replay::{START_US, conversions_of};
use ridgetone_host::settings_form;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Settings, TAXELS};

/// Chip's id of AIN0 (SBAS297G, "Data Format").
const AIN0: u8 = 8;

/// Times of the touch in seconds and its tone in hertz: contact, start and end of the slide, release,
/// end, frequency; then the noise in volts and the rate in hertz.
type Facts = (f64, f64, f64, f64, f64, f64, f64, f64);

/// Level, load and amplitude of a channel's fundamental, volts.
type Channel = (f64, f64, f64);

type Simulated<'py> = (
    Facts,
    Vec<Channel>,
    Bound<'py, PyByteArray>,
    Bound<'py, PyByteArray>,
    Bound<'py, PyByteArray>,
);

/// Options of [`simulate`], from a `dict` with these keys.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Options {
    /// Name of the scene for messages, and its text.
    name: String,
    text: String,
    random_channels: bool,
    seed: Option<u64>,
    settings: String,
    converter: bool,
}

/// Simulates a scene. Returns the true values, the channels, and (as bytes of f64) the times of the
/// rows, their values in volts row by row, and the positions of the grating.
#[pyfunction]
pub fn simulate<'py>(py: Python<'py>, options: Options) -> PyResult<Simulated<'py>> {
    let made = py.detach(|| Made::new(&options)).map_err(raised)?;
    let bytes = |values: &[f64]| {
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_ne_bytes())
            .collect();
        PyByteArray::new(py, &bytes)
    };
    let positions: Vec<f64> = made
        .frames
        .times_s
        .iter()
        .map(|t_s| made.scene.position_mm(*t_s))
        .collect();
    Ok((
        made.facts(),
        made.channels(),
        bytes(&made.frames.times_s),
        bytes(&made.frames.values_v),
        bytes(&positions),
    ))
}

/// Rows of sixteen readings. The time of a row is that of its first reading, from the start of the
/// scene.
#[derive(Default)]
struct Frames {
    times_s: Vec<f64>,
    values_v: Vec<f64>,
}

struct Made {
    scene: SlidingScene,
    plan: Plan,
    frames: Frames,
}

impl Made {
    fn new(options: &Options) -> Result<Self> {
        let settings = settings_form::with_json(&Settings::DEFAULT, &options.settings)?;
        let plan = settings.plan;
        ensure!(
            plan.inputs == u16::MAX,
            "the plan converts {} of 16 channels: choose one of all, such as paper or hand",
            plan.inputs.count_ones()
        );
        let mut parameters = parse_scene(&options.name, &options.text, rate_of(&plan))?;
        parameters.seed = options.seed.unwrap_or(parameters.seed);
        if options.random_channels {
            parameters.finger = None;
        }
        let scene = SlidingScene::new(parameters.clone()).context("scene")?;
        let frames = match options.converter {
            true => Frames::converted(parameters, &plan, settings.vref_v)?,
            false => Frames::at_inputs(scene.clone(), &plan)?,
        };
        Ok(Self {
            scene,
            plan,
            frames,
        })
    }

    fn facts(&self) -> Facts {
        let Truth {
            contact_s,
            slide_start_s,
            slide_end_s,
            release_s,
            frequency_hz,
            end_s,
        } = self.scene.truth();
        let (noise_v, rate_hz) = (self.scene.noise_v(), rate_of(&self.plan));
        (
            contact_s,
            slide_start_s,
            slide_end_s,
            release_s,
            end_s,
            frequency_hz,
            noise_v,
            rate_hz,
        )
    }

    fn channels(&self) -> Vec<Channel> {
        let channels = self.scene.channels().iter();
        channels
            .map(|channel| {
                (
                    channel.offset_v,
                    channel.sliding.mean_v,
                    channel.amplitude_v(),
                )
            })
            .collect()
    }
}

impl Frames {
    /// Returns readings of the simulated ADS1258.
    fn converted(scene: Sliding, plan: &Plan, vref_v: f32) -> Result<Self> {
        let mut frames = Self::default();
        let input = Input::of(scene).open_in(plan)?;
        conversions_of(input, plan, &mut |timed| {
            let Some(taxel) = timed.status().chid().checked_sub(AIN0).map(usize::from) else {
                return Ok(());
            };
            if taxel == 0 {
                frames.times_s.push(f64::from(timed.t_us - START_US) * 1e-6);
            }
            // A scan begins with AIN0 and is complete, because the simulated chip loses no
            // conversion.
            if taxel < TAXELS && frames.values_v.len() % TAXELS == taxel {
                let volts = ads1258::reading::volts(timed.code(), vref_v);
                frames.values_v.push(volts.into());
            }
            Ok(())
        })?;
        let whole = frames.values_v.len() / TAXELS;
        frames.values_v.truncate(whole * TAXELS);
        frames.times_s.truncate(whole);
        Ok(frames)
    }

    /// Returns the voltages at the converter's inputs at the times of their conversions.
    fn at_inputs(mut scene: SlidingScene, plan: &Plan) -> Result<Self> {
        check_length(scene.end_s())?;
        let conversion_s = 1e-9 * f64::from(plan.conversion_ns());
        let frame_s = 1.0 / rate_of(plan);
        let count = (scene.end_s() / frame_s) as usize;
        let mut frames = Self::default();
        for frame in 0..count {
            let t_s = frame as f64 * frame_s;
            frames.times_s.push(t_s);
            for taxel in 0..TAXELS {
                let at_s = t_s + taxel as f64 * conversion_s;
                frames.values_v.push(scene.volts(taxel as u8, at_s));
            }
        }
        Ok(frames)
    }
}
