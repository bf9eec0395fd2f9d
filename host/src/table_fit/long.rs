//! Fits recordings with more rows than the estimator takes at once.
//!
//! Windows at the original rate find the tone, so that it cannot be an alias. A slow tone is then
//! fitted to all rows after decimation by n; a faster tone is first shifted to a low frequency by
//! multiplying all rows by a sine.

use super::estimate::{Estimated, Frames, Motion};
use super::means::PASSED;
use super::scaled::{Channels, Scaled};
use crate::digits::significant;
use crate::grid::Grid;
use crate::part::{Band, Selection};
use anyhow::{Result, ensure};
use ridgetone_tone::{FRAMES_MAX, Fit, OtherTone, Status};
use std::f64::consts::TAU;

/// Number of rows in a window that is searched for the tone.
const SEARCHED_MAX: usize = 32_768;

/// Frequency to which a fast tone is shifted, as a fraction of the decimated rate.
const SHIFTED_TO: f64 = 0.22;

/// Half-width of the band around a shifted tone, as a fraction of the decimated rate.
const SHIFTED_BAND: f64 = 0.12;

/// Minimum power of a slower tone relative to a faster one, for the slower tone to be reported.
const NAMED_POWER: f64 = 0.05;

/// Fits all rows; if there are more than the estimator takes at once, they are decimated.
pub fn estimate(
    file: &str,
    channels: &Channels,
    motion: &Motion,
    grid: &Grid,
    selection: &Selection,
) -> Result<Estimated> {
    let slots = channels.slots();
    if slots > FRAMES_MAX {
        ensure!(
            motion.positions.is_empty(),
            "{file}: {slots} rows by position or at uneven times, and at most {FRAMES_MAX} of these are fitted together: choose a part with --from and --to, or windows with --window"
        );
        return estimate_long(file, channels, grid.rate_hz, selection);
    }
    let frames = Frames {
        file,
        scaled: &channels.cut(0..slots),
        motion,
        rate_hz: grid.rate_hz,
        selection,
        band: selection.band,
    };
    let found = frames.named(frames.fit()?)?;
    let note = frames.outside(&found)?;
    Ok(Estimated::of(found, note))
}

