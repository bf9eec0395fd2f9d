//! The server of the page: for this computer only, and for its own pages only.
//!
//! | path | what |
//! |---|---|
//! | `/` and the files it names | the page |
//! | `/events` | everything first, then what is new, as server-sent events `state` and `update` ([`super::hub`]) |
//! | `/state.json` | everything, once |
//! | `/packets` | every packet as one JSON object a line, as with `--json`, the latest greeting first |
//!
//! A page from elsewhere could reach a loopback address through the user's browser, with a host name that points there: the
//! server refuses requests with any other host than this computer. Other origins may neither read nor frame an answer.

use super::hub::{Hub, Message};
use anyhow::{Context, Result};
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{Request, State};
use axum::http::uri::Authority;
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use futures_util::future::{Either, select};
use futures_util::stream::{Stream, unfold};
use std::convert::Infallible;
use std::net::{IpAddr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::broadcast::Receiver;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::oneshot;

/// Time after which a page that has lost the server tries again.
const RETRY: Duration = Duration::from_secs(1);

/// The files of the page: name, type, content.
const FILES: [(&str, &str, &str); 11] = [
    ("/", "text/html; charset=utf-8", include_str!("../../assets/view/index.html")),
    ("/view.css", "text/css; charset=utf-8", include_str!("../../assets/view/view.css")),
    ("/view.js", "text/javascript; charset=utf-8", include_str!("../../assets/view/view.js")),
    ("/model.js", "text/javascript; charset=utf-8", include_str!("../../assets/view/model.js")),
    ("/plots.js", "text/javascript; charset=utf-8", include_str!("../../assets/view/plots.js")),
    ("/panels.js", "text/javascript; charset=utf-8", include_str!("../../assets/view/panels.js")),
    ("/format.js", "text/javascript; charset=utf-8", include_str!("../../assets/view/format.js")),
    ("/icon.svg", "image/svg+xml", include_str!("../../assets/view/icon.svg")),
    ("/save.js", "text/javascript; charset=utf-8", include_str!("../../assets/view/save.js")),
    ("/uPlot.js", "text/javascript; charset=utf-8", include_str!("../../assets/uplot/uPlot.iife.min.js")),
    ("/uPlot.css", "text/css; charset=utf-8", include_str!("../../assets/uplot/uPlot.min.css")),
];

/// Headers of every answer: the page loads nothing from elsewhere, and nobody else may use or store it.
const HEADERS: [(HeaderName, &str); 6] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'self'; object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
];

/// A running server. Dropped, it ends.
#[derive(Debug)]
pub struct Server {
    pub address: SocketAddr,
    _running: oneshot::Sender<()>,
}

/// Reads an address to listen on, such as `127.0.0.1:8321`, `[::1]:8321` or `localhost:8321`; port 0 is any free one.
pub fn loopback(text: &str) -> Result<SocketAddr, String> {
    let numeric = text.strip_prefix("localhost:").map(|port| format!("127.0.0.1:{port}"));
    let address: SocketAddr = numeric
        .as_deref()
        .unwrap_or(text)
        .parse()
        .map_err(|_| "write an address and a port, such as 127.0.0.1:8321".to_owned())?;
    match address.ip().is_loopback() {
        true => Ok(address),
        false => Err(format!("{} can be reached from elsewhere: only 127.0.0.1 and [::1] are served", address.ip())),
    }
}

impl Server {
    /// Serves the hub's messages at a [`loopback`] address.
    pub fn start(address: SocketAddr, hub: Arc<Hub>) -> Result<Self> {
        let what = || format!("{address}: choose another with --listen 127.0.0.1:PORT, or any free one with PORT 0");
        let listener = TcpListener::bind(address).with_context(what)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let (running, dropped) = oneshot::channel::<()>();
        let routes = routes(hub).layer(from_fn_with_state(address, guard));
        let serve = async move {
            // It fails only without a runtime.
            let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
            let served = std::pin::pin!(async move { axum::serve(listener, routes).await });
            // It does not wait for pages, which listen for ever.
            if let Either::Left((Err(error), _)) = select(served, dropped).await {
                eprintln!("ridgetone: the page is no longer served: {error}");
            }
        };
        std::thread::spawn(move || runtime.block_on(serve));
        Ok(Self { address, _running: running })
    }
}

fn routes(hub: Arc<Hub>) -> Router {
    let mut routes = Router::new();
    for (path, kind, content) in FILES {
        routes = routes.route(path, get(move || async move { ([(header::CONTENT_TYPE, kind)], content) }));
    }
    routes
        .route("/events", get(events))
        .route("/state.json", get(state))
        .route("/packets", get(packets))
        .with_state(hub)
}

