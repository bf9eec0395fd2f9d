//! The frequency over time, from fits of windows: as a picture with a spectrogram, and as labels
//! for Audacity and Praat.

use crate::chart::{Curve, Look, Panel, Scale, Shades, chart};
use crate::digits::uncertain;
use crate::names::name;
use crate::overview::{RANGE_DB, Recorded, Spectrogram};
use crate::tone::Domain;
use crate::windows::Window;
use ridgetone_proto::telemetry::Status;
use serde::Serialize;
use std::fmt::Write;

/// Half-width of a 95 % interval, standard deviations.
const INTERVAL: f64 = 1.96;

/// Ratio of the top of the picture to the highest frequency found.
const HEADROOM: f64 = 2.5;

/// The fit of a window, in time.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    pub from_s: f64,
    pub to_s: f64,
    pub status: Status,
    pub frequency_hz: Option<f64>,
    pub sigma_hz: Option<f64>,
}

impl Point {
    /// Returns the result of a window; `None` if it was not fitted, or was fitted by position.
    pub fn of(window: &Window) -> Option<Self> {
        let fit = window.fit.as_ref().ok()?;
        let found = fit.tone.frequency();
        (fit.domain == Domain::Time).then_some(Self {
            from_s: fit.from_s,
            to_s: fit.to_s,
            status: fit.status,
            frequency_hz: found.map(|found| found.value),
            sigma_hz: found.map(|found| found.sigma),
        })
    }

    fn middle_s(&self) -> f64 {
        0.5 * (self.from_s + self.to_s)
    }

    /// Returns a label with the frequency, and the status unless it is good; `None` without a tone.
    fn label(&self) -> Option<String> {
        let found = uncertain(self.frequency_hz?, self.sigma_hz?);
        Some(match self.status {
            Status::Good => format!("{found} Hz"),
            status => format!("{found} Hz ({})", name(status)),
        })
    }
}

/// The fitted windows of a recording, and its spectrogram.
#[derive(Clone, Debug, Serialize)]
pub struct Track {
    pub points: Vec<Point>,
    pub spectrogram: Spectrogram,
}

impl Track {
    /// Creates a track. The spectrogram extends to `HEADROOM` times the highest frequency of a good
    /// window, but at most to half the row rate; to half the row rate if no window is good.
    pub fn new(points: Vec<Point>, recorded: &Recorded, window_s: f64) -> Self {
        let good = points.iter().filter(|point| point.status == Status::Good);
        let highest = good
            .filter_map(|point| point.frequency_hz)
            .fold(0.0, f64::max);
        let half_rate = 0.5 * recorded.rate_hz();
        let max_hz = match highest > 0.0 {
            true => half_rate.min(HEADROOM * highest),
            false => half_rate,
        };
        Self {
            points,
            spectrogram: recorded.spectrogram(window_s, max_hz),
        }
    }

    pub fn picture(&self, file: &str) -> String {
        let good = |point: &&Point| point.status == Status::Good;
        let known = |points: Vec<&Point>| -> Vec<(f64, f64)> {
            let at = |point: &&Point| Some((point.middle_s(), point.frequency_hz?));
            points.iter().filter_map(at).collect()
        };
        let mut curves = vec![
            Curve {
                name: "good windows".into(),
                look: Look::Dots(1),
                points: known(self.points.iter().filter(good).collect()),
            },
            Curve {
                name: "windows that are not good".into(),
                look: Look::Dots(3),
                points: known(self.points.iter().filter(|p| !good(p)).collect()),
            },
        ];
        // The legend shows only curves that have points.
        curves.retain(|curve| !curve.points.is_empty());
        let bars = self.points.iter().filter(good).filter_map(|point| {
            let (hz, sigma) = (point.frequency_hz?, point.sigma_hz?);
            let ends = [-INTERVAL, INTERVAL].map(|k| (point.middle_s(), hz + k * sigma));
            Some(ends.to_vec())
        });
        curves.extend(bars.enumerate().map(|(at, points)| Curve {
            name: if at == 0 {
                "95 % interval".into()
            } else {
                String::new()
            },
            look: Look::Line(1),
            points,
        }));
        let Spectrogram {
            from_s,
            until_s,
            max_hz,
            ref levels,
            ..
        } = self.spectrogram;
        let scale = |label: &str, range| Scale {
            label: label.into(),
            range: Some(range),
            ..Scale::default()
        };
        let panel = Panel {
            title: format!("{file}: frequency of the windows, over the spectrogram"),
            x: scale("time, s", (from_s, until_s)),
            y: scale("frequency, Hz", (0.0, max_hz)),
            curves,
            shades: Some(Shades {
                name: format!("power, darkest where highest, white {RANGE_DB:.0} dB below"),
                columns: levels.clone(),
            }),
        };
        chart(&panel.title.clone(), &[panel])
    }

    /// Returns a label track for Audacity: start, end and text of each window with a tone (Audacity
    /// manual, "Importing and Exporting Labels").
    pub fn audacity(&self) -> String {
        let mut out = String::new();
        for point in &self.points {
            if let Some(label) = point.label() {
                // Writing to a string cannot fail.
                let _ = writeln!(out, "{:.6}\t{:.6}\t{label}", point.from_s, point.to_s);
            }
        }
        out
    }