/// Fits more rows than the estimator takes.
fn estimate_long(
    file: &str,
    channels: &Channels,
    rate_hz: f64,
    selection: &Selection,
) -> Result<Estimated> {
    let slots = channels.slots();
    let slots_per_frame = slots.div_ceil(SEARCHED_MAX);
    let thin_hz = rate_hz / slots_per_frame as f64;
    let still = Motion::still();
    let fit = |scaled: &Scaled, rate_hz: f64, band: Band| -> Result<(Fit, Option<String>)> {
        let frames = Frames {
            file,
            scaled,
            motion: &still,
            rate_hz,
            selection,
            band,
        };
        let found = frames.fit()?;
        let outside = frames.outside(&found)?;
        Ok((found, outside))
    };
    let max_hz = PASSED * thin_hz;
    let window_s = SEARCHED_MAX as f64 / rate_hz;
    // Search the middle first; a tone may also be only in the first or last window.
    let mut window: Option<Fit> = None;
    for from in [(slots - SEARCHED_MAX) / 2, 0, slots - SEARCHED_MAX] {
        let (found, _) = fit(
            &channels.cut(from..from + SEARCHED_MAX),
            rate_hz,
            selection.band,
        )?;
        if found.status.has_tone() {
            window = Some(found);
            break;
        }
    }
    let fast = window
        .clone()
        .filter(|found| f64::from(found.frequency) * rate_hz > max_hz);
    let is_slow = selection.band.min_hz.is_none_or(|min_hz| min_hz < max_hz);
    let slow = is_slow
        .then(|| {
            let thinned = channels.thinned(slots_per_frame, &|_, values| *values);
            fit(&thinned, thin_hz, selection.band)
        })
        .transpose()?;
    let power = |found: &Fit| -> f64 {
        let usable = found
            .channels
            .iter()
            .enumerate()
            .filter(|(c, _)| found.usable & 1 << c != 0);
        usable
            .map(|(_, channel)| f64::from(channel.amplitude).powi(2))
            .sum()
    };
    let slow_tone = slow
        .as_ref()
        .map(|(found, _)| found)
        .filter(|found| found.status.has_tone());
    let slow_power = slow_tone.map_or(0.0, power);
    let Some(fast) = fast.filter(|fast| power(fast) >= slow_power) else {
        let Some((found, outside)) = slow else {
            let found = window.unwrap_or_else(|| Fit::without_tone(Status::NoTone, 0));
            return Ok(Estimated::of(
                found,
                Some(format!("no tone lasts through {slots} rows")),
            ));
        };
        let note = match (found.status.has_tone(), &window) {
            (true, _) => format!(
                "{slots} rows are fitted by a low-pass filter and one value in {slots_per_frame} of it; no stronger tone above {} Hz is in windows of {} s",
                significant(max_hz, 3),
                significant(window_s, 3)
            ),
            (false, Some(window)) => {
                let hz = significant(f64::from(window.frequency) * rate_hz, 5);
                let note = format!(
                    "a tone of {hz} Hz in a window of {} s does not last through all {slots} rows: fit windows with --window",
                    significant(window_s, 3)
                );
                let mut window = window.clone();
                window.status = Status::Unsteady;
                return Ok(Estimated::of(window, Some(note)));
            }
            (false, None) => format!(
                "no tone up to {} Hz in all {slots} rows, and none above it in three windows of {} s; a weaker or shorter one may be found with --window",
                significant(max_hz, 3),
                significant(window_s, 3)
            ),
        };
        let note = outside.map_or(note.clone(), |outside| format!("{note}; {outside}"));
        return Ok(Estimated {
            slots_per_frame,
            ..Estimated::of(found, Some(note))
        });
    };
    // Difference between the tone and the shifted tone, cycles per row.
    let shift = f64::from(fast.frequency) - SHIFTED_TO / slots_per_frame as f64;
    let levels = channels.levels();
    let shifted = channels.shifted(shift, &levels, slots_per_frame);
    let band = Band {
        min_hz: Some((SHIFTED_TO - SHIFTED_BAND) * thin_hz),
        max_hz: Some((SHIFTED_TO + SHIFTED_BAND) * thin_hz),
    };
    let alone = Selection {
        harmonics: Some(1),
        interferer_hz: None,
        ..selection.clone()
    };
    let frames = Frames {
        file,
        scaled: &shifted,
        motion: &still,
        rate_hz: thin_hz,
        selection: &alone,
        band,
    };
    let mut found = frames.fit()?;
    let hz = significant(f64::from(fast.frequency) * rate_hz, 5);
    if !found.status.has_tone() {
        let note = format!(
            "a tone of {hz} Hz in a window of {} s does not last through all {slots} rows: fit windows with --window",
            significant(window_s, 3)
        );
        let mut window = fast;
        window.status = Status::Unsteady;
        return Ok(Estimated::of(window, Some(note)));
    }
    for (channel, level) in found.channels.iter_mut().zip(levels) {
        channel.offset = level as f32;
    }
    let aliased = |slow: &Fit| {
        let (own, alias) = (
            f64::from(slow.frequency) * thin_hz,
            f64::from(fast.frequency) * rate_hz,
        );
        let folded = (alias / thin_hz - (alias / thin_hz).round()).abs() * thin_hz;
        (own - folded).abs() < 0.01 * thin_hz
    };
    found.other_tone = None;
    if let Some(slow) = slow_tone
        && slow_power > NAMED_POWER * power(&fast)
        && !aliased(slow)
    {
        // Convert to the units of the shifted tone.
        found.other_tone = Some(OtherTone {
            frequency: slow.frequency - (shift * slots_per_frame as f64) as f32,
            fraction: (slow_power / power(&fast)) as f32,
        });
    }
    found.harmonics = 1;
    let note = format!(
        "{slots} rows are fitted around {hz} Hz, the tone of a window of {} s, through a filter and one value in {slots_per_frame} of it; residuals are those of the filter",
        significant(window_s, 3)
    );
    Ok(Estimated {
        slots_per_frame,
        shift: shift * slots_per_frame as f64,
        ..Estimated::of(found, Some(note))
    })
}

impl Channels<'_> {
    fn levels(&self) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.units.len()];
        self.each(0..self.slots(), &mut |_, values, valid| {
            for (c, (sum, count)) in sums.iter_mut().enumerate() {
                if valid & 1 << c != 0 {
                    *sum += f64::from(values[c]);
                    *count += 1.0;
                }
            }
        });
        sums.into_iter()
            .map(|(sum, count)| sum / f64::max(count, 1.0))
            .collect()
    }

    /// Lowers all frequencies by `by`, cycles per row: multiplies the readings about their mean by
    /// a cosine whose phase is 0 at the centre, and decimates.
    fn shifted(&self, by: f64, levels: &[f64], slots_per_frame: usize) -> Scaled {
        let centre = 0.5 * (self.slots() - 1) as f64;
        self.thinned(slots_per_frame, &|slot, values| {
            let cosine = 2.0 * (TAU * (by * (slot as f64 - centre)).fract()).cos();
            let mut shifted = *values;
            for (value, level) in shifted.iter_mut().zip(levels) {
                *value = ((f64::from(*value) - level) * cosine) as f32;
            }
            shifted
        })
    }
}
