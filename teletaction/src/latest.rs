//! A page that shows one state: every change of it as a server-sent event `state`. A slow page gets
//! the latest one.

use axum::extract::State;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream::unfold;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;

/// Time after which a page that has lost the server tries again.
const RETRY: Duration = Duration::from_secs(1);

/// The state as JSON on one line.
#[derive(Clone, Debug)]
pub struct Latest(watch::Sender<Arc<str>>);

impl Latest {
    pub fn new(json: String) -> Self {
        Self(watch::Sender::new(json.into()))
    }

    pub fn publish(&self, json: String) {
        self.0.send_replace(json.into());
    }

    /// Whether a page looks.
    pub fn is_watched(&self) -> bool {
        self.0.receiver_count() > 0
    }
}

/// The route `/events`.
pub async fn events(State(latest): State<Latest>) -> Response {
    let mut states = latest.0.subscribe();
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
