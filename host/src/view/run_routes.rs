//! The server's paths for runs and recording.
//!
//! | path | what |
//! |---|---|
//! | GET `/runs` | what each run has in it |
//! | POST `/runs?name=NAME` | opens the body as a run: telemetry as `record` writes it, or a table |
//! | GET `/runs/ID/state.json?t_s=T` | the state at a time; with `from_s` and `until_s` with the estimate of this part |
//! | POST `/runs/ID/settings` | runs the library over it again, with some settings of a JSON object |
//! | POST `/runs/ID/reload` | reads its file again |
//! | POST `/runs/ID/note` | keeps the body as a note on it |
//! | GET `/runs/ID/file` | the run's file |
//! | POST `/runs/ID/close` | forgets it |
//! | POST `/record` | begins to record; the answer to the next one is the run |
//! | POST `/record/latest` | a run of the latest minute |

use super::answer::{App, answer, to_json};
use super::hub;
use super::recorder::Recorder;
use super::run::Part;
use super::runs::How;
use anyhow::{Context, Result, ensure};
use axum::Router;
use axum::body::Body;
use axum::extract::{Path, Query, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use futures_util::stream::StreamExt;
use serde::Deserialize;
use std::io::Write;

/// Longest file that is taken, bytes: the 3.5 hours that 256 MiB of raw frames last.
const FILE_MOST: usize = 256 << 20;

#[derive(Deserialize)]
struct Named {
    name: String,
}

#[derive(Deserialize)]
struct Moment {
    #[serde(default)]
    t_s: f64,
    from_s: Option<f64>,
    until_s: Option<f64>,
}

/// Runs work that takes long beside the thread that serves the pages.
async fn on_a_thread(work: impl FnOnce() -> Result<String> + Send + 'static) -> Result<String> {
    tokio::task::spawn_blocking(work)
        .await
        .context("the work ended without a result")?
}

pub fn routes() -> Router<App> {
    Router::new()
        .route("/runs", get(list).post(add))
        .route("/runs/{id}/state.json", get(state))
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

async fn add(State(app): State<App>, Query(Named { name }): Query<Named>, body: Body) -> Response {
    answer(added(app, name, body).await)
}

/// Opens a body as a run. It goes into a file part by part, since many may come at a time.
async fn added(app: App, name: String, body: Body) -> Result<String> {
    let (mut file, mut length) = (app.runs.new_file()?, 0);
    let mut parts = body.into_data_stream();
    while let Some(part) = parts.next().await {
        let part = part?;
        length += part.len();
        ensure!(
            length <= FILE_MOST,
            "{name}: longer than {} MiB: cut it into parts",
            FILE_MOST >> 20
        );
        file.write_all(&part).context("the temporary folder")?;
    }
    on_a_thread(move || to_json(&app.runs.add(&name, file)?)).await
}

async fn state(
    State(app): State<App>,
    Path(id): Path<u64>,
    Query(moment): Query<Moment>,
) -> Response {
    let mark = moment
        .from_s
        .zip(moment.until_s)
        .map(|(from_s, until_s)| Part { from_s, until_s });
    let look = move || hub::state_of(app.runs.get(id)?.at(moment.t_s, mark)?);
    answer(on_a_thread(look).await)
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

/// A finished recording as a run.
fn opened(app: &App, recorder: Recorder) -> Result<String> {
    ensure!(
        !recorder.is_empty(),
        "nothing was received while it was recorded"
    );
    let (path, name) = (recorder.path.clone(), recorder.name());
    // Its file is complete when it is dropped.
    drop(recorder);
    let how = How {
        is_recorded: true,
        ..How::default()
    };
    to_json(&app.runs.open(&name, &path, how)?)
}
