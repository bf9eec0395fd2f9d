//! The command's work on recordings: `fit`, `replay`, settings and messages.

use crate::array::Samples;
use crate::raised;
use crate::words::of_python;
use anyhow::{Context, Result};
use hal_mock::Sliding;
use pyo3::prelude::*;
use ridgetone_host::events::{self, JsonLines};
use ridgetone_host::frames::{self, Frames, Reading};
use ridgetone_host::input::{Input, frame_rate_hz};
use ridgetone_host::messages::{Form, messages as all_messages};
use ridgetone_host::part::Exclude;
use ridgetone_host::picture::{Recording, draw};
use ridgetone_host::positions::PositionFile;
use ridgetone_host::samples;
use ridgetone_host::speed::{Column, Quantity};
use ridgetone_host::table_fit::{Band, Selection, TableFit};
use ridgetone_host::windows::{self, Steps, Window};
use ridgetone_host::{fit_picture, fit_report, replay as player, settings_form, touch_part};
use ridgetone_proto::settings::{Declared, Settings};
use ridgetone_proto::telemetry::{Event, Packet};
use std::path::{Path, PathBuf};

/// Number of packets of a recording between two checks for Ctrl-C.
const SIGNALS_EVERY: u64 = 256;

/// Returns the guesses about a file, prefixed with its name.
fn named(name: &str, guessed: Option<&String>) -> impl Iterator<Item = String> {
    guessed
        .map(|guessed| format!("{name}: {guessed}"))
        .into_iter()
}

/// A fit with its samples and selection.
#[pyclass(frozen)]
pub struct Fitted {
    samples: samples::Samples,
    selection: Selection,
    fit: TableFit,
}

#[pymethods]
impl Fitted {
    /// Draws the result as SVG.
    fn picture(&self, py: Python<'_>) -> PyResult<String> {
        let draw = || fit_picture::draw(&self.samples, &self.selection, &self.fit);
        py.detach(draw).map_err(raised)
    }
}

/// Options of `ridgetone fit`, from a `dict` with these keys.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Options {
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
}

impl Options {
    /// Returns the column of positions or speeds.
    fn column(&self) -> PyResult<Option<Column>> {
        let column = |quantity, text: &Option<String>| {
            text.as_deref()
                .map(|text| Column::parse(quantity, text))
                .transpose()
                .map_err(crate::UsageError::new_err)
        };
        let position = column(Quantity::Position, &self.position_column)?;
        let position = position.map(|column| column.with_mm_per_count(self.mm_per_count));
        Ok(position.or(column(Quantity::Speed, &self.speed_column)?))
    }

    fn selection(&self, column: Option<Column>) -> PyResult<Selection> {
        let mut declared = Declared {
            moving_speed: self.moving_speed,
            ..Declared::DEFAULT
        };
        for what in &self.exclude {
            let what = Exclude::named(what).map_err(|why| raised(why.into()))?;
            what.leave_out(&mut declared);
        }
        Ok(Selection {
            declared,
            rate_hz: self.rate_hz,
            from_s: self.from_s,
            to_s: self.to_s,
            columns: self.columns.clone(),
            harmonics: self.harmonics,
            position: column.filter(|_| self.positions.is_none()),
            alignment: None,
            interferer_hz: self.mains_hz,
            band: Band::new(self.min_hz, self.max_hz).map_err(|why| raised(why.into()))?,
        })
    }
}

/// Joins the positions of a robot's file, if there is one. Returns the samples and the selection.
fn joined(
    samples: &samples::Samples,
    positions: Option<PathBuf>,
    column: Option<Column>,
    selection: Selection,
) -> Result<(samples::Samples, Selection)> {
    match positions {
        Some(path) => PositionFile {
            path,
            column,
            time: None,
        }
        .join(samples, &selection),
        None => Ok((samples.clone(), selection)),
    }
}

