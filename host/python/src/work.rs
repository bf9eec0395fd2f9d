//! The command's work on recordings: `fit`, `replay`, and its forms of settings and messages.

use crate::array::Samples;
use crate::raised;
use crate::words::of_python;
use anyhow::{Context, Result};
use pyo3::prelude::*;
use ridgetone_host::events::{self, JsonLines};
use ridgetone_host::input::{Input, Source, frame_rate_hz};
use ridgetone_host::messages::{Form, messages as all_messages};
use ridgetone_host::part::Exclude;
use ridgetone_host::picture::{Recording, draw};
use ridgetone_host::positions::PositionFile;
use ridgetone_host::samples;
use ridgetone_host::speed::{Column, Quantity};
use ridgetone_host::table_fit::{Band, Selection, TableFit};
use ridgetone_host::{
    detection, fit_picture, fit_report, replay as player, settings_form, touch_part,
};
use ridgetone_proto::settings::{Declared, Settings};
use ridgetone_proto::telemetry::Packet;
use std::path::{Path, PathBuf};

/// What was guessed of a file.
fn named(name: &str, guessed: Option<&String>) -> impl Iterator<Item = String> {
    guessed
        .map(|guessed| format!("{name}: {guessed}"))
        .into_iter()
}

/// A fit with what it was made of.
#[pyclass(frozen)]
pub struct Fitted {
    samples: samples::Samples,
    selection: Selection,
    fit: TableFit,
}

#[pymethods]
impl Fitted {
    /// Its picture as SVG.
    fn picture(&self, py: Python<'_>) -> PyResult<String> {
        let draw = || fit_picture::draw(&self.samples, &self.selection, &self.fit);
        py.detach(draw).map_err(raised)
    }
}

/// The fit's object as JSON, what to look at, and the fit itself.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the options of `ridgetone fit`")]
pub fn fit(
    py: Python<'_>,
    samples: &Samples,
    rate_hz: Option<f64>,
    from_s: Option<f64>,
    to_s: Option<f64>,
    columns: Vec<String>,
    harmonics: Option<u8>,
    mains_hz: Option<f64>,
    speed_column: Option<String>,
    position_column: Option<String>,
    positions: Option<PathBuf>,
    whole: bool,
    mm_per_count: Option<f64>,
    min_hz: Option<f64>,
    max_hz: Option<f64>,
    exclude: Vec<String>,
    moving_speed: bool,
) -> PyResult<(String, Vec<String>, Fitted)> {
    let column = |quantity, text: Option<String>| {
        text.map(|text| Column::parse(quantity, &text))
            .transpose()
            .map_err(crate::UsageError::new_err)
    };
    let position = column(Quantity::Position, position_column)?;
    let column = position
        .map(|column| column.with_mm_per_count(mm_per_count))
        .or(column(Quantity::Speed, speed_column)?);
    let mut declared = Declared {
        moving_speed,
        ..Declared::DEFAULT
    };
    for what in &exclude {
        let what = Exclude::named(what).map_err(|why| raised(why.into()))?;
        what.leave_out(&mut declared);
    }
    let selection = Selection {
        declared,
        rate_hz,
        from_s,
        to_s,
        columns,
        harmonics,
        position: column.clone().filter(|_| positions.is_none()),
        alignment: None,
        interferer_hz: mains_hz,
        band: Band::new(min_hz, max_hz).map_err(|why| raised(why.into()))?,
    };
    let run = || -> Result<_> {
        // An array is what somebody has chosen.
        let is_whole = whole || samples.0.path().is_none();
        let (samples, selection) = match positions {
            Some(path) => PositionFile {
                path,
                column,
                time: None,
            }
            .join(&samples.0, &selection)?,
            None => (samples.0.clone(), selection),
        };
        let fit = touch_part::fit(&samples, &selection, is_whole, &mut |_| {})?;
        let remarks = named(samples.name(), fit.guessed.as_ref())
            .chain(fit.warning(&selection))
            .map(|remark| of_python(&remark))
            .collect();
        let json = fit_report::json(samples.name(), &fit)?;
        let fitted = Fitted {
            samples,
            selection,
            fit,
        };
        Ok((json, remarks, fitted))
    };
    py.detach(run).map_err(raised)
}

