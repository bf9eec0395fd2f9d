//! Fits the slide in a recording, which follows a contact and a hold.

use crate::digits::significant;
use crate::frames::{Frames, Reading, may_be_touch};
use crate::messages::{Form, Message, messages};
use crate::part::{Selection, columns};
use crate::samples::Samples;
use crate::table_fit::{self, FittedPart, TableFit, joined};
use crate::tables::{RowReader, Timing};
use crate::touch_times::{SlideTimes, Touches};
use anyhow::{Result, ensure};
use hal_mock::FileError;
use ridgetone_proto::plan::FRAME_RATE_MIN_HZ;
use ridgetone_proto::telemetry::Status;
use std::path::Path;
use std::sync::Arc;

/// Minimum length of a slide that is fitted alone, as a fraction of the recording.
const SLIDE_MIN: f64 = 0.1;

/// Fits the longest slide of a recording. Fits the whole recording if there is no touch or on
/// request. Times in the selection take precedence. A slide that is too short to fit, or shorter
/// than a tenth of the recording, is unlikely to be the wanted part and is not used.
pub fn fit(
    samples: &Samples,
    selection: &Selection,
    is_whole: bool,
    progress: &mut dyn FnMut(u64),
) -> Result<TableFit> {
    let is_given = selection.from_s.is_some() || selection.to_s.is_some();
    let slide = if is_given || is_whole {
        None
    } else {
        longest_slide(samples, selection)
    };
    let Some(SlideTimes { start_s, end_s }) = slide else {
        let mut found = table_fit::fit(&mut *samples.open()?, selection, progress)?;
        let is_asked = is_given || is_whole;
        let is_slow = found.rate_hz < f64::from(FRAME_RATE_MIN_HZ);
        if !is_asked && is_slow && is_touch_table(samples, selection) {
            let note = format!(
                "all of it is fitted: touches are looked for from {FRAME_RATE_MIN_HZ} rows a second on; choose a part with --from and --to"
            );
            found.guessed = joined([found.guessed, Some(note)]);
        }
        return Ok(found);
    };
    let part = Selection {
        from_s: Some(start_s),
        to_s: Some(end_s),
        ..selection.clone()
    };
    let found = table_fit::fit(&mut *samples.open()?, &part, progress);
    if let Ok(mut found) = found
        && !matches!(found.status, Status::TooShort | Status::Nothing)
    {
        found.part = FittedPart::Slide;
        return Ok(found);
    }
    let mut found = table_fit::fit(&mut *samples.open()?, selection, progress)?;
    let note = format!(
        "all of it is fitted: the slide that was found, from {} to {} s, is too short",
        significant(start_s, 6),
        significant(end_s, 6)
    );
    found.guessed = joined([found.guessed, Some(note)]);
    Ok(found)
}

/// Returns the longest slide of at least a tenth of the recording. Returns `None` for rows that
/// detection cannot use, such as slow ones; errors in the file are reported by `fit`.
fn longest_slide(samples: &Samples, selection: &Selection) -> Option<SlideTimes> {
    let length_s = |slide: &SlideTimes| slide.end_s - slide.start_s;
    let (touches, recording_s) = found(samples, selection).ok()?;
    touches
        .slides
        .into_iter()
        .filter(|slide| length_s(slide) >= SLIDE_MIN * recording_s)
        .max_by(|a, b| length_s(a).total_cmp(&length_s(b)))
}

/// Returns the touches in a recording, in the recording's time: as reported in telemetry, or as
/// detected in samples in volts.
pub fn touches(samples: &Samples, selection: &Selection) -> Result<Touches> {
    Ok(found(samples, selection)?.0)
}

/// Returns the touches, and the length of a table in seconds; 0 for telemetry.
fn found(samples: &Samples, selection: &Selection) -> Result<(Touches, f64)> {
    match samples.path().map(|path| (path, Form::of(path))) {
        Some((_, Ok(Form::Table))) | None => detected(samples, selection),
        Some((path, Ok(form))) => Ok((recorded(path, form)?, 0.0)),
        Some((_, Err(error))) => Err(error.into()),
    }
}

/// True for a table whose chosen columns may be the taxels of a finger.
fn is_touch_table(samples: &Samples, selection: &Selection) -> bool {
    let is_table = samples
        .path()
        .is_none_or(|path| matches!(Form::of(path), Ok(Form::Table)));
    let rows = samples.open();
    is_table
        && rows.is_ok_and(|rows| {
            columns(&*rows, selection).is_ok_and(|chosen| may_be_touch(&*rows, &chosen))
        })
}

fn recorded(path: &Path, form: Form) -> Result<Touches> {
    let mut touches = Touches::default();
    for message in messages(path, form)? {
        match message? {
            Message::Packet(packet, _) => touches.take(&packet.event),
            Message::Json(text) => touches.take_json(&text)?,
        }
    }
    Ok(touches)
}

/// Detects touches in the chosen columns, at their own rate. Returns the touches and the length of
/// the rows, seconds.
fn detected(samples: &Samples, selection: &Selection) -> Result<(Touches, f64)> {
    let mut rows = samples.open()?;
    let chosen = columns(&*rows, selection)?;
    ensure!(may_be_touch(&*rows, &chosen), "no taxels of a finger");
    let begin_s = match rows.advance()? {
        true => rows.time_s().unwrap_or(0.0),
        false => 0.0,
    };
    let is_stamped = rows.timing() == Timing::Stamped;
    ensure!(
        selection.rate_hz.is_some() || is_stamped,
        "nothing says when its rows were"
    );
    let (opener, name) = (samples.opener(), samples.name().to_owned());
    let open = move || {
        let rows = opener()?;
        let names = chosen.iter().map(|at| rows.names()[*at].clone()).collect();
        Ok(Box::new(ChosenRows {
            rows,
            chosen: chosen.clone(),
            names,
        }) as Box<dyn RowReader + Send>)
    };
    let chosen = Samples::rows(&name, Arc::new(open));
    let reading = Reading {
        // With stamps, parts are selected by stamped time, so a supplied rate is ignored.
        rate_hz: selection.rate_hz.filter(|_| !is_stamped),
        ..Reading::default()
    };
    let frames = Frames::open(&chosen, reading)?;
    Ok((frames.touches()?.later(begin_s), frames.length_s))
}

/// Some columns of rows.
struct ChosenRows {
    rows: Box<dyn RowReader + Send>,
    chosen: Vec<usize>,
    names: Vec<String>,
}

impl RowReader for ChosenRows {
    fn file(&self) -> &str {
        self.rows.file()
    }

    fn names(&self) -> &[String] {
        &self.names
    }

    fn advance(&mut self) -> Result<bool, FileError> {
        self.rows.advance()
    }

    fn time_s(&self) -> Option<f64> {
        self.rows.time_s()
    }

    fn timing(&self) -> Timing {
        self.rows.timing()
    }

    fn units(&self) -> Vec<Option<String>> {
        let all = self.rows.units();
        self.chosen.iter().map(|at| all[*at].clone()).collect()
    }

    fn values(&self, values: &mut Vec<f64>) -> Result<(), FileError> {
        let mut all = Vec::new();
        self.rows.values(&mut all)?;
        values.clear();
        values.extend(self.chosen.iter().map(|at| all[*at]));
        Ok(())
    }
}
