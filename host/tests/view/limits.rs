//! What pages and requests may take of the server.

use super::served::{LONG, request};
use super::{View, packets, recorded};
use crate::common;
use ridgetone_proto::telemetry::{Event, Packet, Release, WIRE_MAX, encode};
use std::fmt::Write as _;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread::sleep;
use std::time::{Duration, Instant};
use tempfile::TempDir;

fn start() -> (TempDir, View) {
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(1.0));
    let view = View::start(&["--file", common::text(&path)]);
    (folder, view)
}

/// A connection on which a part of a request was sent.
fn sent(address: &str, start: &str, body: &[u8]) -> TcpStream {
    let mut line = TcpStream::connect(address).expect("it listens");
    line.set_read_timeout(Some(LONG)).expect("a timeout");
    line.write_all(start.as_bytes()).expect("sent");
    line.write_all(body).expect("sent");
    line
}

fn post(address: &str, length: usize) -> String {
    format!("POST /runs?name=a HTTP/1.1\r\nHost: {address}\r\nContent-Length: {length}\r\n\r\n")
}

fn runs(address: &str) -> usize {
    let list = request(address, "/runs", address, LONG).2;
    let list: serde_json::Value = serde_json::from_str(&list).expect("JSON");
    list.as_array().map_or(0, Vec::len)
}

/// What comes until the server hangs up.
fn all(mut line: TcpStream) -> String {
    let mut text = String::new();
    line.read_to_string(&mut text).expect("it hangs up in time");
    text
}

#[test]
fn half_requests_end() {
    let (_folder, view) = start();
    let address = view.address();
    let head = sent(address, "GET / HTTP/1.1\r\nHost", b"");
    let body = sent(address, &post(address, 1000), b"time_s,a\n0,");
    assert_eq!(all(head), "");
    assert!(all(body).starts_with("HTTP/1.1 422"));
}

#[test]
fn pages_that_do_not_read_leave_the_server_to_others() {
    let (_folder, view) = start();
    let address = view.address();
    let events = format!("GET /events HTTP/1.1\r\nHost: {address}\r\n\r\n");
    let mut pages: Vec<TcpStream> = (0..200).map(|_| sent(address, &events, b"")).collect();
    let served = pages
        .iter_mut()
        .map(|page| {
            let mut status = [0; 12];
            page.read_exact(&mut status).expect("a status");
            String::from_utf8_lossy(&status).into_owned()
        })
        .filter(|status| status == "HTTP/1.1 200")
        .count();
    assert_eq!(served, ridgetone_host::view::hub::PAGES);
    assert_eq!(request(address, "/state.json", address, LONG).0, 200);
}

/// 13 MB that would take thirty times as much in memory.
#[test]
fn an_upload_is_bounded_by_what_it_expands_to() {
    let (mut bytes, mut wire) = (Vec::new(), [0; WIRE_MAX]);
    for number in 0..1_000_000u32 {
        let event = Event::Release(Release {
            t_us: u64::from(number),
        });
        let sequence = number as u16;
        let used = encode(&Packet { sequence, event }, &mut wire).expect("it fits");
        bytes.extend_from_slice(&wire[..used]);
    }
    let (_folder, view) = start();
    let address = view.address();
    let close = post(address, bytes.len()).replace("\r\n\r\n", "\r\nConnection: close\r\n\r\n");
    let answer = all(sent(address, &close, &bytes));
    assert!(
        answer.starts_with("HTTP/1.1 422") && answer.contains("256 MiB"),
        "{answer}"
    );
    assert_eq!(runs(address), 1, "the command's own file");
}

#[test]
fn work_ends_when_its_page_leaves() {
    // A quarter of an hour at 241 frames a second.
    let mut lines = String::new();
    for number in 0..220_000 {
        let (t_s, codes) = (f64::from(number) / 241.0, [number % 7; 16]);
        let _ = writeln!(
            lines,
            r#"{{"type":"raw","t_s":{t_s:.6},"number":{number},"codes":{codes:?}}}"#
        );
    }
    let (_folder, view) = start();
    let address = view.address();
    let line = sent(address, &post(address, lines.len()), lines.as_bytes());
    let busy = || {
        let before = ticks(view.child.id());
        sleep(Duration::from_secs(1));
        ticks(view.child.id()) - before
    };
    let begun = Instant::now();
    while busy() < 20 {
        assert!(begun.elapsed() < LONG, "it does not begin");
    }
    drop(line);
    while busy() > 10 {
        assert!(begun.elapsed() < 6 * LONG, "it does not end");
    }
    // Work that is done adds a run.
    assert_eq!(runs(address), 1, "the command's own file");
}

/// Processor time of a process, hundredths of a second (proc(5), `stat`).
fn ticks(process: u32) -> u64 {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).expect("it runs");
    let fields: Vec<&str> = (stat.rsplit(')').next().expect("a name"))
        .split_whitespace()
        .collect();
    let number = |at: usize| fields[at].parse::<u64>().expect("a number");
    number(11) + number(12)
}