/// What `replay` prints, a JSON object each; what to look at; and a picture if it is wanted.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "the options of `ridgetone replay`"
)]
pub fn replay(
    py: Python<'_>,
    samples: Option<&Samples>,
    scene: Option<PathBuf>,
    rate_hz: Option<f64>,
    scale: f64,
    noise: bool,
    seed: Option<u64>,
    settings: &str,
    picture: bool,
) -> PyResult<(Vec<String>, Vec<String>, Option<String>)> {
    let run = || -> Result<_> {
        let settings = settings_form::with_json(&Settings::DEFAULT, settings)?;
        let scene = scene
            .map(|path| hal_mock::load_scene(path, frame_rate_hz()))
            .transpose()?;
        let (source, seed) = match samples {
            Some(Samples(samples)) => {
                let source = Source::Trace {
                    samples: samples.clone(),
                    rate_hz,
                    volts_per_unit: scale,
                };
                (source, seed.unwrap_or(1))
            }
            None => {
                let mut scene = scene.unwrap_or_default();
                scene.seed = seed.unwrap_or(scene.seed);
                let seed = scene.seed;
                (Source::Scene(scene), seed)
            }
        };
        let input = Input {
            source,
            converter_noise: noise,
            seed,
        };
        let (given, mut settings) = (settings, settings);
        if samples.is_some() {
            settings = detection::settings_for(input.open_for(&given)?, given)?;
        }
        let always = (settings != given).then(|| detection::ALWAYS.to_owned());
        let mut input = input.open_for(&settings)?;
        let remarks = [always, input.guessed.take(), input.warning.take()];
        let remarks = remarks.into_iter().flatten();
        let remarks = remarks.map(|remark| of_python(&remark)).collect();
        let truth = input.truth;
        let (mut lines, mut packets, mut conversions) = (Vec::new(), Vec::new(), Vec::new());
        let mut sink = |packet: &Packet| {
            lines.push(events::json(packet)?);
            if picture {
                packets.push(packet.clone());
            }
            // Health comes every second of the recording: often enough for Ctrl-C.
            Ok(Python::attach(|py| py.check_signals())?)
        };
        let mut watch = |conversion| conversions.extend(picture.then_some(conversion));
        player::run_watched(
            input,
            settings,
            player::Observers {
                sink: &mut sink,
                progress: &mut |_, _| {},
                watch: &mut watch,
            },
        )?;
        let drawing = picture.then(|| {
            draw(
                &Recording::new(&conversions, &packets),
                truth.map(|truth| truth.frequency_hz),
            )
        });
        Ok((lines, remarks, drawing))
    };
    py.detach(run).map_err(raised)
}

/// The library's settings, or a file's, with some of them changed: all as JSON.
#[pyfunction]
pub fn settings(file: Option<PathBuf>, changes: &str) -> PyResult<String> {
    let base = file
        .as_deref()
        .map_or(Ok(Settings::DEFAULT), settings_form::load);
    let made = base.and_then(|base| settings_form::with_json(&base, changes));
    made.and_then(|settings| Ok(settings_form::json(&settings)?))
        .map_err(raised)
}

/// The messages of a recording but its raw frames, a JSON object each. None of a table.
#[pyfunction]
pub fn messages(py: Python<'_>, path: PathBuf) -> PyResult<Option<Vec<String>>> {
    py.detach(|| events_of(&path)).map_err(raised)
}

fn events_of(path: &Path) -> Result<Option<Vec<String>>> {
    let form = Form::of(path).with_context(|| path.display().to_string())?;
    if form == Form::Table {
        return Ok(None);
    }
    let (mut lines, mut json) = (Vec::new(), JsonLines::default());
    for message in all_messages(path, form)? {
        let line = message?.json(&mut json)?;
        if !line.contains(r#""type":"raw""#) {
            lines.push(line);
        }
    }
    Ok(Some(lines))
}
