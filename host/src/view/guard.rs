//! Restricts access to the server to this computer and to the server's own page.
//!
//! A foreign page could reach a loopback address through the user's browser, with a host name that
//! resolves to it, or could send a request without reading the answer. The guard refuses both, and
//! other origins may neither read nor frame anything.

use axum::extract::{Request, State};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::{IpAddr, SocketAddr};

/// Headers of every answer: the page must load nothing from elsewhere, and answers must not be
/// stored or used by other origins.
const HEADERS: [(HeaderName, &str); 6] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'self'; object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
    (
        HeaderName::from_static("cross-origin-resource-policy"),
        "same-origin",
    ),
];

/// Headers set by browsers: relation between the requesting page and the target, and kind of
/// request (Fetch Metadata, W3C).
const FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");
const FETCH_MODE: HeaderName = HeaderName::from_static("sec-fetch-mode");

/// Refuses requests that come neither from the user of this computer nor from the server's own
/// page, and adds headers to every answer.
pub async fn guard(State(address): State<SocketAddr>, request: Request, next: Next) -> Response {
    let mut response = match refusal(&request, address) {
        Some(refused) => refused.into_response(),
        None => next.run(request).await,
    };
    for (name, value) in HEADERS {
        let value = HeaderValue::from_static(value);
        // A page may override only the policy on what it loads.
        if name == header::CONTENT_SECURITY_POLICY {
            response.headers_mut().entry(name).or_insert(value);
        } else {
            response.headers_mut().insert(name, value);
        }
    }
    response
}

/// Returns the reason why a request is refused, if any.
fn refusal(request: &Request, address: SocketAddr) -> Option<(StatusCode, &'static str)> {
    let headers = request.headers();
    let Some(host) = single(headers, &header::HOST) else {
        return Some((StatusCode::BAD_REQUEST, "send one Host header\n"));
    };
    // The target of a request may also name a host, as for a proxy.
    let named = request.uri().authority().map(Authority::as_str);
    let is_ours = [Some(host), named]
        .into_iter()
        .flatten()
        .all(|host| is_ours(host, address));
    if !is_ours {
        let why = "this page is served to this computer only, as localhost\n";
        return Some((StatusCode::FORBIDDEN, why));
    }
    let is_foreign = headers.get_all(header::ORIGIN).iter().any(|origin| {
        let origin = origin.to_str().ok();
        origin.and_then(|origin| origin.strip_prefix("http://")) != Some(host)
    });
    let from_elsewhere = headers
        .get_all(FETCH_SITE)
        .iter()
        .any(|site| site != "same-origin" && site != "none");
    // A link on a foreign page may open this page.
    let is_link = request.method() == Method::GET
        && single(headers, &FETCH_MODE).is_some_and(|mode| mode == "navigate");
    if is_foreign || (from_elsewhere && !is_link) {
        return Some((StatusCode::FORBIDDEN, "this request is of another page\n"));
    }
    None
}

/// Returns the value of a header if it was sent exactly once.
fn single<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    let mut values = headers.get_all(name).iter();
    match (values.next(), values.next()) {
        (Some(value), None) => value.to_str().ok(),
        _ => None,
    }
}

/// True if a Host header names this computer and this port.
fn is_ours(host: &str, address: SocketAddr) -> bool {
    let Ok(authority) = host.parse::<Authority>() else {
        return false;
    };
    let name = authority.host();
    let ip = name
        .trim_start_matches('[')
        .trim_end_matches(']')
        .parse::<IpAddr>();
    let is_here = name.eq_ignore_ascii_case("localhost") || ip.is_ok_and(|ip| ip.is_loopback());
    // Without a port, the HTTP port is meant.
    is_here && authority.port_u16().unwrap_or(80) == address.port() && !host.contains('@')
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::body::Body;

    #[test]
    fn a_host_that_is_not_this_one_is_known() {
        let address = "127.0.0.1:8321".parse().unwrap();
        for good in [
            "127.0.0.1:8321",
            "localhost:8321",
            "LOCALHOST:8321",
            "[::1]:8321",
        ] {
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
        for bad in bad.into_iter().chain([
            "user@localhost:8321",
            "192.168.1.7:8321",
            "localhost.example.org:8321",
        ]) {
            assert!(!is_ours(bad, address), "{bad}");
        }
        assert!(is_ours("localhost", "127.0.0.1:80".parse().unwrap()));
    }

    /// Returns the HTTP status with which a request with these headers is refused.
    fn refused(method: Method, target: &str, headers: &[(&str, &str)]) -> Option<u16> {
        let mut request = Request::builder().method(method).uri(target);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let request = request.body(Body::empty()).unwrap();
        refusal(&request, "127.0.0.1:8321".parse().unwrap()).map(|(status, _)| status.as_u16())
    }

    #[test]
    fn a_request_has_one_host_and_comes_from_the_own_page() {
        const HOST: (&str, &str) = ("host", "localhost:8321");
        let get = |target: &str, headers: &[(&str, &str)]| refused(Method::GET, target, headers);
        assert_eq!(get("/", &[]), Some(400));
        assert_eq!(get("/", &[HOST, HOST]), Some(400));
        assert_eq!(get("/", &[HOST, ("host", "a.org")]), Some(400));
        assert_eq!(get("/", &[("host", "a.org:8321")]), Some(403));
        assert_eq!(get("http://a.org:8321/", &[HOST]), Some(403));
        assert_eq!(get("http://localhost:8321/", &[HOST]), None);
        assert_eq!(get("/", &[HOST]), None);
        assert_eq!(refused(Method::POST, "/record", &[HOST]), None);
        for origin in [
            "http://example.org",
            "https://localhost:8321",
            "null",
            "http://localhost",
            "http://127.0.0.1:8321",
        ] {
            for method in [Method::GET, Method::POST] {
                let headers = [HOST, ("origin", origin)];
                assert_eq!(refused(method, "/record", &headers), Some(403), "{origin}");
            }
        }
        let own = ("origin", "http://localhost:8321");
        assert_eq!(refused(Method::POST, "/record", &[HOST, own]), None);
        let twice = [HOST, own, ("origin", "http://a.org")];
        assert_eq!(refused(Method::POST, "/record", &twice), Some(403));
    }

    #[test]
    fn another_page_may_link_here_and_nothing_else() {
        const HOST: (&str, &str) = ("host", "localhost:8321");
        let navigates = ("sec-fetch-mode", "navigate");
        for (site, is_ours) in [
            ("same-origin", true),
            ("none", true),
            ("cross-site", false),
            ("same-site", false),
            ("anything", false),
        ] {
            let headers = [HOST, ("sec-fetch-site", site)];
            let expected = (!is_ours).then_some(403);
            for method in [Method::GET, Method::POST, Method::PUT] {
                let found = refused(method.clone(), "/record", &headers);
                assert_eq!(found, expected, "{method} {site}");
            }
            let linked = [headers[0], headers[1], navigates];
            assert_eq!(refused(Method::GET, "/", &linked), None, "{site}");
            let sent = refused(Method::POST, "/record", &linked);
            assert_eq!(sent, expected, "{site}");
        }
    }
}
