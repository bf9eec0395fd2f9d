//! Spectra of the readings and of what the fit leaves, with the tone's harmonics and the noise next
//! to them.

use super::channels::Fitted;
use crate::analysis::NEIGHBOURHOOD_CYCLES;
use crate::chart::{Curve, Look, Panel, Scale};
use crate::digits::significant;
use crate::harmonics::{Frequencies, Reading, powers};
use crate::table_fit::TableFit;
use crate::tone::Domain;
use std::f64::consts::TAU;

/// Frequencies that are drawn.
const FREQUENCIES: usize = 880;

/// Frequencies in the width of a cycle a window.
const PER_CYCLE: f64 = 2.0;

/// Harmonics' widths up to which there is room in the picture, if half the rate is far above.
const HARMONICS_SHOWN: f64 = 8.0;

/// Least power that is drawn, decibels.
const LEAST_DB: f64 = -140.0;

/// Power at evenly spaced frequencies from zero on, decibels: 0 for a line that is all there is.
struct Spectrum {
    step: f64,
    power_db: Vec<f64>,
}

impl Spectrum {
    fn points(&self) -> Vec<(f64, f64)> {
        let at = |(k, db): (usize, &f64)| (k as f64 * self.step, *db);
        // The baseline is at zero.
        self.power_db.iter().enumerate().skip(1).map(at).collect()
    }

    /// The median around a frequency.
    fn around(&self, frequency: f64, reach: f64) -> Option<f64> {
        let inside = |point: &(f64, f64)| (point.0 - frequency).abs() <= reach;
        let mut found: Vec<f64> = self
            .points()
            .into_iter()
            .filter(inside)
            .map(|(_, db)| db)
            .collect();
        found.sort_by(f64::total_cmp);
        found.get(found.len() / 2).copied()
    }
}

/// A series to be analysed: its values, and the power that counts as all.
struct Series<'a> {
    values: Vec<f64>,
    at: &'a [f64],
    variance: f64,
}

/// The panel; none if there is nothing to analyse.
pub fn panel(fitted: &Fitted, fit: &TableFit) -> Option<Panel> {
    let half_rate = 0.5 * fitted.density;
    let tone = fit.tone.frequency().map(|found| found.value);
    let wanted = tone.map_or(half_rate, |tone| {
        tone * HARMONICS_SHOWN.max(f64::from(fit.harmonics) + 1.5)
    });
    let most = wanted.min(half_rate);
    let usable = fitted
        .channels
        .iter()
        .zip(&fit.channels)
        .filter(|(_, found)| found.usable);
    let usable: Vec<_> = usable.map(|(channel, _)| channel).collect();
    if usable.is_empty() || !(most > 0.0 && most.is_finite()) {
        return None;
    }
    let windows = Windows::new(fitted, most);
    let readings = usable.iter().map(|channel| Series {
        // A missing reading is as the mean.
        values: about_mean(&channel.readings),
        at: &fitted.at,
        variance: channel.variance,
    });
    let data = windows.spectrum(readings.collect());
    let residuals = usable.iter().filter_map(|channel| {
        Some(Series {
            values: channel.residual.clone()?,
            at: &fitted.at,
            variance: channel.variance,
        })
    });
    let residuals: Vec<Series<'_>> = residuals.collect();
    let residual = (!residuals.is_empty()).then(|| windows.spectrum(residuals));
    Some(drawn(&data, residual.as_ref(), &windows, fit))
}

fn drawn(data: &Spectrum, residual: Option<&Spectrum>, windows: &Windows, fit: &TableFit) -> Panel {
    let mut curves = vec![Curve {
        name: "readings".into(),
        look: Look::Data,
        points: data.points(),
    }];
    let top = data.power_db.iter().skip(1).copied().fold(-3.0, f64::max) + 6.0;
    let mut levels = data.points();
    if let (Some(residual), Some(tone)) = (residual, fit.tone.frequency()) {
        levels.extend(residual.points());
        curves.push(Curve {
            name: "residual".into(),
            look: Look::Line(0),
            points: residual.points(),
        });
        let harmonics = (1..=fit.harmonics)
            .map(|k| f64::from(k) * tone.value)
            .filter(|frequency| *frequency <= windows.most);
        let reach = NEIGHBOURHOOD_CYCLES / windows.length;
        for (number, frequency) in harmonics.enumerate() {
            let named = |name: &str| match number {
                0 => name.to_owned(),
                _ => String::new(),
            };
            curves.push(Curve {
                name: named("the tone and its harmonics"),
                look: Look::Reference,
                points: vec![(frequency, LEAST_DB), (frequency, top)],
            });
            let Some(noise_db) = residual.around(frequency, reach) else {
                continue;
            };
            let ends = [
                (frequency - reach).max(0.0),
                (frequency + reach).min(windows.most),
            ];
            curves.push(Curve {
                name: named("noise next to them, the median"),
                look: Look::Marked(1),
                points: ends.map(|at| (at, noise_db)).into(),
            });
        }
    }
    let mut low: Vec<f64> = levels.into_iter().map(|(_, db)| db).collect();
    low.sort_by(f64::total_cmp);
    // The deepest gaps between lines say nothing.
    let bottom = low.get(low.len() / 20).copied().unwrap_or(LEAST_DB) - 6.0;
    let unit = match fit.domain {
        Domain::Time => "frequency, Hz",
        Domain::Position => "frequency, cycles per mm",
    };
    let half = if windows.most < windows.half_rate {
        format!(" (up to {} by the rows)", significant(windows.half_rate, 4))
    } else {
        String::new()
    };
    Panel {
        title: "Spectrum, mean of the channels".into(),
        x: Scale {
            label: format!("{unit}{half}"),
            range: Some((0.0, windows.most)),
            ..Scale::default()
        },
        y: Scale {
            label: "share of a channel's power in a line, dB".into(),
            range: Some((bottom.max(LEAST_DB), top)),
            ..Scale::default()
        },
        curves,
    }
}

