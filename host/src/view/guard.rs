//! Who may ask the server: this computer alone, and its own pages alone.
//!
//! A page from elsewhere could reach a loopback address through the user's browser, with a host name that points there: the
//! guard refuses requests with any other host than this computer. Other origins may neither send, read nor frame anything.

use axum::extract::{Request, State};
use axum::http::uri::Authority;
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::{IpAddr, SocketAddr};

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

/// Refuses requests with another host than this computer, and adds [`HEADERS`] to every answer.
pub async fn guard(State(address): State<SocketAddr>, request: Request, next: Next) -> Response {
    let host = request.headers().get(header::HOST).and_then(|host| host.to_str().ok());
    // A browser says from which page a request comes that changes something.
    let origin = request.headers().get(header::ORIGIN).map(|origin| origin.to_str().ok()?.strip_prefix("http://"));
    let is_own = origin.is_none_or(|origin| origin.is_some() && origin == host);
    let mut response = match is_own && host.is_some_and(|host| is_ours(host, address)) {
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
}
