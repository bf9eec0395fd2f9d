//! Tests the server without a browser.

use super::{View, packets, recorded};
use crate::common;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Returns status, head and body of the answer to a request; if endless, what arrives within
/// `most`.
pub fn request(address: &str, path: &str, host: &str, max: Duration) -> (u16, String, String) {
    let mut line = TcpStream::connect(address).expect("it listens");
    line.set_read_timeout(Some(Duration::from_millis(100)))
        .expect("a timeout");
    write!(
        line,
        "GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
    )
    .expect("sent");
    let (mut bytes, mut part, begun) = (Vec::new(), [0; 65_536], Instant::now());
    while begun.elapsed() < max {
        match line.read(&mut part) {
            Ok(0) => break,
            Ok(length) => bytes.extend_from_slice(&part[..length]),
            Err(_) => {}
        }
    }
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let (head, body) = text.split_once("\r\n\r\n").expect("a head");
    let status = head
        .split(' ')
        .nth(1)
        .and_then(|status| status.parse().ok())
        .expect("a status");
    (status, head.to_lowercase(), body.to_owned())
}

pub const LONG: Duration = Duration::from_secs(20);

#[test]
fn other_programs_get_every_packet_as_with_json() {
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(3.0));
    let view = View::start(&["--file", common::text(&path), "--pace", "1"]);
    let address = view.address().to_owned();
    let (status, head, body) = request(&address, "/packets", &address, Duration::from_secs(2));
    assert!(
        status == 200 && head.contains("content-type: application/x-ndjson"),
        "{head}"
    );
    // Skips the chunk lengths of HTTP between the lines. The last line may be truncated.
    let mut found: Vec<&str> = body.lines().filter(|line| line.starts_with('{')).collect();
    found.pop();
    let printed = common::stdout(&common::run(&[
        "monitor",
        "--file",
        common::text(&path),
        "--pace",
        "0",
        "--json",
    ]));
    let printed: Vec<&str> = printed.lines().collect();
    assert!(
        found[0].starts_with(r#"{"type":"hello""#) && found.len() > 200,
        "{}",
        found.len()
    );
    // The greeting comes first, then every packet from the moment of the request.
    let first = printed
        .iter()
        .position(|line| *line == found[1])
        .expect("a packet");
    assert_eq!(found[1..], printed[first..][..found.len() - 1]);
    assert!(
        found
            .iter()
            .any(|line| line.starts_with(r#"{"type":"raw""#) && line.contains(r#""volts":["#))
    );
}

#[test]
fn it_serves_this_computer_only_and_its_state_as_json() {
    let folder = common::directory();
    let packets = packets(3.0);
    let path = recorded(folder.path(), &packets);
    let mut view = View::start(&["--file", common::text(&path), "--pace", "0"]);
    let address = view.address().to_owned();
    let port = address.strip_prefix("127.0.0.1:").expect("loopback");
    let state = || -> Value {
        let (status, head, body) = request(&address, "/state.json", &address, LONG);
        assert!(
            status == 200 && head.contains("content-type: application/json"),
            "{head}"
        );
        serde_json::from_str(&body).expect("JSON")
    };
    let begun = Instant::now();
    while state()["live"]["connection"]["state"] != "over" {
        assert!(begun.elapsed() < LONG, "{}", state());
        sleep(Duration::from_millis(100));
    }
    let live = &state()["live"];
    let lines = common::json_lines(&common::run(&[
        "monitor",
        "--file",
        common::text(&path),
        "--pace",
        "0",
        "--json",
    ]));
    let estimates: Vec<&Value> = lines
        .iter()
        .filter(|line| line["type"] == "estimate")
        .collect();
    assert_eq!(
        live["history"].as_array().map(Vec::len),
        Some(estimates.len())
    );
    assert_eq!(
        &live["latest"]["estimate"],
        *estimates.last().expect("an estimate")
    );
    assert_eq!(live["counts"]["received"], packets.len());

    for host in [
        "example.org",
        &format!("example.org:{port}"),
        &format!("127.0.0.1.example.org:{port}"),
        "127.0.0.1:1",
        "",
    ] {
        for path in ["/", "/state.json", "/events", "/packets", "/uPlot.js"] {
            let (status, _, body) = request(&address, path, host, LONG);
            assert!(
                status == 403 || host.is_empty() && status == 400,
                "{host} {path}: {status}"
            );
            assert!(
                !body.contains("latest") && !body.contains("uPlot"),
                "{host} {path}"
            );
        }
    }
    for host in [format!("localhost:{port}"), format!("[::1]:{port}")] {
        assert_eq!(request(&address, "/", &host, LONG).0, 200, "{host}");
    }
    for (header, status) in [
        ("Host: example.org", 400),
        ("Sec-Fetch-Site: cross-site", 403),
    ] {
        let host = format!("{address}\r\n{header}");
        let found = request(&address, "/state.json", &host, LONG).0;
        assert_eq!(found, status, "{header}");
    }
    for path in ["/", "/view.js", "/uPlot.css", "/state.json"] {
        let (_, head, _) = request(&address, path, &address, LONG);
        assert!(
            head.contains("content-security-policy: default-src 'self';"),
            "{head}"
        );
        assert!(
            head.contains("cache-control: no-store") && !head.contains("access-control"),
            "{head}"
        );
    }
    assert_eq!(request(&address, "/../Cargo.toml", &address, LONG).0, 404);
    let (_, head, body) = request(&address, "/events", &address, Duration::from_secs(1));
    assert!(head.contains("text/event-stream"), "{head}");
    assert!(
        body.contains("event: state") && body.matches("event: update").count() >= 3,
        "{}",
        body.len()
    );

    // Must not listen at other addresses: all of 127.0.0.0/8 belong to this computer.
    assert!(TcpStream::connect(format!("127.0.0.2:{port}")).is_err());

    // Ctrl-C must end the command even while a page is listening.
    let _page = TcpStream::connect(&address)
        .map(|mut line| write!(line, "GET /events HTTP/1.1\r\nHost: {address}\r\n\r\n"));
    kill_process(Pid::from_child(&view.child), Signal::INT).expect("a signal");
    let begun = Instant::now();
    let status = loop {
        if let Some(status) = view.child.try_wait().expect("a child") {
            break status;
        }
        assert!(begun.elapsed() < LONG, "it does not end");
        sleep(Duration::from_millis(20));
    };
    let mut stderr = String::new();
    view.child
        .stderr
        .take()
        .expect("a pipe")
        .read_to_string(&mut stderr)
        .expect("text");
    assert!(
        status.success() && stderr.contains(" packets received, 0 lost, 0 damaged"),
        "{status}: {stderr}"
    );
}

#[test]
fn a_second_page_has_another_port_and_a_missing_file_is_refused() {
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(0.5));
    let views = [(); 2].map(|()| View::start(&["--file", common::text(&path)]));
    let [one, two] = views.each_ref().map(View::address);
    assert_ne!(one, two);
    for address in [one, two] {
        assert_eq!(request(address, "/state.json", address, LONG).0, 200);
    }
    common::assert_one_line(
        &common::run(&["view", "--file", "no such file"]),
        1,
        &["no such file"],
    );
}

#[test]
fn open_starts_the_browser_with_the_address() {
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(0.5));
    let opened = folder.path().join("opened");
    let stub = common::file(
        folder.path(),
        "xdg-open",
        &format!("#!/bin/sh\necho \"$1\" > '{}'\n", opened.display()),
    );
    std::fs::set_permissions(&stub, std::os::unix::fs::PermissionsExt::from_mode(0o755))
        .expect("a mode");
    let searched = format!(
        "{}:{}",
        folder.path().display(),
        std::env::var("PATH").expect("a path")
    );
    let view = View::with(
        &["--file", common::text(&path), "--open"],
        &[("PATH", &searched)],
    );
    let begun = Instant::now();
    while std::fs::read_to_string(&opened).unwrap_or_default().trim() != view.url {
        assert!(begun.elapsed() < LONG, "nothing was opened");
        sleep(Duration::from_millis(20));
    }
    // Without a browser, the command says what to do and continues.
    let nothing = folder.path().join("nothing");
    let mut view = View::with(
        &["--file", common::text(&path), "--open"],
        &[("PATH", common::text(&nothing))],
    );
    let mut report = String::new();
    BufReader::new(view.child.stderr.take().expect("a pipe"))
        .read_line(&mut report)
        .expect("a line");
    let (status, _, _) = request(view.address(), "/", view.address(), LONG);
    assert!(
        status == 200 && report.contains("xdg-open") && report.contains(&view.url),
        "{report}"
    );
}
