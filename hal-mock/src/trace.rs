//! Recorded frames as the input of the simulated chip, and the CSV of a scene. The command
//! `ridgetone` reads other layouts, without a simulated chip.

mod write;

pub use write::write_csv;

use crate::file_error::FileError;
use crate::scene::{INPUTS, Scene};
use core::f64::consts::{FRAC_PI_2, PI};

/// Name of the time column, in seconds.
const TIME_COLUMN: &str = "time_s";

/// Maximum relative difference between the rates of the recording and the scan at which frames are
/// held: a chip's clock may be off by that much.
const HELD_FRACTION: f64 = 0.004;

/// Zeros of the filter's sinc on either side: it passes up to 0.44 of the lower rate, and stops
/// from 0.56.
const ZEROS: f64 = 8.0;

/// Maximum number of frames of a recording, including missing ones: 72 minutes of the board's scan.
const FRAMES_MAX: usize = 1 << 20;

/// A frame: volts at AIN0 to AIN15. NaN stands for a missing reading.
pub type TraceFrame = [f64; INPUTS];

/// A recording played to the chip, evenly spaced in time.
///
/// - **Frames at about the scan's own rate are held**: frame k is what scan k converts, unchanged.
///   The chip's clock has to run as the recording's did: [`clock_error_ppm`](Self::clock_error_ppm).
/// - **Frames at another rate are resampled** by a windowed sinc with the lower rate's band. This
///   removes a faster recording's noise above the scan's band; the rest stays white. A slower
///   recording has no noise above its own band, so neighbouring scans are correlated.
/// - **A missing frame** is a conversion without a result; a missing reading in a frame is beyond
///   the scale, with OVF.
pub struct Trace {
    frames: Vec<Option<TraceFrame>>,
    rate_hz: f64,
    scan_rate_hz: f64,
}

impl Trace {
    /// Creates a trace from frames in volts at `rate_hz`, for a chip that scans at `scan_rate_hz`
    /// without a clock error; `None` is a missing frame.
    ///
    /// # Errors
    /// If the rate is not positive, or there are no frames, or more than 1,048,576.
    pub fn new(
        frames: Vec<Option<TraceFrame>>,
        rate_hz: f64,
        scan_rate_hz: f64,
    ) -> Result<Self, FileError> {
        let refuse = |why: &str| Err(FileError::new("frames", None, why));
        if !(rate_hz > 0.0 && rate_hz.is_finite() && scan_rate_hz > 0.0) {
            return refuse("the rate must be greater than 0 Hz");
        }
        match frames.len() {
            0 => refuse("no frame"),
            1..=FRAMES_MAX => Ok(Self {
                frames,
                rate_hz,
                scan_rate_hz,
            }),
            _ => refuse("too long to be played"),
        }
    }

