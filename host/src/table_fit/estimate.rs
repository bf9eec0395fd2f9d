//! The one place that calls the estimator: how many frames it takes, and in which band.

use super::bridge;
use super::means::PASSED;
use super::scaled::Scaled;
use crate::digits::significant;
use crate::grid::Grid;
use crate::part::{Band, Selection};
use anyhow::{Result, bail, ensure};
use ridgetone_tone::{FRAMES_MAX, Fit, Fitter, FrameSpan, HARMONICS_MAX, Status, Table};

/// Blank cells are bridged where less than this share of the rows has all readings.
const WHOLE_SHARE_MIN: f64 = 0.95;

/// Fewest frames that a filter leaves.
const FRAMES_LEFT: usize = 64;

/// The estimator's answer.
pub struct Estimated {
    pub found: Fit,
    /// Places of the grid for each frame that was fitted.
    pub slots_per_frame: usize,
    /// What was done to the rows, and what was found outside of the band.
    pub note: Option<String>,
}

/// Frames, and what is known of them.
struct Frames<'a> {
    file: &'a str,
    scaled: &'a Scaled,
    places: &'a [f32],
    rate_hz: f64,
    selection: &'a Selection,
}

/// Fits all rows: more than the estimator takes at once through a low-pass filter.
pub fn estimate(
    file: &str,
    scaled: Scaled,
    places: &[f32],
    grid: &Grid,
    selection: &Selection,
) -> Result<Estimated> {
    let slots = scaled.values.len();
    let slots_per_frame = slots.div_ceil(FRAMES_MAX);
    if slots_per_frame == 1 {
        let frames = Frames {
            file,
            scaled: &scaled,
            places,
            rate_hz: grid.rate_hz,
            selection,
        };
        return frames.within(selection.band);
    }
    ensure!(
        places.is_empty(),
        "{file}: {slots} rows by place or at uneven times, and at most {FRAMES_MAX} of these are fitted together: choose a part with --from and --to, or windows with --window"
    );
    let (thinned, rate_hz) = (
        scaled.thinned(slots_per_frame),
        grid.rate_hz / slots_per_frame as f64,
    );
    let frames = Frames {
        file,
        scaled: &thinned,
        places,
        rate_hz,
        selection,
    };
    let most_hz = significant(PASSED * rate_hz, 3);
    let note = format!(
        "{slots} rows are fitted by a low-pass filter and every {slots_per_frame}th value of it: tones up to {most_hz} Hz; for faster ones take windows with --window"
    );
    let inner = frames.within(selection.band)?;
    Ok(Estimated {
        slots_per_frame: slots_per_frame * inner.slots_per_frame,
        note: Some(
            inner
                .note
                .map_or(note.clone(), |more| format!("{note}; {more}")),
        ),
        found: inner.found,
    })
}

impl Frames<'_> {
    /// Keeps to the band. This estimator has none: a comb below it is tried with fewer harmonics, a
    /// tone above it is filtered out, and what stays outside is no tone.
    fn within(&self, band: Band) -> Result<Estimated> {
        let harmonics = self.selection.harmonics.unwrap_or(HARMONICS_MAX as u8);
        let mut found = self.fit(harmonics)?;
        let mut slots_per_frame = 1;
        let Some(first_hz) = self.outside_hz(&found, band, slots_per_frame) else {
            return Ok(Estimated {
                found,
                slots_per_frame,
                note: None,
            });
        };
        let (filtered, slower);
        let mut frames = self;
        if let (true, Some(most_hz)) = (band.is_above(first_hz), band.most_hz) {
            let most = self.scaled.values.len() / FRAMES_LEFT;
            slots_per_frame = ((PASSED * self.rate_hz / most_hz) as usize).clamp(1, most.max(1));
            filtered = self.scaled.thinned(slots_per_frame);
            slower = Frames {
                scaled: &filtered,
                rate_hz: self.rate_hz / slots_per_frame as f64,
                ..*self
            };
            frames = &slower;
        }
        for harmonics in (1..=harmonics).rev() {
            found = frames.fit(harmonics)?;
            if self.outside_hz(&found, band, slots_per_frame).is_none() && found.status.has_tone() {
                break;
            }
        }
        let outside_hz = self.outside_hz(&found, band, slots_per_frame);
        if outside_hz.is_some() {
            found.status = Status::NoTone;
        }
        let note = (!found.status.has_tone()).then(|| {
            let hz = significant(outside_hz.unwrap_or(first_hz), 4);
            format!("a tone of {hz} Hz is outside of --least-hz and --most-hz")
        });
        Ok(Estimated {
            found,
            slots_per_frame,
            note,
        })
    }

    /// The frequency of a tone outside of the band.
    fn outside_hz(&self, found: &Fit, band: Band, slots_per_frame: usize) -> Option<f64> {
        let per_s = match self.places {
            [] => self.rate_hz / slots_per_frame as f64,
            _ => 1.0,
        };
        let hz = f64::from(found.frequency) * per_s;
        let is_outside = band.is_below(hz) || band.is_above(hz);
        (found.status.has_tone() && is_outside).then_some(hz)
    }

    /// The fit with single blank cells bridged, where that helps.
    fn fit(&self, harmonics: u8) -> Result<Fit> {
        // Few rows with blank cells cost less left out than bridged; and a fast tone cannot be
        // bridged.
        if self.places.is_empty() && self.scaled.whole_share() < WHOLE_SHARE_MIN {
            let bridged = self.scaled.bridged();
            let found = self.run(&bridged, harmonics)?;
            if found.status.has_tone() && f64::from(found.frequency) <= bridge::TONE_MAX {
                return Ok(with_readings(found, &bridged));
            }
        }
        let found = self.run(self.scaled, harmonics)?;
        Ok(with_readings(found, self.scaled))
    }

    fn run(&self, scaled: &Scaled, harmonics: u8) -> Result<Fit> {
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
        let place = |frame: u32| self.places.get(frame as usize).copied().unwrap_or(f32::NAN);
        if !self.places.is_empty() {
            let Some(along) = span.along(&place) else {
                match &selection.place {
                    Some(column) => bail!(
                        "{file}: by column {} the finger does not move in this part",
                        column.name()
                    ),
                    None => bail!("{file}: the time stands still in this part"),
                }
            };
            span = along;
        }
        let Ok(found) = Fitter::new(harmonics).fit(&mut span) else {
            bail!("{file}: the fit did not reach all rows");
        };
        Ok(found)
    }
}

/// With deviations that count bridged readings as none.
fn with_readings(mut found: Fit, scaled: &Scaled) -> Fit {
    let of_readings = scaled.sigma_factor(&found);
    for sigma in [
        &mut found.sigma,
        &mut found.movement.sigma_of_mean,
        &mut found.movement.wander_sigma,
        &mut found.movement.chirp_sigma,
    ] {
        *sigma *= of_readings;
    }
    found
}
