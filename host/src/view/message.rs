//! The two kinds of message to a page: the whole state, and updates.

use crate::analysis::{Curves, Spectrum};
use crate::events::view::Estimate;
use crate::feed::SettingsReply;
use crate::live::{Live, Log, Now, Strips, columns};
use crate::settings_form;
use crate::static_image::SIDE;
use serde::Serialize;
use std::sync::Arc;

/// Version of the messages. It increases when a field is removed or changes its meaning, but not
/// when fields are added.
pub const STREAM: u32 = 3;

#[derive(Clone, Debug)]
pub struct Message {
    /// `state` for the whole state, or `update` for new data.
    pub kind: &'static str,
    /// JSON on one line.
    pub json: Arc<str>,
}

/// Fields of both kinds of message.
#[derive(Serialize)]
pub struct Common<'a> {
    pub update: u64,
    pub status: String,
    pub no_raw: Option<&'a str>,
    /// Advice on the latest estimate's status, and remarks on it.
    pub remarks: Vec<String>,
    pub can_set: bool,
    /// Outcome of the latest settings that a page sent.
    pub settings_reply: Option<&'a SettingsReply>,
    /// Length of the current recording, seconds.
    pub recording_s: Option<f64>,
}

#[derive(Serialize)]
pub struct State<'a> {
    /// Number of updates that a slow page has missed.
    pub missed: u64,
    #[serde(flatten)]
    pub common: Common<'a>,
    /// Version of the stream.
    pub stream: u32,
    pub version: &'static str,
    pub places: [[usize; SIDE]; SIDE],
    /// Inputs of the page's form.
    pub settings_form: Vec<settings_form::Entry>,
    pub points_max: usize,
    pub frames_max: usize,
    pub live: &'a Live,
    pub spectrum: Option<&'a Spectrum>,
    pub curves: Option<&'a Curves>,
}

/// New data. Spectrum and curves are omitted if unchanged; `null` means that they were removed.
#[derive(Serialize)]
pub struct Update<'a> {
    #[serde(flatten)]
    pub common: Common<'a>,
    pub live: &'a Now,
    pub points: &'a [Estimate],
    #[serde(serialize_with = "columns")]
    pub strips: &'a Strips,
    pub log: Option<&'a Log>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spectrum: Option<Option<&'a Spectrum>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curves: Option<Option<&'a Curves>>,
}
