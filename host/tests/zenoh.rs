//! `serve` to Zenoh, beside a session of the crate, and beside a peer of Zenoh's package for
//! Python.
#![cfg(target_os = "linux")]

mod common;
#[path = "streams/peer.rs"]
mod peer;
#[path = "common/serial_board.rs"]
mod serial_board;
#[path = "streams/serving.rs"]
mod serving;

use peer::Peer;
use serde_json::Value;
use serial_board::SerialBoard;
use serving::Serving;
use std::collections::BTreeMap;
use std::net::TcpListener;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};
use zenoh::{Config, Wait};

/// A peer that listens at this port and looks for nobody.
fn peer(port: u16) -> zenoh::Session {
    let mut config = Config::default();
    config
        .insert_json5("listen/endpoints", &format!("[\"tcp/127.0.0.1:{port}\"]"))
        .expect("an address");
    config
        .insert_json5("scouting/multicast/enabled", "false")
        .expect("a switch");
    zenoh::open(config).wait().expect("a session")
}

/// Two servers of one network find each other by multicast, and a peer of one gets the messages of
/// both: one at a time.
fn alone() -> MutexGuard<'static, ()> {
    static SERVER: Mutex<()> = Mutex::new(());
    // A test that has failed holds up no other.
    SERVER.lock().unwrap_or_else(PoisonError::into_inner)
}

fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0")
        .and_then(|free| free.local_addr())
        .expect("a port")
        .port()
}

#[test]
fn a_peer_gets_messages_without_a_gap_and_its_end_holds_up_no_board() {
    let _alone = alone();
    let port = free_port();
    let session = peer(port);
    let subscriber = session
        .declare_subscriber("ridgetone/**")
        .wait()
        .expect("a subscription");
    let board = SerialBoard::of_rate(1000.0);
    let serving = Serving::start(&[&board], &["--zenoh", &format!("tcp/127.0.0.1:{port}")]);
    let mut found: BTreeMap<String, Vec<u64>> = BTreeMap::new();
    let begun = Instant::now();
    while found.get("ridgetone/f0/frames").map_or(0, Vec::len) < 3000 {
        assert!(begun.elapsed() < Duration::from_secs(60), "{found:?}");
        let Ok(Some(sample)) = subscriber.recv_timeout(Duration::from_secs(10)) else {
            panic!("no messages: {found:?}")
        };
        let message: Value = serde_json::from_slice(&sample.payload().to_bytes()).expect("JSON");
        assert_eq!(sample.encoding().to_string(), "application/json");
        let index = message["index"].as_u64();
        found
            .entry(sample.key_expr().to_string())
            .or_default()
            .extend(index);
    }
    assert!(!found["ridgetone/f0/health"].is_empty(), "{found:?}");
    for (topic, indices) in &found {
        assert!(
            indices.windows(2).all(|pair| pair[1] == pair[0] + 1),
            "{topic}: {indices:?}"
        );
    }
    drop((subscriber, session));
    sleep(Duration::from_secs(2));
    board.stop();
    assert!(
        board.late_s() < 0.5,
        "the board was held up for {} s",
        board.late_s()
    );
    let stderr = serving.interrupt();
    assert!(
        stderr.contains("zenoh: open as ") && stderr.contains("0 frames and 0 events lost"),
        "{stderr}"
    );
}

#[test]
#[ignore = "needs Zenoh's package for Python: cargo xtask streams"]
fn a_peer_of_another_program_gets_messages_without_a_gap() {
    let _alone = alone();
    let port = free_port().to_string();
    let peer = Peer::start("zenoh_peer.py", &[&port, "120"]);
    let board = SerialBoard::new();
    let serving = Serving::start(&[&board], &["--zenoh", &format!("tcp/127.0.0.1:{port}")]);
    let lines = peer.until("key", 1500);
    let mut found: BTreeMap<&str, Vec<u64>> = BTreeMap::new();
    for line in &lines {
        assert_eq!(line["encoding"], "application/json");
        let (key, message) = (line["key"].as_str().expect("a key"), &line["message"]);
        if key == "ridgetone/f0/frames" {
            let number = message["number"].as_f64().expect("a number") % 1000.0;
            let volts = (2e6 + 100.0 * number) * 4.096 / 7_864_320.0;
            assert!(
                (message["volts"][0].as_f64().expect("volts") - volts).abs() < 1e-6,
                "{message}"
            );
        }
        found
            .entry(key)
            .or_default()
            .extend(message["index"].as_u64());
    }
    for (key, indices) in &found {
        assert!(
            indices.windows(2).all(|pair| pair[1] == pair[0] + 1),
            "{key}: {indices:?}"
        );
    }
    println!(
        "{:?}",
        found
            .iter()
            .map(|(key, indices)| (key, indices.len()))
            .collect::<Vec<_>>()
    );
    assert!(found["ridgetone/f0/frames"].len() > 1400 && !found["ridgetone/f0/health"].is_empty());
    let stderr = serving.interrupt();
    assert!(stderr.contains("0 frames and 0 events lost"), "{stderr}");
}

#[test]
fn an_address_that_is_none_is_refused() {
    let refused = common::run(&[
        "serve",
        "--finger",
        "a=/dev/no-such-port",
        "--zenoh",
        "nowhere",
    ]);
    common::assert_one_line(&refused, 2, &["nowhere", "tcp/HOST:PORT"]);
}
