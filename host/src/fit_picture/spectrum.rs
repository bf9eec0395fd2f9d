//! Spectra of the readings and of the residual, with the tone's harmonics and the noise next to
//! them.

use super::channels::{Fitted, variance};
use crate::analysis::NEIGHBOURHOOD_CYCLES;
use crate::chart::strips::{Points, Strip};
use crate::chart::{Curve, Look, Panel, Scale};
use crate::digits::significant;
use crate::harmonics::{Frequencies, Reading, powers};
use crate::table_fit::TableFit;
use crate::tone::Domain;
use std::f64::consts::TAU;

/// Number of frequencies drawn.
const FREQUENCIES: usize = 880;

/// Number of frequencies drawn per bin; a bin is one cycle per window wide.
const PER_CYCLE: f64 = 2.0;

/// Multiple of the tone up to which the picture extends at least, limited to half the rate.
const HARMONICS_SHOWN: f64 = 8.0;

/// Lowest power that is drawn, decibels.
const DB_MIN: f64 = -140.0;

/// Values over the axis of the fit, and the variance that counts as 0 dB.
struct Series<'a> {
    points: &'a Points,
    variance: f64,
}

/// Returns the panel; `None` if there is nothing to analyse.
pub fn panel(fitted: &Fitted, fit: &TableFit) -> Option<Panel> {
    let half_rate = 0.5 * fitted.density;
    let tone = fit.tone.frequency().map(|found| found.value);
    let wanted = tone.map_or(half_rate, |tone| {
        tone * HARMONICS_SHOWN.max(f64::from(fit.harmonics) + 1.5)
    });
    let max = wanted.min(half_rate);
    let channels = fitted.strips.iter().zip(&fit.channels);
    let usable = channels.filter(|(_, found)| found.usable);
    let strips: Vec<_> = usable.map(|(strip, _)| strip).collect();
    if strips.is_empty() || !(max > 0.0 && max.is_finite()) {
        return None;
    }
    let windows = Windows::new(fitted, max);
    let spectrum = |points: &dyn Fn(&'_ Strip) -> &'_ Points| {
        let series = strips.iter().map(|strip| Series {
            points: points(strip),
            variance: variance(&strip.readings),
        });
        let known: Vec<_> = series.filter(|series| !series.points.is_empty()).collect();
        (!known.is_empty()).then(|| windows.spectrum(&known))
    };
    let readings = spectrum(&|strip| &strip.readings)?;
    let residual = spectrum(&|strip| &strip.residual);
    let mut levels: Vec<f64> = readings
        .iter()
        .chain(residual.iter().flatten())
        .map(|(_, db)| *db)
        .collect();
    levels.sort_by(f64::total_cmp);
    let top = readings.iter().map(|(_, db)| *db).fold(-3.0, f64::max) + 6.0;
    // Ignore the lowest 5 % of the levels, which are deep gaps between lines.
    let bottom = levels[levels.len() / 20] - 6.0;
    let mut curves = vec![curve("readings", Look::Data, readings)];
    if let (Some(residual), Some(tone)) = (residual, tone) {
        curves.push(curve("residual", Look::Line(0), residual.clone()));
        let reach = NEIGHBOURHOOD_CYCLES / windows.length;
        let mut names = [
            "the tone and its harmonics",
            "noise next to them, the median",
        ];
        let harmonics = (1..=fit.harmonics).map(|k| f64::from(k) * tone);
        for frequency in harmonics.filter(|frequency| *frequency <= max) {
            let line = [DB_MIN, top].map(|db| (frequency, db));
            curves.push(curve(names[0], Look::Reference, line.into()));
            let Some(noise_db) = around(&residual, frequency, reach) else {
                continue;
            };
            let ends = [(frequency - reach).max(0.0), (frequency + reach).min(max)];
            let level = ends.map(|at| (at, noise_db));
            curves.push(curve(names[1], Look::Marked(1), level.into()));
            // Name each curve in the key only once.
            names = [""; 2];
        }
    }
    let unit = match fit.domain {
        Domain::Time => "frequency, Hz",
        Domain::Position => "frequency, cycles per mm",
    };
    let half = if max < half_rate {
        format!(" (up to {} by the rows)", significant(half_rate, 4))
    } else {
        String::new()
    };
    let scale = |label: String, range| Scale {
        label,
        range: Some(range),
        ..Scale::default()
    };
    Some(Panel {
        title: "Spectrum, mean of the channels".into(),
        x: scale(format!("{unit}{half}"), (0.0, max)),
        y: scale(
            "fraction of a channel's power in a line, dB".into(),
            (bottom.max(DB_MIN), top),
        ),
        curves,
        shades: None,
    })
}

fn curve(name: &str, look: Look, points: Points) -> Curve {
    Curve {
        name: name.into(),
        look,
        points,
    }
}

/// Returns the median of a spectrum around a frequency.
fn around(spectrum: &Points, frequency: f64, reach: f64) -> Option<f64> {
    let inside = spectrum
        .iter()
        .filter(|(at, _)| (at - frequency).abs() <= reach);
    let mut found: Vec<f64> = inside.map(|(_, db)| *db).collect();
    found.sort_by(f64::total_cmp);
    found.get(found.len() / 2).copied()
}

/// Windows of one length over the rows, overlapping by half, with a Hann taper.
struct Windows {
    starts: Vec<f64>,
    length: f64,
    /// Spacing of the frequencies.
    step: f64,
}

impl Windows {
    /// Makes windows just long enough to resolve the picture's frequencies, up to `max`.
    fn new(fitted: &Fitted, max: f64) -> Self {
        let all = fitted.range.end() - fitted.range.start();
        let length = (FREQUENCIES as f64 / PER_CYCLE / max).min(all);
        let count = (2.0 * all / length).floor().max(2.0) as usize - 1;
        let gap = (all - length) / (count.max(2) - 1) as f64;
        let start = |number| fitted.range.start() + gap * number as f64;
        Self {
            starts: (0..count).map(start).collect(),
            length,
            step: max / FREQUENCIES as f64,
        }
    }

    /// Returns the mean power over windows and series at evenly spaced frequencies, in decibels: 0
    /// for a line with all the power. Leaves out the baseline at zero.
    fn spectrum(&self, all: &[Series<'_>]) -> Points {
        let mut power = vec![0.0; FREQUENCIES + 1];
        let mut count = 0.0;
        for series in all.iter().filter(|series| series.variance > 0.0) {
            for start in &self.starts {
                count += f64::from(u8::from(self.add(series, *start, &mut power)));
            }
        }
        let decibel = |power: f64| (10.0 * (power / f64::max(count, 1.0)).log10()).max(DB_MIN);
        let at = |(k, power): (usize, f64)| (k as f64 * self.step, decibel(power));
        power.into_iter().enumerate().skip(1).map(at).collect()
    }

    /// Adds the power of a series in one window; returns false if the window has no row.
    fn add(&self, Series { points, variance }: &Series<'_>, start: f64, power: &mut [f64]) -> bool {
        let mean = points.iter().map(|(_, value)| value).sum::<f64>() / points.len() as f64;
        let mut weights = 0.0;
        let inside = points.iter().map(|(at, value)| (at - start, value - mean));
        let inside = inside.filter(|(at, _)| (0.0..=self.length).contains(at));
        let readings = inside.map(|(at, value)| {
            let weight = 0.5 - 0.5 * (TAU * at / self.length).cos();
            weights += weight;
            let value = weight * value;
            Reading { at, value }
        });
        let frequencies = Frequencies {
            first: 0.0,
            step: self.step,
            count: power.len(),
        };
        let squares = powers(readings, frequencies);
        if weights <= 0.0 {
            return false;
        }
        // A line of amplitude a has the variance a^2 / 2, and its weighted sum is a / 2 times the
        // sum of weights.
        let scale = 2.0 / (weights * weights * variance);
        for (power, square) in power.iter_mut().zip(squares) {
            *power += scale * square;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_all_the_power_and_is_where_it_is_at_uneven_times_too() {
        for unevenness in [0.0, 0.004] {
            let at = |row| 0.01 * f64::from(row) + unevenness * f64::from(row % 7) / 7.0;
            let wave = |at: f64| (at, (TAU * 8.3 * at).sin());
            let points = (0..4000).map(|row| wave(at(row))).collect();
            let windows = Windows {
                starts: vec![0.0, 10.0, 20.0],
                length: 20.0,
                step: 22.0 / FREQUENCIES as f64,
            };
            let series = Series {
                points: &points,
                variance: 0.5,
            };
            let found = windows.spectrum(&[series]);
            let highest = found.iter().max_by(|a, b| a.1.total_cmp(&b.1));
            let (highest, db) = *highest.unwrap();
            assert!((highest - 8.3).abs() < 0.02, "{highest}");
            assert!(db.abs() < 0.1, "{db}");
            assert!(around(&found, 15.0, 0.5).unwrap() < -60.0);
        }
    }
}
