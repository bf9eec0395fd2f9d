//! State shared by the server's paths, and the form of their answers.

use super::hub::Hub;
use super::runs::Runs;
use anyhow::Result;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use hal_mock::printable;
use serde::Serialize;
use std::sync::Arc;

#[derive(Clone)]
pub struct App {
    pub hub: Arc<Hub>,
    pub runs: Arc<Runs>,
}

/// Returns text or JSON with the HTTP status of success, or an error.
pub fn answer(done: Result<String>) -> Response {
    match done {
        Ok(text) if text.starts_with(['{', '[']) => {
            ([(header::CONTENT_TYPE, "application/json")], text).into_response()
        }
        Ok(text) => text.into_response(),
        Err(error) => {
            let why = format!("{error:#}");
            (
                StatusCode::UNPROCESSABLE_ENTITY,
                printable(&why).into_owned(),
            )
                .into_response()
        }
    }
}

pub fn to_json(value: &impl Serialize) -> Result<String> {
    Ok(serde_json::to_string(value)?)
}
