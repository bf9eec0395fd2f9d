//! The cost of the baselines, on the same windows as the fit of one harmonic.

use super::emulated::{Jobs, next};
use super::fits;
use crate::baselines::{Method, Scratch};
use crate::simulated::Simulated;
use crate::workload::{Job, Measured};
use anyhow::{Result, ensure};
use serde::Serialize;

/// Lengths of windows, seconds.
const WINDOWS_S: [f64; 5] = [0.2, 0.3, 0.4, 0.6, 1.0];
/// Harmonics of the scenes: the tone alone, which all the methods assume, and those of a grating.
pub const CARRIED: [u8; 2] = [1, 4];
const CHANNELS: [u8; 2] = [2, 16];

/// The cost of one method's estimates of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BaselineCell {
    pub method: &'static str,
    pub window_s: f64,
    pub frames: usize,
    pub carried: u8,
    pub channels: u8,
    /// Windows: one for each line of the paper's Table 2 with at least one cycle in the window.
    pub windows: u32,
    pub found: u32,
    pub instructions_mean: f64,
    pub instructions_worst: u32,
}

/// One kind of estimate, before it is measured.
struct Kind<'a> {
    method: Method,
    window_s: f64,
    carried: u8,
    channels: u8,
    windows: &'a [Simulated],
}

/// All estimates, by the length of the window and the harmonics of the scene.
pub struct Baselines(Vec<(f64, u8, Vec<Simulated>)>);

impl Baselines {
    pub fn new() -> Result<Self> {
        let scenes = WINDOWS_S
            .into_iter()
            .flat_map(|window_s| CARRIED.map(|carried| (window_s, carried)));
        let windows =
            |(window_s, carried)| Ok((window_s, carried, fits::windows(window_s, carried)?));
        scenes.map(windows).collect::<Result<_>>().map(Self)
    }

    /// All kinds in their order, without those that do not fit the chip and those that are the same
    /// with fewer channels.
    fn kinds(&self) -> impl Iterator<Item = Kind<'_>> {
        self.0.iter().flat_map(|(window_s, carried, windows)| {
            CHANNELS.into_iter().flat_map(move |channels| {
                let fits = move |method: &Method| usize::from(channels) <= method.channels_max();
                let kind = move |method| Kind {
                    method,
                    window_s: *window_s,
                    carried: *carried,
                    channels,
                    windows,
                };
                Method::ALL.into_iter().filter(fits).map(kind)
            })
        })
    }

    pub fn write(&self, jobs: &mut Jobs) {
        for Kind {
            method,
            channels,
            windows,
            ..
        } in self.kinds()
        {
            for window in windows {
                let job = Job::Baseline {
                    method: method as u8,
                    channels,
                    frames: window.values.len() as u32,
                };
                jobs.add(job, window.values.iter().map(|values| (values, u16::MAX)));
            }
        }
    }

    pub fn read(&self, measured: &mut dyn Iterator<Item = Measured>) -> Result<Vec<BaselineCell>> {
        let mut scratch = Scratch::EMPTY;
        self.kinds()
            .map(|kind| kind.read(measured, &mut scratch))
            .collect()
    }
}

impl Kind<'_> {
    fn read(
        &self,
        measured: &mut dyn Iterator<Item = Measured>,
        scratch: &mut Scratch,
    ) -> Result<BaselineCell> {
        let Self {
            method,
            window_s,
            carried,
            channels,
            windows,
        } = *self;
        let (mut sum, mut worst, mut found) = (0.0, 0, 0);
        for window in windows {
            let (instructions, frequency_bits) = next!(
                measured,
                Baseline {
                    instructions,
                    frequency_bits
                }
            );
            let frequency = frequency_bits.map(f32::from_bits);
            let here = method.estimate(&window.values, usize::from(channels), scratch);
            ensure!(
                frequency == here,
                "{} in a window of {window_s} s, {} Hz, {channels} channels: {frequency:?} cycles per frame on the \
                 chip, {here:?} here",
                method.name(),
                window.frequency_hz
            );
            sum += f64::from(instructions);
            worst = worst.max(instructions);
            found += u32::from(frequency.is_some());
        }
        Ok(BaselineCell {
            method: method.name(),
            window_s,
            frames: windows.first().map_or(0, |window| window.values.len()),
            carried,
            channels,
            windows: windows.len() as u32,
            found,
            instructions_mean: sum / windows.len() as f64,
            instructions_worst: worst,
        })
    }
}
