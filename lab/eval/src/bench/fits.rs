//! The cost of a fit, by window, channels and harmonics.

use super::emulated::{Jobs, next};
use crate::setting::{Length, Setting};
use crate::simulated::Simulated;
use crate::trade::contender::{first, fit_scene};
use crate::trade::setups::Setup;
use crate::workload::{Job, Measured, Outcome};
use anyhow::{Result, ensure};
use ridgetone_proto::settings::{Declared, TAXELS};
use ridgetone_tone::Status;
use serde::Serialize;

/// Lengths of windows, seconds: from the shortest of the bars to the longest setting.
pub const WINDOWS_S: [f64; 6] = [0.2, 0.3, 0.4, 0.6, 1.0, 3.9];
pub const CHANNELS: [u8; 4] = [1, 2, 4, 16];
/// Harmonics of a scene, and most of a fit, the fundamental included.
pub const HARMONICS: [u8; 4] = [1, 2, 3, 4];
/// Noise, decibels below the tone.
pub const SNR_DB: f64 = 20.0;

/// Whether a fit of up to `harmonics` harmonics is measured in a scene of `carried`: as many as
/// there are, with any number of channels; what fewer do to a scene like a grating's, and what the
/// default does to a pure tone, with all.
pub fn is_measured(carried: u8, harmonics: u8, channels: u8) -> bool {
    let [fewest, .., most] = HARMONICS;
    let all = usize::from(channels) == TAXELS;
    carried == harmonics || all && (carried == most || carried == fewest && harmonics == most)
}

/// Instructions of one pass of cosine and sine over 16 x 240 samples, measured on the same
/// emulator: the unit of costs.
pub const PASS_INSTRUCTIONS: f64 = 14_300.0;

/// The cost of fits of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    pub window_s: f64,
    pub frames: usize,
    pub channels: u8,
    /// Most harmonics, the fundamental included.
    pub harmonics: u8,
    pub carried: u8,
    /// Windows fitted: one for each line of the paper's Table 2 with at least one cycle in the
    /// window.
    pub windows: u32,
    /// Those in which the tone was found.
    pub good: u32,
    pub instructions_mean: f64,
    pub instructions_worst: u32,
    /// The costliest window whose tone is expected.
    pub tracked_worst: u32,
    /// The worst one in passes over 16 x 240 samples.
    pub passes_worst: f64,
    pub stack_bytes: u32,
}

/// One kind of fit, before it is measured.
struct Kind {
    declared: Declared,
    window_s: f64,
    channels: u8,
    harmonics: u8,
    carried: u8,
    windows: Vec<Simulated>,
}

pub struct Fits(Vec<Kind>);

impl Fits {
    pub fn new() -> Result<Self> {
        let mut kinds = Vec::new();
        for window_s in WINDOWS_S {
            for channels in CHANNELS {
                for harmonics in HARMONICS {
                    for carried in HARMONICS
                        .into_iter()
                        .filter(|carried| is_measured(*carried, harmonics, channels))
                    {
                        let windows = windows(window_s, carried)?;
                        kinds.push(Kind {
                            declared: Declared::DEFAULT,
                            window_s,
                            channels,
                            harmonics,
                            carried,
                            windows,
                        });
                    }
                }
            }
        }
        Ok(Self(kinds))
    }

    /// Sixteen channels, and as many harmonics as are fitted, in each of the scenes, in windows of these
    /// lengths.
    pub fn of_scenes(scenes: &[Setup], windows_s: &[f64]) -> Result<Self> {
        let mut kinds = Vec::new();
        for scene in scenes {
            for window_s in windows_s {
                kinds.push(Kind {
                    declared: scene.declared,
                    window_s: *window_s,
                    channels: TAXELS as u8,
                    harmonics: scene.harmonics,
                    carried: scene.harmonics,
                    windows: windows(*window_s, scene.harmonics)?,
                });
            }
        }
        Ok(Self(kinds))
    }

    pub fn write(&self, jobs: &mut Jobs) {
        for kind in &self.0 {
            for window in &kind.windows {
                let valid = first(kind.channels);
                let job = Job::Fit {
                    declared: kind.declared,
                    harmonics: kind.harmonics,
                    frames: window.values.len() as u32,
                };
                jobs.add(job, window.values.iter().map(|values| (values, valid)));
            }
        }
    }

    pub fn read(&self, measured: &mut dyn Iterator<Item = Measured>) -> Result<Vec<Cell>> {
        self.0.iter().map(|kind| kind.read(measured)).collect()
    }
}

impl Kind {
    fn read(&self, measured: &mut dyn Iterator<Item = Measured>) -> Result<Cell> {
        let Self {
            declared,
            window_s,
            channels,
            harmonics,
            carried,
            ref windows,
        } = *self;
        let (mut sum, mut worst, mut stack, mut good) = (0.0, 0, 0, 0);
        let (mut worst_tracked, scene) = (0, ridgetone_finger::scene(&declared, harmonics));
        for window in windows {
            let (instructions, tracked, stack_bytes, outcome) = next!(
                measured,
                Fit {
                    instructions,
                    tracked,
                    stack_bytes,
                    outcome
                }
            );
            let fit = fit_scene(&window.values, &scene, first(channels))?;
            let here = Outcome::new(Some(&fit));
            ensure!(
                outcome == here,
                "a window of {window_s} s, {} Hz, {channels} channels, {harmonics} harmonics: \
                 {outcome:?} on the chip, {here:?} here",
                window.frequency_hz
            );
            sum += f64::from(instructions);
            worst = worst.max(instructions);
            worst_tracked = worst_tracked.max(tracked);
            stack = stack.max(stack_bytes);
            good += u32::from(fit.status == Status::Good);
        }
        Ok(Cell {
            window_s,
            frames: windows.first().map_or(0, |window| window.values.len()),
            channels,
            harmonics,
            carried,
            windows: windows.len() as u32,
            good,
            instructions_mean: sum / windows.len() as f64,
            instructions_worst: worst,
            tracked_worst: worst_tracked,
            passes_worst: f64::from(worst) / PASS_INSTRUCTIONS,
            stack_bytes: stack,
        })
    }
}

/// One window for each line of Table 2 that has a cycle in it.
pub fn windows(window_s: f64, carried: u8) -> Result<Vec<Simulated>> {
    let settings = Setting::table_2(Length::Seconds(window_s), SNR_DB, carried);
    settings
        .zip(1..)
        .map(|(setting, seed)| setting.window(seed))
        .collect()
}