fn about_mean(readings: &[Option<f32>]) -> Vec<f64> {
    let known = readings.iter().flatten().map(|value| f64::from(*value));
    let mean = known.clone().sum::<f64>() / (known.count().max(1) as f64);
    let about = |reading: &Option<f32>| reading.map_or(0.0, |value| f64::from(value) - mean);
    readings.iter().map(about).collect()
}

/// Windows of one length over the rows, half over one another, with a Hann taper each.
struct Windows {
    /// First horizontal coordinate of each.
    starts: Vec<f64>,
    length: f64,
    /// The highest frequency, and half the mean density of the rows.
    most: f64,
    half_rate: f64,
    step: f64,
}

impl Windows {
    /// Windows in which the frequencies of the picture are as close as they can tell them apart.
    fn new(fitted: &Fitted, most: f64) -> Self {
        let range = fitted.range();
        let all = range.to - range.from;
        let length = (FREQUENCIES as f64 / PER_CYCLE / most).min(all);
        let count = (2.0 * all / length).floor().max(2.0) as usize - 1;
        let gap = (all - length) / (count.max(2) - 1) as f64;
        Self {
            starts: (0..count).map(|at| range.from + gap * at as f64).collect(),
            length,
            most,
            half_rate: 0.5 * fitted.density,
            step: most / FREQUENCIES as f64,
        }
    }

    /// The mean power over windows and series.
    fn spectrum(&self, all: Vec<Series<'_>>) -> Spectrum {
        let mut power = vec![0.0; FREQUENCIES + 1];
        let mut count = 0.0;
        for series in all.iter().filter(|series| series.variance > 0.0) {
            for start in &self.starts {
                count += f64::from(u8::from(self.add(series, *start, &mut power)));
            }
        }
        let decibel = |power: f64| (10.0 * (power / f64::max(count, 1.0)).log10()).max(LEAST_DB);
        Spectrum {
            step: self.step,
            power_db: power.into_iter().map(decibel).collect(),
        }
    }

    /// Adds the power of a series in one window; false if no row is in it.
    fn add(&self, series: &Series<'_>, start: f64, power: &mut [f64]) -> bool {
        let mut weights = 0.0;
        let readings = series
            .at
            .iter()
            .zip(&series.values)
            .filter_map(|(at, value)| {
                let from_start = at - start;
                let is_inside = (0.0..=self.length).contains(&from_start);
                let weight = 0.5 - 0.5 * (TAU * from_start / self.length).cos();
                is_inside.then(|| {
                    weights += weight;
                    Reading {
                        at: from_start,
                        value: weight * value,
                    }
                })
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
        // A line of amplitude a has the variance a^2 / 2, and half of a in its sum.
        let scale = 2.0 / (weights * weights * series.variance);
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
            let at: Vec<f64> = (0..4000)
                .map(|row| 0.01 * f64::from(row) + unevenness * f64::from(row % 7) / 7.0)
                .collect();
            let values: Vec<f64> = at.iter().map(|at| (TAU * 8.3 * at).sin()).collect();
            let windows = Windows {
                starts: vec![0.0, 10.0, 20.0],
                length: 20.0,
                most: 22.0,
                half_rate: 50.0,
                step: 22.0 / FREQUENCIES as f64,
            };
            let series = Series {
                values,
                at: &at,
                variance: 0.5,
            };
            let found = windows.spectrum(vec![series]);
            let (highest, db) = found
                .points()
                .into_iter()
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap();
            assert!((highest - 8.3).abs() < 0.02, "{highest}");
            assert!(db.abs() < 0.1, "{db}");
            assert!(found.around(15.0, 0.5).unwrap() < -60.0);
        }
    }
}
