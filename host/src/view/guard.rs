//! Access to the server: this computer alone, or whoever has the token; and no page but its own.
//!
//! A page from elsewhere could reach a loopback address through the user's browser, with a host
//! name that points there: the guard refuses requests with any other host than this computer, or
//! without the token. Other origins may neither send, read nor frame anything.

use axum::extract::{Request, State};
use axum::http::uri::Authority;
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Headers of every answer: the page loads nothing from elsewhere, and nobody else may use or store
/// it.
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

/// Bytes of a token: 128 bits cannot be guessed.
const TOKEN_BYTES: usize = 16;

/// Time in which a browser opens the page.
const TICKET_LASTS: Duration = Duration::from_secs(60);

/// A word that opens the page once.
#[derive(Debug)]
struct Ticket {
    word: String,
    made: Instant,
}

/// Access rule: this computer; at an address that others reach, whoever has the token.
#[derive(Clone, Debug)]
pub struct Access {
    pub address: SocketAddr,
    pub token: Option<String>,
    ticket: Arc<Mutex<Option<Ticket>>>,
}

fn random_word() -> anyhow::Result<String> {
    let mut bytes = [0; TOKEN_BYTES];
    getrandom::fill(&mut bytes)
        .map_err(|error| anyhow::anyhow!("random numbers for a token: {error}"))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Reads an address to listen on, such as `127.0.0.1:8321`, `[::1]:8321` or `localhost:8321`; port
/// 0 is any free one.
pub fn address(text: &str) -> Result<SocketAddr, String> {
    let numeric = text
        .strip_prefix("localhost:")
        .map(|port| format!("127.0.0.1:{port}"));
    let given = numeric.as_deref().unwrap_or(text).parse();
    given.map_err(|_| "write an address and a port, such as 127.0.0.1:8321".to_owned())
}

impl Access {
    /// A new token for an address that others reach, and none for one of this computer's own.
    pub fn new(address: SocketAddr) -> anyhow::Result<Self> {
        let is_open = !address.ip().is_loopback();
        Ok(Self {
            address,
            token: is_open.then(random_word).transpose()?,
            ticket: Arc::default(),
        })
    }

    /// What to open. For an address that stands for all of this computer's it is the one by which
    /// others reach it.
    pub fn url(&self) -> String {
        match &self.token {
            Some(token) => format!("{}?token={token}", self.place()),
            None => self.place(),
        }
    }

    /// What to open in a browser by a program, whose arguments all users of this computer can read:
    /// it opens the page once, and soon.
    pub fn url_once(&self) -> anyhow::Result<String> {
        if self.token.is_none() {
            return Ok(self.place());
        }
        let word = random_word()?;
        let url = format!("{}?once={word}", self.place());
        let made = Instant::now();
        *self.ticket() = Some(Ticket { word, made });
        Ok(url)
    }

    fn ticket(&self) -> MutexGuard<'_, Option<Ticket>> {
        self.ticket.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a word opens the page; it never does again.
    fn admits(&self, word: &str) -> bool {
        let mut ticket = self.ticket();
        let is_valid = ticket
            .as_ref()
            .is_some_and(|known| known.made.elapsed() < TICKET_LASTS && is_same(word, &known.word));
        if is_valid {
            *ticket = None;
        }
        is_valid
    }

    fn place(&self) -> String {
        let mut address = self.address;
        if address.ip().is_unspecified() {
            address.set_ip(outward(address.is_ipv6()).unwrap_or(address.ip()));
        }
        format!("http://{address}/")
    }

    fn cookie(&self) -> String {
        // Cookies know no ports.
        format!("ridgetone-{}=", self.address.port())
    }

    /// Whether a request may be answered.
    fn allows(&self, request: &Request) -> bool {
        let header = |name| {
            request
                .headers()
                .get(name)
                .and_then(|value| value.to_str().ok())
        };
        let host = header(header::HOST);
        // A browser says from which page a request comes that changes something.
        let is_foreign = request.headers().contains_key(header::ORIGIN)
            && header(header::ORIGIN).and_then(|origin| origin.strip_prefix("http://")) != host;
        let Some(token) = &self.token else {
            return !is_foreign && host.is_some_and(|host| is_ours(host, self.address));
        };
        let cookies = header(header::COOKIE)
            .into_iter()
            .flat_map(|all| all.split("; "));
        let mut given = cookies
            .filter_map(|one| one.strip_prefix(self.cookie().as_str()))
            .chain(given(request, "token="));
        !is_foreign && given.any(|given| is_same(given, token))
    }
}

/// This computer's address on the way out of it. Nothing is sent: the addresses are for documents
/// (RFC 5737, RFC 3849).
fn outward(is_v6: bool) -> Option<IpAddr> {
    let (here, there) = if is_v6 {
        ("[::]:0", "[2001:db8::1]:9")
    } else {
        ("0.0.0.0:0", "192.0.2.1:9")
    };
    let socket = UdpSocket::bind(here).ok()?;
    socket.connect(there).ok()?;
    Some(socket.local_addr().ok()?.ip())
}

/// What a request's address gives under a name.
fn given<'a>(request: &'a Request, name: &str) -> Option<&'a str> {
    request
        .uri()
        .query()?
        .split('&')
        .find_map(|pair| pair.strip_prefix(name))
}

