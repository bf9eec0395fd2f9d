//! What the methods cost that one would otherwise pick, on the same windows as the fit of one harmonic.

use super::report::grouped;
use super::{Cell, Jobs, fits};
use crate::baselines::{Method, Scratch};
use crate::simulated::Simulated;
use crate::workload::Measured;
use anyhow::{Result, bail, ensure};
use serde::Serialize;
use std::fmt;

/// Lengths of windows, seconds: those of the fits that leave the chip memory for Levenberg and Marquardt.
const WINDOWS_S: [f64; 5] = [0.2, 0.3, 0.4, 0.6, 1.0];
/// Those that the table for people shows.
const SHOWN_S: [f64; 3] = [0.2, 0.4, 1.0];
/// Harmonics of the scenes: the tone alone, which is all that the methods know of, and one like a grating's.
pub const CARRIED: [u8; 2] = [1, 4];
/// Numbers of channels.
const CHANNELS: [u8; 2] = [2, 16];

/// What one method's estimates of one kind cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BaselineCell {
    /// The method.
    pub method: &'static str,
    /// Length of the window, seconds.
    pub window_s: f64,
    /// Frames in it.
    pub frames: usize,
    /// Harmonics that the scene carries.
    pub carried: u8,
    /// Channels that take part.
    pub channels: u8,
    /// Windows: one for each line of the paper's Table 2 with at least one cycle in the window.
    pub windows: u32,
    /// Those in which it found a frequency.
    pub found: u32,
    /// Instructions, mean.
    pub instructions_mean: f64,
    /// Instructions of the costliest window.
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
    /// Makes the windows.
    pub fn new() -> Result<Self> {
        let scenes = WINDOWS_S.into_iter().flat_map(|window_s| CARRIED.map(|carried| (window_s, carried)));
        let windows = |(window_s, carried)| Ok((window_s, carried, fits::windows(window_s, carried)?));
        scenes.map(windows).collect::<Result<_>>().map(Self)
    }

    /// What there is to measure, in its order: not what does not fit the chip, nor what is the same with fewer channels.
    fn kinds(&self) -> impl Iterator<Item = Kind<'_>> {
        self.0.iter().flat_map(|(window_s, carried, windows)| {
            CHANNELS.into_iter().flat_map(move |channels| {
                let fits = move |method: &Method| {
                    usize::from(channels) <= method.channels_max().min(method.channels_on_chip())
                };
                let kind = move |method| Kind { method, window_s: *window_s, carried: *carried, channels, windows };
                Method::ALL.into_iter().filter(fits).map(kind)
            })
        })
    }

    /// Writes the jobs.
    pub fn write(&self, jobs: &mut Jobs) {
        for Kind { method, channels, windows, .. } in self.kinds() {
            for window in windows {
                jobs.add_baseline(method as u8, channels, &window.values);
            }
        }
    }

    /// Reads what came of them.
    ///
    /// # Errors
    /// The chip found something else than this PC.
    pub fn read(&self, measured: &mut dyn Iterator<Item = Measured>) -> Result<Vec<BaselineCell>> {
        let mut scratch = Scratch::new();
        self.kinds().map(|kind| kind.read(measured, &mut scratch)).collect()
    }
}

impl Kind<'_> {
    fn read(&self, measured: &mut dyn Iterator<Item = Measured>, scratch: &mut Scratch) -> Result<BaselineCell> {
        let Self { method, window_s, carried, channels, windows } = *self;
        let (mut sum, mut worst, mut found) = (0.0, 0, 0);
        for window in windows {
            let next = measured.next();
            let Some(Measured::Baseline { instructions, frequency_bits }) = next else {
                bail!("the baselines' benchmark told of {next:?} where an estimate was due");
            };
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

/// A row for each method, a column for each kind of window; the fit itself in the last row.
pub fn write(baselines: &[BaselineCell], fits: &[Cell], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    writeln!(
        f,
        "What one would otherwise pick, and the fit of one harmonic; the same windows, the costliest of each:"
    )?;
    write!(f, "{:<20}", "channels x window")?;
    let kinds = || CHANNELS.into_iter().flat_map(|channels| SHOWN_S.map(|window_s| (1, channels, window_s)));
    for (_, channels, window_s) in kinds() {
        write!(f, " {:>12}", format!("{channels} x {window_s} s"))?;
    }
    writeln!(f)?;
    let mut row = |name: &str, cost: &dyn Fn((u8, u8, f64)) -> Option<u32>| {
        write!(f, "{name:<20}")?;
        for kind in kinds() {
            write!(f, " {:>12}", cost(kind).map_or("-".into(), |cost| grouped(cost.into())))?;
        }
        writeln!(f)
    };
    for method in Method::ALL.map(Method::name) {
        let of = |kind| baselines.iter().find(|c| c.method == method && (c.carried, c.channels, c.window_s) == kind);
        row(method, &|kind| of(kind).map(|cell| cell.instructions_worst))?;
    }
    let fit = |kind| fits.iter().find(|c| c.harmonics == 1 && (c.carried, c.channels, c.window_s) == kind);
    row("Ridgetone's fit", &|kind| fit(kind).map(|cell| cell.instructions_worst))?;
    let (windows, found) = baselines.iter().fold((0, 0), |(w, g), cell| (w + cell.windows, g + cell.found));
    writeln!(f, "A frequency was found in {found} of {windows} windows.\n")
}
