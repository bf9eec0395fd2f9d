//! Connections of the server: how many, and how long one may keep it waiting.

use axum::Router;
use axum::body::Body;
use axum::extract::Request;
use axum::middleware::Next;
use axum::response::Response;
use futures_util::stream::{StreamExt, unfold};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::io::{Error, ErrorKind};
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::sync::Semaphore;
use tokio::time::{sleep, timeout};

/// Connections at a time; the next ones wait in the system's queue.
const MOST: usize = 512;

/// Longest wait for the head of a request, and for each next part of its body.
const PATIENCE: Duration = Duration::from_secs(10);

/// Time until the next attempt where no connection can be taken, as without free file descriptors.
const AGAIN: Duration = Duration::from_secs(1);

/// Serves connections, for ever.
pub async fn serve(listener: TcpListener, routes: Router) {
    let free = Arc::new(Semaphore::new(MOST));
    loop {
        // Nobody closes it.
        let Ok(place) = Arc::clone(&free).acquire_owned().await else {
            return;
        };
        let Ok((stream, _)) = listener.accept().await else {
            sleep(AGAIN).await;
            continue;
        };
        let service = TowerToHyperService::new(routes.clone());
        tokio::spawn(async move {
            // A client that breaks off is no error.
            let _ = http1::Builder::new()
                .timer(TokioTimer::new())
                .header_read_timeout(PATIENCE)
                .serve_connection(TokioIo::new(stream), service)
                .await;
            drop(place);
        });
    }
}

/// Ends a request whose body stops to come.
pub async fn patience(request: Request, next: Next) -> Response {
    let bounded = |body: Body| {
        Body::from_stream(unfold(body.into_data_stream(), |mut parts| async {
            let part = match timeout(PATIENCE, parts.next()).await {
                Ok(part) => part?.map_err(Error::other),
                Err(_) => Err(Error::new(ErrorKind::TimedOut, "the body stops to come")),
            };
            Some((part, parts))
        }))
    };
    next.run(request.map(bounded)).await
}