/// Compares in constant time.
fn is_same(given: &str, token: &str) -> bool {
    given.len() == token.len()
        && given
            .bytes()
            .zip(token.bytes())
            .fold(0, |differ, (a, b)| differ | (a ^ b))
            == 0
}

/// Refuses requests that [`Access`] does not allow, and adds headers to every answer. The page's
/// address with the token leads to the one without, which the browser then knows by a cookie.
pub async fn guard(State(access): State<Access>, request: Request, next: Next) -> Response {
    let is_first = request.uri().path() == "/";
    let is_admitted = is_first && given(&request, "once=").is_some_and(|word| access.admits(word));
    let mut response = if !is_admitted && !access.allows(&request) {
        let why = match access.token {
            None => "this page is served to this computer only, as localhost\n",
            Some(_) => {
                "this page needs the whole address that the command has printed, with its token\n"
            }
        };
        (StatusCode::FORBIDDEN, why).into_response()
    } else if let Some(token) = &access.token
        && is_first
        && (is_admitted || given(&request, "token=").is_some())
    {
        let cookie = format!("{}{token}; HttpOnly; SameSite=Lax; Path=/", access.cookie());
        (
            StatusCode::SEE_OTHER,
            [
                (header::SET_COOKIE, cookie),
                (header::LOCATION, "/".to_owned()),
            ],
        )
            .into_response()
    } else {
        next.run(request).await
    };
    for (name, value) in HEADERS {
        let value = HeaderValue::from_static(value);
        // A page may state for itself what it loads, and nothing else.
        if name == header::CONTENT_SECURITY_POLICY {
            response.headers_mut().entry(name).or_insert(value);
        } else {
            response.headers_mut().insert(name, value);
        }
    }
    response
}

/// Whether a Host header names this computer and this port.
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
    // Without a port it is that of HTTP.
    is_here && authority.port_u16().unwrap_or(80) == address.port() && !host.contains('@')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_that_others_reach_has_a_token() {
        for own in [
            "127.0.0.1:8321",
            "127.0.0.1:0",
            "[::1]:8321",
            "localhost:80",
        ] {
            let access = Access::new(address(own).unwrap()).unwrap();
            assert!(
                access.token.is_none() && !access.url().contains("token"),
                "{own}"
            );
        }
        for other in ["0.0.0.0:8321", "[::]:8321", "192.168.1.7:80"] {
            let [one, two] = [(); 2].map(|()| Access::new(address(other).unwrap()).unwrap());
            let token = one.token.clone().unwrap();
            assert!(
                token.len() == 32 && one.token != two.token && one.url().ends_with(&token),
                "{other}"
            );
        }
        for bad in [
            "",
            "8321",
            "127.0.0.1",
            "example.org:80",
            "localhost",
            "127.0.0.1:99999",
        ] {
            assert!(
                address(bad).is_err_and(|why| why.contains("127.0.0.1:8321")),
                "{bad}"
            );
        }
    }

    #[test]
    fn only_the_token_opens_an_address_that_others_reach() {
        let access = Access {
            address: "0.0.0.0:8321".parse().unwrap(),
            token: Some("a1b2".into()),
            ticket: Arc::default(),
        };
        let request = |path: &str, headers: &[(&str, &str)]| {
            let mut request = Request::builder()
                .uri(path)
                .header("host", "192.168.1.7:8321");
            for (name, value) in headers {
                request = request.header(*name, *value);
            }
            request.body(axum::body::Body::empty()).unwrap()
        };
        let cookie = ("cookie", "other=1; ridgetone-8321=a1b2");
        assert!(
            access.allows(&request("/?token=a1b2", &[]))
                && access.allows(&request("/events?token=a1b2", &[]))
        );
        assert!(access.allows(&request("/events", &[cookie])));
        assert!(access.allows(&request(
            "/record",
            &[cookie, ("origin", "http://192.168.1.7:8321")]
        )));
        for path in [
            "/",
            "/events",
            "/?token=",
            "/?token=a1b3",
            "/?token=a1b2c",
            "/?nottoken=a1b2",
        ] {
            assert!(
                !access.allows(&request(path, &[("cookie", "ridgetone-8322=a1b2")])),
                "{path}"
            );
        }
        for origin in [
            "http://example.org",
            "https://192.168.1.7:8321",
            "null",
            "http://192.168.1.7",
        ] {
            assert!(
                !access.allows(&request("/record", &[cookie, ("origin", origin)])),
                "{origin}"
            );
        }
    }

    #[test]
    fn what_a_browser_is_given_opens_the_page_once_and_has_no_token() {
        let access = Access::new(address("192.168.1.7:80").unwrap()).unwrap();
        let token = access.token.clone().unwrap();
        assert!(!access.admits(""));
        let urls = [(); 2].map(|()| access.url_once().unwrap());
        let words = urls.map(|url| {
            assert!(!url.contains(&token));
            url.split_once("/?once=").unwrap().1.to_owned()
        });
        assert!(!access.admits(&words[0]), "only the latest one counts");
        assert!(!access.admits(&words[1][1..]));
        assert!(access.admits(&words[1]));
        assert!(!access.admits(&words[1]), "it has been used");
        let own = Access::new(address("127.0.0.1:80").unwrap()).unwrap();
        assert_eq!(own.url_once().unwrap(), own.url());
    }

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
}