    /// Parses a CSV file of [`write_csv`] or `ridgetone export`: a header, a column `time_s` and up
    /// to 16 columns of volts, the k-th for AINk. Gaps in the stamps are missing frames.
    ///
    /// # Errors
    /// If the file has a different layout; the error names the line.
    pub fn parse(csv: &[u8], file: &str, scan_rate_hz: f64) -> Result<Self, FileError> {
        let refuse = |line, why: String| FileError::new(file, Some(line), why);
        let text = core::str::from_utf8(csv).map_err(|error| refuse(1, error.to_string()))?;
        let mut lines = (1..).zip(text.lines());
        let (_, header) = lines
            .next()
            .ok_or_else(|| refuse(1, "the file is empty".into()))?;
        let names: Vec<&str> = header.split(',').collect();
        if names[0] != TIME_COLUMN || !(2..=INPUTS + 1).contains(&names.len()) {
            let why = format!("needs {TIME_COLUMN}, then 1 to {INPUTS} columns");
            return Err(refuse(1, why));
        }
        let mut rows: Vec<(f64, TraceFrame)> = Vec::new();
        for (line, text) in lines {
            let cells: Vec<&str> = text.split(',').collect();
            if cells.len() != names.len() {
                let why = format!("{} columns, the header has {}", cells.len(), names.len());
                return Err(refuse(line, why));
            }
            let number = |cell: &str| match cell {
                "" => Ok(f64::NAN),
                _ => {
                    (cell.parse::<f64>()).map_err(|_| refuse(line, format!("{cell:?}: no number")))
                }
            };
            let mut frame = [0.0; INPUTS];
            for (value, cell) in frame.iter_mut().zip(&cells[1..]) {
                *value = number(cell)?;
            }
            let t_s = number(cells[0])?;
            if !(t_s.is_finite() && rows.last().is_none_or(|(before_s, _)| t_s > *before_s)) {
                return Err(refuse(line, "the time does not increase".into()));
            }
            rows.push((t_s, frame));
        }
        let (Some((first_s, _)), Some((last_s, _))) = (rows.first(), rows.last()) else {
            return Err(refuse(1, "no data after the header".into()));
        };
        let (first_s, last_s) = (*first_s, *last_s);
        let mut steps: Vec<f64> = rows.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
        steps.sort_by(f64::total_cmp);
        let usual_s = steps.get(steps.len() / 2).copied();
        let usual_s = usual_s.unwrap_or_else(|| scan_rate_hz.recip());
        let count = ((last_s - first_s) / usual_s).round();
        if count >= FRAMES_MAX as f64 {
            return Err(refuse(rows.len() as u64, "too long to be played".into()));
        }
        let spacing_s = match count > 0.0 {
            true => (last_s - first_s) / count,
            false => usual_s,
        };
        let mut frames = vec![None; count as usize + 1];
        for (t_s, frame) in rows {
            frames[((t_s - first_s) / spacing_s).round() as usize] = Some(frame);
        }
        Self::new(frames, spacing_s.recip(), scan_rate_hz)
    }

    /// Clock error in parts per million at which a scan lasts as long as a held frame; 0 if frames
    /// are resampled.
    pub fn clock_error_ppm(&self) -> f64 {
        match self.is_held() {
            true => 1e6 * (self.rate_hz / self.scan_rate_hz - 1.0),
            false => 0.0,
        }
    }

    fn is_held(&self) -> bool {
        (self.rate_hz / self.scan_rate_hz - 1.0).abs() <= HELD_FRACTION
    }

    /// Value of a reading; `None` if the frame or the reading is missing.
    fn reading(&self, frame: usize, input: usize) -> Option<f64> {
        let value = self.frames.get(frame)?.as_ref()?[input];
        (!value.is_nan()).then_some(value)
    }
}

impl Scene for Trace {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        let input = usize::from(input).min(INPUTS - 1);
        let last = self.frames.len() - 1;
        let at = (t_s * self.rate_hz).clamp(0.0, last as f64);
        let nearest = match self.is_held() {
            true => at as usize,
            false => at.round() as usize,
        };
        if self.frames[nearest].is_none() {
            return f64::NAN;
        }
        let Some(value) = self.reading(nearest, input) else {
            return f64::INFINITY;
        };
        if self.is_held() {
            return value;
        }
        let narrow = (self.scan_rate_hz / self.rate_hz).min(1.0);
        let half = ZEROS / narrow;
        let (from, to) = ((at - half).max(0.0) as usize, (at + half).ceil() as usize);
        let (mut sum, mut weights) = (0.0, 0.0);
        for frame in from..=to.min(last) {
            let Some(value) = self.reading(frame, input) else {
                continue;
            };
            let off = (frame as f64 - at) * narrow;
            let window = (FRAC_PI_2 * (off / ZEROS).clamp(-1.0, 1.0)).cos().powi(2);
            let weight = match off {
                0.0 => 1.0,
                _ => window * (PI * off).sin() / (PI * off),
            };
            sum += weight * value;
            weights += weight;
        }
        sum / weights
    }

    fn end_s(&self) -> f64 {
        self.frames.len() as f64 / self.rate_hz
    }
}
