//! The server's paths for runs and recording.
//!
//! | path | what |
//! |---|---|
//! | GET `/runs` | a summary of each run |
//! | POST `/runs?name=NAME` | opens the body as a run: a recording or a table; `rate_hz` for one without times |
//! | GET `/runs/ID/rows.json` | its samples, thinned to `steps` steps from `from_s` to `until_s`, and its touches |
//! | GET `/runs/ID/fit.json`, `/runs/ID/fit.svg` | the result of `fit` for it, or for its part from `from_s` to `until_s` |
//! | GET `/runs/ID/track.json?window_s=S` | the frequency of windows, `stride_s` apart, and a spectrogram; also as `.csv`, `.svg`, `.txt` (labels of Audacity) and `.TextGrid` (Praat) |
//! | GET `/runs/ID/state.json?t_s=T` | the board's state at a time |
//! | POST `/runs/ID/settings` | runs the library over it again, with some settings of a JSON object |
//! | POST `/runs/ID/reload` | reads its file again |
//! | POST `/runs/ID/note` | stores the body as its note |
//! | GET `/runs/ID/file` | the run's file |
//! | POST `/runs/ID/close` | closes it |
//! | POST `/record` | starts to record; the next one stops, and returns the run |
//! | POST `/record/latest` | a run of the latest minute |