/// Refuses requests with another host than this computer, and adds [`HEADERS`] to every answer.
async fn guard(State(address): State<SocketAddr>, request: Request, next: Next) -> Response {
    let host = request.headers().get(header::HOST).and_then(|host| host.to_str().ok());
    let mut response = match host.is_some_and(|host| is_ours(host, address)) {
        true => next.run(request).await,
        false => (StatusCode::FORBIDDEN, "this page is served to this computer only, as localhost\n").into_response(),
    };
    for (name, value) in HEADERS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

/// Whether a Host header names this computer and this port.
fn is_ours(host: &str, address: SocketAddr) -> bool {
    let Ok(authority) = host.parse::<Authority>() else { return false };
    let name = authority.host();
    let ip = name.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>();
    let is_here = name.eq_ignore_ascii_case("localhost") || ip.is_ok_and(|ip| ip.is_loopback());
    // Without a port it is that of HTTP.
    is_here && authority.port_u16().unwrap_or(80) == address.port() && !host.contains('@')
}

async fn state(State(hub): State<Arc<Hub>>) -> Response {
    match hub.join(0) {
        Ok((message, _)) => ([(header::CONTENT_TYPE, "application/json")], message.json.to_string()).into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, format!("{error:#}\n")).into_response(),
    }
}

async fn packets(State(hub): State<Arc<Hub>>) -> Response {
    let (greeting, packets) = hub.join_packets();
    let lines = unfold((greeting, packets), |(mut greeting, mut packets)| async move {
        let line = match greeting.take() {
            Some(line) => line,
            None => match packets.recv().await {
                Ok(line) => line,
                Err(RecvError::Lagged(count)) => format!("{{\"type\":\"missed\",\"count\":{count}}}\n").into(),
                Err(RecvError::Closed) => return None,
            },
        };
        Some((Ok::<_, Infallible>(Bytes::copy_from_slice(line.as_bytes())), (None, packets)))
    });
    ([(header::CONTENT_TYPE, "application/x-ndjson")], Body::from_stream(lines)).into_response()
}

async fn events(State(hub): State<Arc<Hub>>) -> impl IntoResponse {
    Sse::new(messages(hub)).keep_alive(KeepAlive::default())
}

struct Page {
    hub: Arc<Hub>,
    updates: Option<Receiver<Message>>,
    missed: u64,
}

fn messages(hub: Arc<Hub>) -> impl Stream<Item = Result<Event, Infallible>> {
    unfold(Page { hub, updates: None, missed: 0 }, |mut page| async {
        let message = page.next().await?;
        Some((Ok(Event::default().event(message.kind).retry(RETRY).data(&*message.json)), page))
    })
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
        // The page is new, or was too slow: it gets everything, then the updates after it.
        let (message, updates) = self.hub.join(self.missed).ok()?;
        self.updates = Some(updates);
        Some(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_this_computer_s_own_addresses_are_taken() {
        for good in ["127.0.0.1:8321", "127.0.0.1:0", "[::1]:8321", "localhost:80"] {
            assert!(loopback(good).is_ok_and(|address| address.ip().is_loopback()), "{good}");
        }
        for bad in ["0.0.0.0:8321", "[::]:8321", "192.168.1.7:80", "8.8.8.8:1", "[2001:db8::1]:80"] {
            assert!(loopback(bad).is_err_and(|why| why.contains("elsewhere")), "{bad}");
        }
        for bad in ["", "8321", "127.0.0.1", "example.org:80", "localhost", "127.0.0.1:99999"] {
            assert!(loopback(bad).is_err_and(|why| why.contains("127.0.0.1:8321")), "{bad}");
        }
    }

    #[test]
    fn a_host_that_is_not_this_one_is_known() {
        let address = "127.0.0.1:8321".parse().unwrap();
        for good in ["127.0.0.1:8321", "localhost:8321", "LOCALHOST:8321", "[::1]:8321"] {
            assert!(is_ours(good, address), "{good}");
        }
        let bad = [
            "",
            "example.org:8321",
            "127.0.0.1.example.org:8321",
            "127.0.0.1",
            "127.0.0.1:80",
            "localhost:8321:1",
            "0.0.0.0:8321",
        ];
        for bad in bad.into_iter().chain(["user@localhost:8321", "192.168.1.7:8321", "localhost.example.org:8321"]) {
            assert!(!is_ours(bad, address), "{bad}");
        }
        assert!(is_ours("localhost", "127.0.0.1:80".parse().unwrap()));
    }

    #[test]
    fn a_slow_page_gets_everything_again_and_the_number_of_missed_updates() {
        let hub = Arc::new(Hub::new(crate::live::Live::new("a test")));
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        let mut page = Page { hub: Arc::clone(&hub), updates: None, missed: 0 };
        let mut next = || {
            let message = runtime.block_on(page.next()).unwrap();
            (message.kind, serde_json::from_str::<serde_json::Value>(&message.json).unwrap())
        };
        let (kind, state) = next();
        assert_eq!((kind, &state["missed"], &state["live"]["source"]), ("state", &0.into(), &"a test".into()));
        hub.publish().unwrap();
        let (kind, update) = next();
        let number = state["update"].as_u64().unwrap();
        assert_eq!((kind, update["update"].as_u64()), ("update", Some(number + 1)));
        for _ in 0..1000 {
            hub.publish().unwrap();
        }
        let (kind, state) = next();
        let missed = state["missed"].as_u64().unwrap();
        // All but the length of the queue.
        assert!(kind == "state" && (900..1000).contains(&missed), "{kind}, {missed}");
        assert_eq!(state["update"].as_u64(), Some(number + 1002));
        hub.publish().unwrap();
        assert_eq!(next().0, "update");
    }
}
