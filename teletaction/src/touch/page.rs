//! The page: its files and its state.
//!
//! | path | answer |
//! |---|---|
//! | `/` and the files it names | the page |
//! | `/events` | the state, at once and whenever it changes, as server-sent events `state` |
//! | `/texture` | POST: a texture as a JSON object, instead of the source's |

use super::output::Output;
use crate::stimulus::{Actuator, Texture};
use anyhow::{Context, Result};
use axum::Router;
use axum::extract::State;
use axum::http::header;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{get, post};
use futures_util::stream::unfold;
use ridgetone_host::view::answer::answer;
use ridgetone_host::view::files::{FORMAT, File, ICON, STYLE};
use ridgetone_host::view::server::with_files;
use serde::Serialize;
use std::convert::Infallible;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::watch;

/// Time after which a page that has lost the server reconnects.
const RETRY: Duration = Duration::from_secs(1);

/// One of the page's own scripts.
macro_rules! js {
    ($name:literal) => {
        (
            concat!("/", $name),
            "text/javascript; charset=utf-8",
            include_str!(concat!("../../assets/touch/", $name)),
        )
    };
}

const FILES: &[File] = &[
    STYLE,
    ICON,
    FORMAT,
    (
        "/touch.css",
        "text/css; charset=utf-8",
        include_str!("../../assets/touch/touch.css"),
    ),
    js!("touch.js"),
    js!("surface.js"),
    js!("worklet.js"),
];

/// `cargo xtask worklet` builds it from this package.
pub const WASM: &[u8] = include_bytes!("../../assets/touch/stimulus.wasm");

/// The policy of all pages, plus WebAssembly from this origin.
const POLICY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; object-src 'none'; base-uri 'none'; \
    form-action 'none'; frame-ancestors 'none'";

#[derive(Clone, Debug, Serialize)]
pub struct Shown {
    pub source: String,
    pub status: String,
    /// True if the finger is silent and its texture fades.
    pub is_silent: bool,
    /// Latest texture; `None` before the finger has found one.
    pub texture: Option<Texture>,
    /// Number of textures so far.
    pub number: u64,
    /// Initial delay, milliseconds: mean and standard deviation.
    pub delay_ms: (f64, f64),
    /// Initial frequency of the carrier, hertz; `None` for the texture itself.
    pub carrier_hz: Option<f32>,
}

#[derive(Serialize)]
struct Json<'a> {
    #[serde(flatten)]
    shown: &'a Shown,
    /// Amplitude as a fraction of the actuator's maximum.
    fraction: Option<f32>,
    #[serde(flatten)]
    actuator: Actuator,
}

/// State shared by all open pages.
#[derive(Clone)]
pub struct Page {
    output: Output,
    shown: Arc<Mutex<Shown>>,
    /// The state as JSON on one line. A slow page skips to the latest state.
    latest: watch::Sender<Arc<str>>,
}

impl Page {
    pub fn new(output: Output, shown: Shown) -> Result<Self> {
        let latest = watch::Sender::new(json(&output, &shown)?.into());
        Ok(Self {
            output,
            shown: Arc::new(Mutex::new(shown)),
            latest,
        })
    }

    /// Changes the state and sends it.
    pub fn change(&self, change: impl FnOnce(&mut Shown)) -> Result<()> {
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut shown);
        self.latest.send_replace(json(&self.output, &shown)?.into());
        Ok(())
    }

    /// Sets a texture from a page. Error messages are for people.
    fn set(&self, text: &str) -> Result<String> {
        let texture: Texture = serde_json::from_str(text).context("no texture")?;
        texture.check()?;
        self.change(|shown| (shown.texture, shown.number) = (Some(texture), shown.number + 1))?;
        Ok(String::new())
    }

    pub fn is_watched(&self) -> bool {
        self.latest.receiver_count() > 0
    }

    pub fn routes(&self) -> Router {
        let own = Router::new()
            .route("/texture", post(texture))
            .with_state(self.clone());
        let events = Router::new()
            .route("/events", get(events))
            .with_state(self.latest.clone());
        let html = || async {
            (
                [(header::CONTENT_SECURITY_POLICY, POLICY)],
                Html(include_str!("../../assets/touch/index.html")),
            )
        };
        let script = || async {
            // A script loaded by a worklet also needs the policy in its own headers.
            let headers = [
                (header::CONTENT_SECURITY_POLICY, POLICY),
                (header::CONTENT_TYPE, "application/wasm"),
            ];
            (headers, WASM).into_response()
        };
        with_files(Router::new(), FILES)
            .route("/", get(html))
            .route("/stimulus.wasm", get(script))
            .merge(own)
            .merge(events)
    }
}

fn json(output: &Output, shown: &Shown) -> Result<String> {
    let fraction = |texture: &Texture| output.fraction(texture);
    Ok(serde_json::to_string(&Json {
        shown,
        fraction: shown.texture.as_ref().map(fraction),
        actuator: output.actuator,
    })?)
}

async fn texture(State(page): State<Page>, json: String) -> Response {
    answer(page.set(&json))
}

async fn events(State(latest): State<watch::Sender<Arc<str>>>) -> Response {
    let mut states = latest.subscribe();
    states.mark_changed();
    let events = unfold(states, |mut states| async {
        states.changed().await.ok()?;
        let json = Arc::clone(&states.borrow_and_update());
        Some((
            Ok::<_, Infallible>(Event::default().event("state").retry(RETRY).data(&*json)),
            states,
        ))
    });
    Sse::new(events)
        .keep_alive(KeepAlive::default())
        .into_response()
}