use super::answer::{App, answer, to_json};
use super::hub;
use super::recorder::Recorder;
use super::run::{How, Part};
use crate::windows::Steps;
use anyhow::{Context, Result, bail, ensure};
use axum::Router;
use axum::body::Body;
use axum::extract::{Path, Query, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use futures_util::stream::StreamExt;
use serde::Deserialize;
use std::io::Write;

/// Maximum size of a file that is accepted, in bytes: 3.5 hours of raw frames.
const FILE_MAX: usize = 256 << 20;

#[derive(Deserialize)]
struct Named {
    name: String,
    rate_hz: Option<f64>,
}

#[derive(Deserialize)]
struct Moment {
    t_s: f64,
}

#[derive(Deserialize)]
struct Range {
    from_s: Option<f64>,
    until_s: Option<f64>,
    steps: Option<usize>,
}

impl Range {
    fn part(&self) -> Part {
        Part {
            from_s: self.from_s,
            until_s: self.until_s,
        }
    }
}

/// Default and maximum number of steps for thinned samples.
const STEPS: usize = 1000;
const STEPS_MAX: usize = 8000;

/// Runs long work on a separate thread, so that pages are still served.
async fn on_a_thread(work: impl FnOnce() -> Result<String> + Send + 'static) -> Result<String> {
    tokio::task::spawn_blocking(work)
        .await
        .context("the work ended without a result")?
}

pub fn routes() -> Router<App> {
    Router::new()
        .route("/runs", get(list).post(add))
        .route("/runs/{id}/state.json", get(state))
        .route("/runs/{id}/rows.json", get(rows))
        .route("/runs/{id}/fit.json", get(fit))
        .route("/runs/{id}/fit.svg", get(picture))
        .route("/runs/{id}/{track}", get(track))
        .route("/runs/{id}/settings", post(again))
        .route("/runs/{id}/reload", post(reload))
        .route("/runs/{id}/note", post(note))
        .route("/runs/{id}/file", get(file))
        .route("/runs/{id}/close", post(close))
        .route("/record", post(record))
        .route("/record/latest", post(record_latest))
}

async fn list(State(app): State<App>) -> Response {
    answer(to_json(&app.runs.list()))
}

async fn add(State(app): State<App>, Query(named): Query<Named>, body: Body) -> Response {
    answer(added(app, named, body).await)
}

/// Opens a body as a run. The body is written to a file in parts, because many large bodies may
/// arrive at once.
async fn added(app: App, Named { name, rate_hz }: Named, body: Body) -> Result<String> {
    let (mut file, mut length) = (app.runs.new_file()?, 0);
    let mut parts = body.into_data_stream();
    while let Some(part) = parts.next().await {
        let part = part?;
        length += part.len();
        ensure!(
            length <= FILE_MAX,
            "{name}: longer than {} MiB: cut it into parts",
            FILE_MAX >> 20
        );
        file.write_all(&part).context("the temporary folder")?;
    }
    let how = How {
        rate_hz,
        ..How::default()
    };
    on_a_thread(move || to_json(&app.runs.add(&name, file, how)?)).await
}

async fn state(
    State(app): State<App>,
    Path(id): Path<u64>,
    Query(moment): Query<Moment>,
) -> Response {
    let look = move || hub::state_of(app.runs.get(id)?.at(moment.t_s));
    answer(on_a_thread(look).await)
}

async fn rows(State(app): State<App>, Path(id): Path<u64>, Query(range): Query<Range>) -> Response {
    let look = move || {
        let steps = range.steps.unwrap_or(STEPS).min(STEPS_MAX);
        let Part { from_s, until_s } = range.part();
        let run = app.runs.get(id)?;
        let (from_s, until_s) = (
            from_s.unwrap_or(f64::NEG_INFINITY),
            until_s.unwrap_or(f64::INFINITY),
        );
        to_json(&run.recorded()?.overview(from_s, until_s, steps))
    };
    answer(on_a_thread(look).await)
}

async fn fit(State(app): State<App>, Path(id): Path<u64>, Query(range): Query<Range>) -> Response {
    let fit = move || to_json(&app.runs.get(id)?.fit_json(range.part())?);
    answer(on_a_thread(fit).await)
}

async fn picture(
    State(app): State<App>,
    Path(id): Path<u64>,
    Query(range): Query<Range>,
) -> Response {
    let draw = move || app.runs.get(id)?.fit_svg(range.part());
    match on_a_thread(draw).await {
        Ok(svg) => ([(header::CONTENT_TYPE, "image/svg+xml")], svg).into_response(),
        Err(error) => answer(Err(error)),
    }
}

#[derive(Deserialize)]
struct Stepped {
    window_s: f64,
    stride_s: Option<f64>,
}

/// Maximum number of windows in a track: more take minutes, and no screen can show them.
const WINDOWS_MAX: f64 = 5000.0;

async fn track(
    State(app): State<App>,
    Path((id, name)): Path<(u64, String)>,
    Query(Stepped { window_s, stride_s }): Query<Stepped>,
) -> Response {
    let Some(form) = name.strip_prefix("track.").map(str::to_owned) else {
        return StatusCode::NOT_FOUND.into_response();
    };
    let steps = Steps {
        window_s,
        stride_s: stride_s.unwrap_or(window_s),
    };
    let make = move || {
        let run = app.runs.get(id)?;
        let (from_s, until_s) = run.recorded()?.ends_s();
        let count = (until_s - from_s) / steps.stride_s;
        ensure!(
            count <= WINDOWS_MAX,
            "these are {count:.0} windows, and the page shows {WINDOWS_MAX}: choose a longer stride, or use `ridgetone fit --window`"
        );
        let track = run.track(steps)?;
        match form.as_str() {
            "json" => to_json(&track),
            "csv" => Ok(track.csv()),
            "svg" => Ok(track.picture(&run.name)),
            "txt" => Ok(track.audacity()),
            "TextGrid" => Ok(track.praat()),
            _ => bail!("a track is written as csv, svg, txt or TextGrid"),
        }
    };
    let kind = match name.as_str() {
        "track.svg" => "image/svg+xml",
        "track.json" => "application/json",
        _ => "text/plain; charset=utf-8",
    };
    match on_a_thread(make).await {
        Ok(text) => ([(header::CONTENT_TYPE, kind)], text).into_response(),
        Err(error) => answer(Err(error)),
    }
}

async fn again(State(app): State<App>, Path(id): Path<u64>, settings: String) -> Response {
    answer(on_a_thread(move || to_json(&app.runs.again(id, &settings)?)).await)
}

async fn reload(State(app): State<App>, Path(id): Path<u64>) -> Response {
    answer(on_a_thread(move || to_json(&app.runs.reload(id)?)).await)
}

async fn note(State(app): State<App>, Path(id): Path<u64>, text: String) -> Response {
    answer(app.runs.note(id, &text).map(|()| String::new()))
}

async fn file(State(app): State<App>, Path(id): Path<u64>) -> Response {
    let read = || {
        let bytes = std::fs::read(&app.runs.get(id)?.path)?;
        app.runs.saved(id)?;
        Ok(bytes)
    };
    match read() {
        Ok(bytes) => ([(header::CONTENT_TYPE, "application/octet-stream")], bytes).into_response(),
        Err(error) => answer(Err(error)),
    }
}

async fn close(State(app): State<App>, Path(id): Path<u64>) -> Response {
    answer(app.runs.close(id).map(|()| String::new()))
}

async fn record(State(app): State<App>) -> Response {
    match app.hub.record(|| app.runs.new_path()) {
        Some(recorder) => answer(on_a_thread(move || opened(&app, recorder)).await),
        None => answer(Ok(String::new())),
    }
}

async fn record_latest(State(app): State<App>) -> Response {
    let open = move || opened(&app, app.hub.record_latest(app.runs.new_path())?);
    answer(on_a_thread(open).await)
}

fn opened(app: &App, recorder: Recorder) -> Result<String> {
    ensure!(
        !recorder.is_empty(),
        "nothing was received while it was recorded"
    );
    let (path, name) = (recorder.path.clone(), recorder.name());
    // The file is complete once the recorder is dropped.
    drop(recorder);
    let how = How {
        is_recorded: true,
        ..How::default()
    };
    to_json(&app.runs.open(&name, &path, how)?)
}
