//! The server of the page.
//!
//! | path | what |
//! |---|---|
//! | `/` and the files it names | the page |
//! | `/events` | the whole state, then updates, as server-sent events `state` and `update` ([`super::hub`]) |
//! | `/state.json` | the whole state, once |
//! | `/packets` | every packet as one JSON object per line, as with `--json`, the latest greeting first |
//! | `/settings` | POST: some settings for the board, as a JSON object |
//! | `/ports` | the serial ports of this computer, and the programs that use them |
//! | `/connect?port=NAME` | POST: shows the board at this port from now on |
//! | `/runs`, `/record` | [`super::run_routes`] |

use super::answer::{App, answer, to_json};
use super::files::{FILES, File};
use super::guard::guard;
use super::hub::Hub;
use super::message::Message;
use super::run_routes;
use crate::events::view::{Missed, Note};
use crate::feed::Feed;
use crate::port::{Link, Listed, Ports, System, Wanted, list_error};
use anyhow::{Context, Result};
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{Query, State};
use axum::http::{StatusCode, header};
use axum::middleware::from_fn_with_state;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use futures_util::future::select;
use futures_util::stream::{Stream, unfold};
use serde::Deserialize;
use serde_json::json;
use std::convert::Infallible;
use std::future::IntoFuture;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::broadcast::Receiver;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::oneshot;

/// Time after which a page that has lost the server tries again.
const RETRY: Duration = Duration::from_secs(1);

/// Stack of the threads that fit a part of a run: as large as a main thread's, which unoptimized
/// builds need.
const STACK_BYTES: usize = 8 << 20;

/// A running server. Dropping it stops it.
#[derive(Debug)]
pub struct Server {
    /// Address, with the port in use.
    pub address: SocketAddr,
    _running: oneshot::Sender<()>,
}

impl Server {
    /// Serves these paths behind the guard, on this computer only: at this port or, if it is
    /// taken, at any free one.
    pub fn start(port: u16, routes: Router) -> Result<Self> {
        let addresses = [port, 0].map(|port| SocketAddr::from((Ipv4Addr::LOCALHOST, port)));
        let listener = TcpListener::bind(&addresses[..])
            .with_context(|| format!("a page cannot be served at {}", addresses[0]))?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .thread_stack_size(STACK_BYTES)
            .build()?;
        let (running, dropped) = oneshot::channel::<()>();
        let routes = routes.layer(from_fn_with_state(address, guard));
        let serve = async move {
            // This fails only without a runtime.
            let Ok(listener) = tokio::net::TcpListener::from_std(listener) else {
                return;
            };
            // Do not wait for pages, which listen for ever.
            let served = axum::serve(listener, routes).into_future();
            select(std::pin::pin!(served), dropped).await;
        };
        std::thread::spawn(move || runtime.block_on(serve));
        Ok(Self {
            address,
            _running: running,
        })
    }
}

/// Returns the routes of `view`: the page, the hub's messages and the runs.
pub fn routes(app: App) -> Router {
    with_files(run_routes::routes(), FILES)
        .route("/events", get(events))
        .route("/state.json", get(state))
        .route("/packets", get(packets))
        .route("/settings", post(settings))
        .route("/clear", post(clear))
        .route("/ports", get(ports))
        .route("/connect", post(connect))
        .with_state(app)
}

pub fn with_files<S: Clone + Send + Sync + 'static>(
    routes: Router<S>,
    files: &'static [File],
) -> Router<S> {
    files
        .iter()
        .copied()
        .fold(routes, |routes, (path, kind, content)| {
            routes.route(
                path,
                get(move || async move { ([(header::CONTENT_TYPE, kind)], content) }),
            )
        })
}

async fn state(State(App { hub, .. }): State<App>) -> Response {
    match hub.join(0) {
        Ok((message, _)) => (
            [(header::CONTENT_TYPE, "application/json")],
            message.json.to_string(),
        )
            .into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, format!("{error:#}\n")).into_response(),
    }
}

async fn settings(State(App { hub, .. }): State<App>, json: String) -> Response {
    answer(hub.set(&json).map(|()| "Sent to the board.".to_owned()))
}

