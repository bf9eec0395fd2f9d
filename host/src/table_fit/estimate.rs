//! The one place that calls the estimator: how many frames it takes, and which scene.

use super::bridge;
use super::means::PASSED;
use super::scaled::Scaled;
use crate::digits::significant;
use crate::grid::Grid;
use crate::part::{Band, Selection};
use anyhow::{Result, bail, ensure};
use ridgetone_tone::{FRAMES_MAX, Fit, Fitter, FrameSpan, HARMONICS_MAX, Scene, Table, Values};

/// Blank cells are bridged where less than this share of the rows has all readings.
const WHOLE_SHARE_MIN: f64 = 0.95;

/// The estimator's answer.
pub struct Estimated {
    pub found: Fit,
    /// Places of the grid for each frame that was fitted.
    pub slots_per_frame: usize,
    /// What was done to the rows, and what was found outside of the band.
    pub note: Option<String>,
}

/// Where the finger is while the frames are read.
pub struct Motion {
    /// Position of each frame; none to fit by time.
    pub positions: Vec<f32>,
    /// Delays of the readings, where these are known.
    pub delays: Option<Delays>,
}

/// Delays of the readings against the positions of their frames.
pub struct Delays {
    /// Frames by which each column is read after its frame's position.
    pub skew_frames: Values,
    /// Time constant of the low-pass before the converter, frames.
    pub low_pass_frames: f32,
}

/// Frames, and what is known of them.
struct Frames<'a> {
    file: &'a str,
    scaled: &'a Scaled,
    motion: &'a Motion,
    rate_hz: f64,
    selection: &'a Selection,
    band: Band,
}

/// Fits all rows: more than the estimator takes at once through a low-pass filter.
pub fn estimate(
    file: &str,
    scaled: Scaled,
    motion: &Motion,
    grid: &Grid,
    selection: &Selection,
) -> Result<Estimated> {
    let slots = scaled.values.len();
    let slots_per_frame = slots.div_ceil(FRAMES_MAX);
    if slots_per_frame == 1 {
        let frames = Frames {
            file,
            scaled: &scaled,
            motion,
            rate_hz: grid.rate_hz,
            selection,
            band: selection.band,
        };
        let found = frames.fit()?;
        return Ok(Estimated {
            note: frames.outside(&found)?,
            found,
            slots_per_frame,
        });
    }
    ensure!(
        motion.positions.is_empty(),
        "{file}: {slots} rows by position or at uneven times, and at most {FRAMES_MAX} of these are fitted together: choose a part with --from and --to, or windows with --window"
    );
    let (thinned, rate_hz) = (
        scaled.thinned(slots_per_frame),
        grid.rate_hz / slots_per_frame as f64,
    );
    let frames = Frames {
        file,
        scaled: &thinned,
        motion,
        rate_hz,
        selection,
        band: selection.band,
    };
    let max_hz = significant(PASSED * rate_hz, 3);
    let note = format!(
        "{slots} rows are fitted by a low-pass filter and every {slots_per_frame}th value of it: tones up to {max_hz} Hz; for faster ones take windows with --window"
    );
    let found = frames.fit()?;
    let note = match frames.outside(&found)? {
        Some(outside) => format!("{note}; {outside}"),
        None => note,
    };
    Ok(Estimated {
        found,
        slots_per_frame,
        note: Some(note),
    })
}

impl Frames<'_> {
    /// The unit of frequencies: in frames along time they are cycles per frame.
    fn unit_hz(&self) -> f64 {
        if self.motion.positions.is_empty() {
            self.rate_hz
        } else {
            1.0
        }
    }

    /// Where the band has no tone: which one is outside of it.
    fn outside(&self, found: &Fit) -> Result<Option<String>> {
        if self.band.is_open() || found.status.has_tone() {
            return Ok(None);
        }
        let open = Self {
            band: Band::default(),
            ..*self
        };
        let other = open.fit()?;
        Ok(other.status.has_tone().then(|| {
            let hz = significant(f64::from(other.frequency) * self.unit_hz(), 4);
            format!("a tone of {hz} Hz is outside of --min-hz and --max-hz")
        }))
    }

    fn scene(&self) -> Scene {
        let Band { min_hz, max_hz } = self.band;
        let unit_hz = self.unit_hz();
        let bound = |hz: Option<f64>| hz.map_or(0.0, |hz| (hz / unit_hz) as f32);
        let harmonics = self.selection.harmonics.unwrap_or(HARMONICS_MAX as u8);
        Scene {
            band: ridgetone_tone::Band {
                least: bound(min_hz),
                most: bound(max_hz),
            },
            ..ridgetone_finger::scene(&self.selection.declared, harmonics)
        }
    }

    /// The fit with single blank cells bridged, where that helps.
    fn fit(&self) -> Result<Fit> {
        // Few rows with blank cells cost less left out than bridged; and a fast tone cannot be
        // bridged.
        if self.motion.positions.is_empty() && self.scaled.whole_share() < WHOLE_SHARE_MIN {
            let bridged = self.scaled.bridged();
            let found = self.run(&bridged)?;
            if found.status.has_tone() && f64::from(found.frequency) <= bridge::TONE_MAX {
                return Ok(found);
            }
        }
        self.run(self.scaled)
    }

    fn run(&self, scaled: &Scaled) -> Result<Fit> {
        let (file, selection) = (self.file, self.selection);
        let mut source = Table {
            values: &scaled.values,
            valid: &scaled.valid,
        };
        let frames = scaled.values.len() as u32;
        let mut span = FrameSpan::new(&mut source, 0, frames).with_quantization(1.0);
        if let Some(interferer_hz) = selection.interferer_hz {
            span = span.with_interferer((interferer_hz / self.rate_hz) as f32);
        }
        let positions = &self.motion.positions;
        let position = |frame: u32| positions.get(frame as usize).copied().unwrap_or(f32::NAN);
        if !self.motion.positions.is_empty() {
            let Some(along) = span.along(&position) else {
                match &selection.position {
                    Some(column) => bail!(
                        "{file}: by column {} the finger does not move in this part",
                        column.name()
                    ),
                    None => bail!("{file}: the time stands still in this part"),
                }
            };
            span = along;
        }
        let (mut fitter, scene) = (Box::new(Fitter::new()), self.scene());
        let delays = self.motion.delays.as_ref();
        let found = match delays.filter(|_| !positions.is_empty()) {
            Some(delays) => {
                let delays = ridgetone_tone::Delays {
                    frames: delays.skew_frames,
                    low_pass: delays.low_pass_frames,
                };
                fitter.fit_delayed(&mut span, &scene, &delays)
            }
            None => fitter.fit(&mut span, &scene),
        };
        let Ok(found) = found else {
            bail!("{file}: the fit did not reach all rows");
        };
        Ok(found)
    }
}