    /// Returns a text grid for Praat with a point in the middle of each window with a tone (Praat
    /// manual, "TextGrid file formats"). Praat's intervals must not overlap, but windows may.
    pub fn praat(&self) -> String {
        let labels = self.points.iter();
        let labels = labels.filter_map(|point| Some((point.middle_s(), point.label()?)));
        let labels: Vec<(f64, String)> = labels.collect();
        let (from_s, until_s) = (self.spectrogram.from_s, self.spectrogram.until_s);
        let mut out = format!(
            "File type = \"ooTextFile\"\nObject class = \"TextGrid\"\n\nxmin = {from_s:.6}\nxmax = {until_s:.6}\ntiers? <exists>\nsize = 1\nitem []:\n    item [1]:\n        class = \"TextTier\"\n        name = \"frequency\"\n        xmin = {from_s:.6}\n        xmax = {until_s:.6}\n        points: size = {}\n",
            labels.len()
        );
        for (number, (t_s, label)) in (1..).zip(&labels) {
            let _ = writeln!(
                out,
                "        points [{number}]:\n            number = {t_s:.6}\n            mark = \"{label}\""
            );
        }
        out
    }

    pub fn csv(&self) -> String {
        let mut out = String::from("from_s,to_s,frequency_hz,sigma_hz,status\n");
        let cell = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        for point in &self.points {
            let (hz, sigma) = (cell(point.frequency_hz), cell(point.sigma_hz));
            let (from_s, to_s, status) = (point.from_s, point.to_s, name(point.status));
            let _ = writeln!(out, "{from_s},{to_s},{hz},{sigma},{status}");
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::Selection;
    use crate::samples::Samples;
    use std::f64::consts::TAU;
    use std::sync::Arc;

    /// Returns the track of two channels with a tone that steps from 20 to 30 Hz in the middle of 8
    /// s.
    fn track() -> Track {
        let tone = |t_s: f64| if t_s < 4.0 { 20.0 } else { 30.0 };
        let value = move |row: usize, column: usize| {
            let t_s = row as f64 / 200.0;
            // Pseudo-random noise that does not repeat from window to window.
            let noise = ((row * row * 31 + column * 17) % 1009) as f64 / 1009.0;
            (TAU * tone(t_s) * t_s + column as f64).cos() + 0.1 * noise
        };
        let samples = Samples::array(
            "steps",
            vec!["a".into(), "b".into()],
            1600,
            Arc::new(value),
            Some(Arc::new(|row| row as f64 / 200.0)),
        );
        let (selection, mut points) = (Selection::default(), Vec::new());
        let steps = crate::windows::Steps {
            window_s: 1.0,
            stride_s: 1.0,
        };
        let mut take = |window: Window| {
            points.extend(Point::of(&window));
            Ok(())
        };
        let rows = &mut *samples.open().expect("rows");
        crate::windows::fit(rows, &selection, steps, &mut take, &mut |_| {}).expect("windows");
        let recorded = Recorded::read(&samples, &selection, usize::MAX).expect("rows");
        Track::new(points, &recorded, 1.0)
    }

    #[test]
    fn the_track_its_labels_and_the_spectrogram_agree() {
        let track = track();
        let truth = |t_s: f64| if t_s < 4.0 { 20.0 } else { 30.0 };
        let lines: Vec<String> = track.audacity().lines().map(str::to_owned).collect();
        assert_eq!((lines.len(), track.csv().lines().count()), (8, 9));
        for line in lines {
            let cells: Vec<&str> = line.split('\t').collect();
            let (from_s, to_s): (f64, f64) = (cells[0].parse().unwrap(), cells[1].parse().unwrap());
            let hz: f64 = cells[2].split(' ').next().unwrap().parse().unwrap();
            assert!((hz - truth(0.5 * (from_s + to_s))).abs() < 0.1, "{line}");
        }
        let praat = track.praat();
        assert!(praat.contains("points: size = 8\n") && praat.matches("mark = \"").count() == 8);
        let Spectrogram { levels, max_hz, .. } = &track.spectrogram;
        for (column, powers) in levels.iter().enumerate() {
            let t_s = 8.0 * (column as f64 + 0.5) / levels.len() as f64;
            let max = powers.iter().max().copied().unwrap_or_default();
            let highest = powers
                .iter()
                .position(|level| *level == max)
                .unwrap_or_default();
            let hz = max_hz * (highest as f64 + 0.5) / powers.len() as f64;
            assert!(
                (3.5..4.5).contains(&t_s) || (hz - truth(t_s)).abs() < 1.5,
                "{t_s}: {hz}"
            );
        }
        let svg = track.picture("a<b");
        for named in ["good windows", "95 % interval", "power, darkest"] {
            assert!(svg.contains(named), "{named}");
        }
        assert_eq!(
            svg.contains("windows that are not good"),
            track
                .points
                .iter()
                .any(|point| point.status != Status::Good)
        );
        assert!(svg.contains("class=\"shade\"") && svg.contains("a&lt;b") && !svg.contains("NaN"));
    }
}