async fn clear(State(App { hub, .. }): State<App>) {
    hub.clear();
}

async fn ports() -> Response {
    let list = || {
        let found = System.list().map_err(list_error)?;
        to_json(&found.into_iter().map(Listed::from).collect::<Vec<_>>())
    };
    answer(list())
}

#[derive(Deserialize)]
struct Port {
    port: String,
}

async fn connect(
    State(App { hub, .. }): State<App>,
    Query(Port { port }): Query<Port>,
) -> Response {
    let opened = Link::open(System, Wanted::Name(port));
    answer(opened.map(|link| {
        hub.connect(Feed::new(link));
        String::new()
    }))
}

async fn packets(State(App { hub, .. }): State<App>) -> Response {
    let (greeting, packets) = hub.join_packets();
    let lines = unfold(
        (greeting, packets),
        |(mut greeting, mut packets)| async move {
            let line = match greeting.take() {
                Some(line) => line,
                None => match packets.recv().await {
                    Ok(line) => line,
                    Err(RecvError::Lagged(count)) => {
                        let missed = Note::Missed(Missed { count });
                        format!("{}\n", json!(missed)).into()
                    }
                    Err(RecvError::Closed) => return None,
                },
            };
            Some((
                Ok::<_, Infallible>(Bytes::copy_from_slice(line.as_bytes())),
                (None, packets),
            ))
        },
    );
    (
        [(header::CONTENT_TYPE, "application/x-ndjson")],
        Body::from_stream(lines),
    )
        .into_response()
}

async fn events(State(App { hub, .. }): State<App>) -> Response {
    Sse::new(messages(hub))
        .keep_alive(KeepAlive::default())
        .into_response()
}

struct Page {
    hub: Arc<Hub>,
    updates: Option<Receiver<Message>>,
    missed: u64,
}

fn messages(hub: Arc<Hub>) -> impl Stream<Item = Result<Event, Infallible>> {
    unfold(
        Page {
            hub,
            updates: None,
            missed: 0,
        },
        |mut page| async {
            let message = page.next().await?;
            Some((
                Ok(Event::default()
                    .event(message.kind)
                    .retry(RETRY)
                    .data(&*message.json)),
                page,
            ))
        },
    )
}

impl Page {
    async fn next(&mut self) -> Option<Message> {
        if let Some(updates) = &mut self.updates {
            match updates.recv().await {
                Ok(message) => return Some(message),
                Err(RecvError::Lagged(missed)) => self.missed += missed,
                Err(RecvError::Closed) => return None,
            }
        }
        // A new or slow page gets the whole state, then later updates.
        let (message, updates) = self.hub.join(self.missed).ok()?;
        self.updates = Some(updates);
        Some(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_page_gets_everything_again_and_the_number_of_missed_updates() {
        let hub = Arc::new(Hub::new(crate::live::Live::new("a test")));
        let runtime = tokio::runtime::Builder::new_current_thread()
            .build()
            .unwrap();
        let mut page = Page {
            hub: Arc::clone(&hub),
            updates: None,
            missed: 0,
        };
        let mut next = || {
            let message = runtime.block_on(page.next()).unwrap();
            (
                message.kind,
                serde_json::from_str::<serde_json::Value>(&message.json).unwrap(),
            )
        };
        let (kind, state) = next();
        assert_eq!(
            (kind, &state["missed"], &state["live"]["source"]),
            ("state", &0.into(), &"a test".into())
        );
        hub.publish().unwrap();
        let (kind, update) = next();
        let number = state["update"].as_u64().unwrap();
        assert_eq!(
            (kind, update["update"].as_u64()),
            ("update", Some(number + 1))
        );
        for _ in 0..1000 {
            hub.publish().unwrap();
        }
        let (kind, state) = next();
        let missed = state["missed"].as_u64().unwrap();
        // The page missed all updates except those in the queue.
        assert!(
            kind == "state" && (900..1000).contains(&missed),
            "{kind}, {missed}"
        );
        assert_eq!(state["update"].as_u64(), Some(number + 1002));
        hub.publish().unwrap();
        assert_eq!(next().0, "update");
    }
}