/// Fits the samples. Returns the fit's JSON object, remarks, and the fit itself.
#[pyfunction]
pub fn fit(
    py: Python<'_>,
    samples: &Samples,
    options: Options,
) -> PyResult<(String, Vec<String>, Fitted)> {
    let column = options.column()?;
    let selection = options.selection(column.clone())?;
    let run = || -> Result<_> {
        // Fit all of an array: it is already the part that the user has chosen.
        let is_whole = options.whole || samples.0.path().is_none();
        let (samples, selection) = joined(&samples.0, options.positions, column, selection)?;
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

/// Fits windows in order. Returns the time of each window's first row, with its JSON or the reason
/// why there is no fit.
#[pyfunction]
pub fn fit_windows(
    py: Python<'_>,
    samples: &Samples,
    options: Options,
    window_s: f64,
    stride_s: f64,
) -> PyResult<Vec<(f64, Option<String>, String)>> {
    let column = options.column()?;
    let selection = options.selection(column.clone())?;
    let run = || -> Result<_> {
        let (samples, selection) = joined(&samples.0, options.positions, column, selection)?;
        let mut fits = Vec::new();
        let mut take = |window: Window| {
            fits.push(match window.fit {
                Ok(fit) => {
                    let json = fit_report::json(samples.name(), &fit)?;
                    (window.from_s, Some(json), String::new())
                }
                Err(why) => (window.from_s, None, of_python(&format!("{why:#}"))),
            });
            if (fits.len() as u64).is_multiple_of(SIGNALS_EVERY) {
                Python::attach(|py| py.check_signals())?;
            }
            Ok(())
        };
        let steps = Steps { window_s, stride_s };
        windows::fit(
            &mut *samples.open()?,
            &selection,
            steps,
            &mut take,
            &mut |_| {},
        )?;
        Ok(fits)
    };
    py.detach(run).map_err(raised)
}

/// Runs `replay`. Returns its output as JSON objects, remarks, and a picture if requested.
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
    seed: Option<u64>,
    settings: &str,
    picture: bool,
) -> PyResult<(Vec<String>, Vec<String>, Option<String>)> {
    let mut played = Played::new(picture);
    let run = || -> Result<_> {
        let (recording, remarks) = match samples {
            Some(Samples(samples)) => {
                let reading = Reading {
                    rate_hz,
                    volts_per_unit: scale,
                };
                played.frames(samples, reading, settings)?
            }
            None => {
                let scene = scene.map(|path| hal_mock::load_scene(path, frame_rate_hz()));
                let mut scene = scene.transpose()?.unwrap_or_default();
                scene.seed = seed.unwrap_or(scene.seed);
                let settings = settings_form::with_json(&Settings::DEFAULT, settings)?;
                played.scene(scene, settings)?
            }
        };
        let remarks = remarks.iter().map(|remark| of_python(remark)).collect();
        Ok((played.lines, remarks, recording))
    };
    py.detach(run).map_err(raised)
}

/// Events of a run.
struct Played {
    lines: Vec<String>,
    packets: Vec<Packet>,
    is_drawn: bool,
}

impl Played {
    fn new(is_drawn: bool) -> Self {
        Self {
            lines: Vec::new(),
            packets: Vec::new(),
            is_drawn,
        }
    }

    fn take(&mut self, packet: &Packet) -> Result<()> {
        if !matches!(packet.event, Event::Raw(_)) {
            self.lines.push(events::json(packet)?);
        }
        if self.is_drawn {
            self.packets.push(packet.clone());
        }
        Ok(())
    }

    /// Replays a recording's own frames. Returns a picture if requested, and remarks.
    fn frames(
        &mut self,
        samples: &samples::Samples,
        reading: Reading,
        settings: &str,
    ) -> Result<(Option<String>, Vec<String>)> {
        let frames = Frames::open(samples, reading)?;
        let settings = settings_form::with_json(&frames.settings, settings)?;
        frames.check_window(samples.name(), &settings)?;
        let mut remarks = frames.remarks(&settings);
        let chosen = frames.settings_for(settings)?;
        if chosen != settings {
            remarks.push(frames::ALWAYS.to_owned());
        }
        let (mut taken, is_drawn) = (0u64, self.is_drawn);
        let mut sink = |packet: &Packet| {
            taken += 1;
            if taken.is_multiple_of(SIGNALS_EVERY) {
                Python::attach(|py| py.check_signals())?;
            }
            self.take(packet)
        };
        frames.run(&chosen, is_drawn, &mut sink, &mut |_, _| {})?;
        let svg = is_drawn.then(|| draw(&Recording::of_frames(&self.packets, chosen.vref_v), None));
        Ok((svg, remarks))
    }

    /// Plays a scene to the simulated chip. Returns a picture if requested, and remarks.
    fn scene(
        &mut self,
        scene: Sliding,
        settings: Settings,
    ) -> Result<(Option<String>, Vec<String>)> {
        let mut input = Input::of(scene).open_in(&settings.plan)?;
        let (remarks, truth) = (input.warning.take().into_iter().collect(), input.truth);
        let (mut conversions, is_drawn) = (Vec::new(), self.is_drawn);
        let mut sink = |packet: &Packet| {
            self.take(packet)?;
            // Called at least once per second of the scene, with `health`: often enough for Ctrl-C.
            Ok(Python::attach(|py| py.check_signals())?)
        };
        let mut watch = |conversion| conversions.extend(is_drawn.then_some(conversion));
        let observers = player::Observers {
            sink: &mut sink,
            progress: &mut |_, _| {},
            watch: &mut watch,
        };
        player::run_watched(input, settings, observers)?;
        let svg = is_drawn.then(|| {
            let recording = Recording::new(&conversions, &self.packets);
            draw(&recording, truth.map(|truth| truth.frequency_hz))
        });
        Ok((svg, remarks))
    }
}

/// Returns the default settings, or those of a file, with changes, as JSON.
#[pyfunction]
pub fn settings(file: Option<PathBuf>, changes: &str) -> PyResult<String> {
    let base = file
        .as_deref()
        .map_or(Ok(Settings::DEFAULT), settings_form::load);
    let made = base.and_then(|base| settings_form::with_json(&base, changes));
    made.and_then(|settings| Ok(settings_form::json(&settings)?))
        .map_err(raised)
}

/// Returns all messages of a recording except raw frames, as JSON objects; `None` for a table.
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
