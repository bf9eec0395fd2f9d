//! The server's paths for runs and recording.
//!
//! | path | what |
//! |---|---|
//! | GET `/runs` | what each run has in it |
//! | POST `/runs?name=NAME` | opens the body as a run: telemetry as `record` writes it, or a table |
//! | GET `/runs/ID/state.json?t_s=T` | the state at a time; with `from_s` and `until_s` with the estimate of this part |
//! | POST `/runs/ID/settings` | runs the library over it again, with some settings of a JSON object |
//! | POST `/runs/ID/time-column` | reads its table again with this column as the time |
//! | GET `/runs/ID/file` | the run's file |
//! | POST `/runs/ID/close` | forgets it |
//! | POST `/record` | begins to record; the answer to the next one is the run |
//! | POST `/record/latest` | a run of the latest minute |

use super::app::{App, answer, json, on_a_thread};
use super::hub;
use super::reading::Reading;
use super::recorder::Recorder;
use super::run::Part;
use anyhow::{Result, ensure};
use axum::Router;
use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, Path, Query, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use serde::Deserialize;

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

pub fn routes() -> Router<App> {
    Router::new()
        .route(
            "/runs",
            get(list).post(add).layer(DefaultBodyLimit::max(FILE_MOST)),
        )
        .route("/runs/{id}/state.json", get(state))
        .route("/runs/{id}/settings", post(again))
        .route("/runs/{id}/time-column", post(with_time))
        .route("/runs/{id}/file", get(file))
        .route("/runs/{id}/close", post(close))
        .route("/record", post(record))
        .route("/record/latest", post(record_latest))
}

async fn list(State(app): State<App>) -> Response {
    answer(json(&app.runs.list()))
}

async fn add(
    State(app): State<App>,
    Query(Named { name }): Query<Named>,
    bytes: Bytes,
) -> Response {
    answer(on_a_thread(move || json(&app.runs.add(&name, &bytes)?)).await)
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
    answer(on_a_thread(move || hub::state_of(app.runs.get(id)?.at(moment.t_s, mark)?)).await)
}

async fn again(State(app): State<App>, Path(id): Path<u64>, settings: String) -> Response {
    answer(on_a_thread(move || json(&app.runs.again(id, &settings)?)).await)
}

async fn with_time(State(app): State<App>, Path(id): Path<u64>, column: String) -> Response {
    answer(on_a_thread(move || json(&app.runs.with_time(id, &column)?)).await)
}

async fn file(State(app): State<App>, Path(id): Path<u64>) -> Response {
    let read = || Ok(std::fs::read(&app.runs.get(id)?.path)?);
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
    answer(on_a_thread(move || opened(&app, app.hub.record_latest(app.runs.new_path())?)).await)
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
    json(&app.runs.open(&name, &path, Reading::default(), None)?)
}
