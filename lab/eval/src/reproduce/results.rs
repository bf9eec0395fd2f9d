//! The data of a reproduction: figures of every run and of the windows.

use hal_mock::TABLE_2;
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reproduction {
    /// Whether the firmware image ran in the emulator, or its library on a PC.
    pub emulated: bool,
    pub combinations: Vec<Combination>,
    /// Table 2: what a perfect stimulator makes, those that the paper did not test included.
    pub expected: Vec<Expected>,
    pub causes: Vec<Cause>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Combination {
    /// Speed that the stimulator is set to, mm/s.
    pub speed_mm_s: f64,
    pub period_mm: f64,
    pub runs: Vec<Run>,
    /// Figure 7: shorter windows, all runs together.
    pub windows: Vec<Windows>,
    /// Equation 11 for piezoresistor 1 of units 1 and 2; none for a single run.
    pub repeatability: Option<[f64; 2]>,
}

impl Combination {
    /// Its number in the paper's tables, from 0 on.
    pub fn number(&self) -> Option<usize> {
        TABLE_2
            .into_iter()
            .position(|line| line == (self.speed_mm_s, self.period_mm))
    }

    /// Its name in the paper's tables, C1 to C10; empty if the paper has none.
    pub fn name(&self) -> String {
        self.number()
            .map_or_else(String::new, |c| format!("C{}", c + 1))
    }

    pub fn nominal_hz(&self) -> f64 {
        self.speed_mm_s / self.period_mm
    }

    /// Hertz in percent of the nominal frequency.
    pub fn percent(&self, hz: f64) -> f64 {
        100.0 * hz / self.nominal_hz()
    }

    /// RMS difference of an estimate from the nominal frequency (equation 10), hertz. None if a run
    /// has no estimate.
    pub fn rms_hz(&self, estimate: impl Fn(&Run) -> Option<f64>) -> Option<f64> {
        rms(self
            .runs
            .iter()
            .map(|run| Some(estimate(run)? - self.nominal_hz())))
    }

    /// RMS difference from the true frequency of each run, hertz.
    pub fn own_rms_hz(&self, estimate: impl Fn(&Run) -> Option<f64>) -> Option<f64> {
        rms(self
            .runs
            .iter()
            .map(|run| Some(estimate(run)? - run.true_hz)))
    }
}

/// Root of the mean square. None if there are no values or one has no figure.
pub fn rms(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let values: Option<Vec<f64>> = values.collect();
    let values = values.filter(|values| !values.is_empty())?;
    Some((values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt())
}

/// A run. Frequencies in hertz, times in seconds of device time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Number of the data series, 1 to 40 for four runs of each combination.
    pub series: usize,
    /// The true frequency: the stimulator's mean speed over the period.
    pub true_hz: f64,
    pub true_slide_s: (f64, f64),
    /// The paper's estimates over its 55 mm, for its two pairs of channels.
    pub pairs: [Pair; 2],
    /// The mean of all channels' highest lines, over the same 55 mm.
    pub all_fft_hz: Option<f64>,
    /// Our fit of all channels over the same 55 mm, and its standard deviation.
    pub all_fit_hz: Option<(f64, f64)>,
    /// The firmware's report, made without knowing the speed.
    pub firmware: Option<Firmware>,
    /// The firmware's static images before and after the slide, volts above idle by taxel.
    pub images_v: [Vec<f64>; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    pub fft_hz: Option<f64>,
    /// Least squares, by the paper's gradient descent.
    pub least_squares_hz: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Firmware {
    pub contact_s: f64,
    /// Start and end of the slide that it found.
    pub slide_s: (f64, f64),
    /// Frequency over the whole slide and its standard deviation, hertz; none if it found no tone.
    pub tone_hz: Option<(f64, f64)>,
}

/// RMS errors of all windows of a length, hertz, in all runs of a combination.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Windows {
    pub window_s: f64,
    pub windows: u32,
    /// Naive Fourier analysis of the paper's first pair, against the nominal frequency.
    pub fft_hz: f64,
    /// The paper's least squares on it, against the nominal frequency.
    pub least_squares_hz: f64,
    /// Least squares against the true frequency.
    pub own_least_squares_hz: f64,
    /// Our fit of all channels against the nominal frequency, in the windows in which it found one.
    pub all_hz: Option<f64>,
    /// Our fit against the true frequency.
    pub own_all_hz: Option<f64>,
    /// Windows in which our fit found a frequency.
    pub all_found: u32,
}

/// Errors with a part of the imperfections only, over all combinations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cause {
    pub name: String,
    /// RMS of the relative error of the paper's least squares against the nominal frequency,
    /// percent, over 55 mm.
    pub least_squares_percent: f64,
    pub all_percent: f64,
}

/// Table 2: frequencies with a perfect stimulator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Expected {
    pub speed_mm_s: f64,
    pub period_mm: f64,
    /// Our fit of all channels over the paper's 55 mm, hertz.
    pub hz: Option<f64>,
    /// The firmware's frequency over the slide that it finds by itself, hertz.
    pub firmware_hz: Option<f64>,
    /// Delay of the slide's end as the firmware finds it, seconds.
    pub end_late_s: Option<f64>,
}
