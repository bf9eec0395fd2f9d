//! Tests `serve` with MQTT to Debian's mosquitto, and with Foxglove to a WebSocket client written
//! here.
#![cfg(target_os = "linux")]

mod common;
#[path = "streams/foxglove.rs"]
mod foxglove;
#[path = "streams/mosquitto.rs"]
mod mosquitto;
#[path = "common/serial_board.rs"]
mod serial_board;
#[path = "streams/serving.rs"]
mod serving;

use mosquitto::{Broker, Received, Relay, Subscriber};
use serde_json::Value;
use serial_board::SerialBoard;
use serving::Serving;
use std::collections::{BTreeMap, BTreeSet};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Returns the message numbers received on a topic.
fn indices(all: &[Received], topic: &str) -> BTreeSet<u64> {
    all.iter()
        .filter(|one| one.topic == topic)
        .filter_map(|one| one.message["index"].as_u64())
        .collect()
}

/// Counts the missing numbers below the largest one.
fn gaps(indices: &BTreeSet<u64>) -> u64 {
    indices
        .last()
        .map_or(0, |last| last + 1 - indices.len() as u64)
}

fn statuses(all: &[Received]) -> Vec<&Value> {
    all.iter()
        .filter(|one| one.topic == "ridgetone/status")
        .map(|one| &one.message)
        .collect()
}

fn wait_until(is_so: impl Fn() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < Duration::from_secs(20), "it never is");
        sleep(Duration::from_millis(10));
    }
}

#[test]
fn a_broker_gets_every_message_and_the_schemas() {
    let broker = Broker::start();
    let subscriber = Subscriber::start(broker.port);
    let board = SerialBoard::new();
    let serving = Serving::publish(&board, broker.port);
    sleep(Duration::from_secs(3));
    let report = serving.interrupt();
    let all = subscriber.finish();
    let frames = indices(&all, "ridgetone/f0/frames");
    assert!(
        frames.len() > 400 && gaps(&frames) == 0,
        "{} frames, {report}",
        frames.len()
    );
    for topic in ["diagnostics", "health"] {
        let found = indices(&all, &format!("ridgetone/f0/{topic}"));
        assert!(!found.is_empty() && gaps(&found) == 0, "{topic}: {found:?}");
    }
    let schema = all
        .iter()
        .find(|one| one.topic == "ridgetone/f0/frames/schema")
        .expect("a schema");
    assert_eq!(schema.message["properties"]["volts"]["type"], "array");
    let states = statuses(&all);
    let (last, others) = states.split_last().expect("a status");
    assert!(
        others.len() > 1 && others.iter().all(|one| one["state"] == "online"),
        "{states:?}"
    );
    // A subscriber that was disconnected can compute its losses from these totals.
    let finger = &last["fingers"]["f0"];
    assert_eq!(finger["published"]["frames"], frames.len() as u64);
    assert_eq!(finger["lost"]["frames"], 0);
    assert!(report.contains("0 frames and 0 events lost\n"), "{report}");
}

/// If the connection is lost for seconds, every event must arrive, and every lost frame must be
/// counted.
#[test]
fn what_a_broken_connection_costs_is_counted_and_reported() {
    let broker = Broker::start();
    let subscriber = Subscriber::start(broker.port);
    let relay = Relay::start(broker.port);
    let board = SerialBoard::of_rate(2000.0);
    let serving = Serving::publish(&board, relay.port);
    sleep(Duration::from_secs(2));
    relay.cut();
    sleep(Duration::from_secs(4));
    relay.mend();
    sleep(Duration::from_secs(4));
    board.stop();
    sleep(Duration::from_millis(300));
    let report = serving.interrupt();
    let all = subscriber.finish();
    let reported = |name: &str| -> u64 {
        all.iter()
            .filter(|one| one.message["at"] == "mqtt")
            .filter_map(|one| one.message[name].as_u64())
            .max()
            .unwrap_or(0)
    };
    let (lost, unconfirmed) = (reported("frames"), reported("frames_unconfirmed"));
    let total = &statuses(&all).last().expect("a status")["fingers"]["f0"]["lost"];
    assert_eq!(total["frames"], lost);
    assert_eq!(total["frames_unconfirmed"], unconfirmed);
    let missing = gaps(&indices(&all, "ridgetone/f0/frames"));
    assert!(lost > 1000, "{lost}: {report}");
    assert!(
        (lost..=lost + unconfirmed).contains(&missing),
        "{missing} missing, {lost} lost, {unconfirmed} unconfirmed"
    );
    for topic in ["diagnostics", "health"] {
        let found = indices(&all, &format!("ridgetone/f0/{topic}"));
        assert_eq!(gaps(&found), 0, "{topic}: {found:?}");
    }
    assert!(
        indices(&all, "ridgetone/f0/health").len() >= 9,
        "events of the break arrive later"
    );
    // A board that had to wait for the broker would be 4 s late.
    assert!(
        board.late_s() < 2.0,
        "the board was held up for {} s",
        board.late_s()
    );
    assert!(
        report.contains("; trying again") && report.matches("connected").count() >= 2,
        "{report}"
    );
}

/// A broker loses retained messages when it restarts, and subscribers may connect at any time.
#[test]
fn a_subscriber_that_comes_late_gets_the_greeting_also_of_a_restarted_broker() {
    let (port, board) = (mosquitto::free_port(), SerialBoard::new());
    let broker = Broker::start_at(port);
    let early = Subscriber::start(port);
    let serving = Serving::publish(&board, port);
    wait_until(|| early.count() > 500);
    let greeted = || {
        let late = Subscriber::start(port);
        wait_until(|| late.count() > 100);
        let all = late.leave();
        all.iter()
            .filter(|one| one.is_retained && one.message["type"] == "hello")
            .any(|one| one.message["settings"].is_object() && one.message["index"].is_u64())
    };
    assert!(greeted());
    drop((early, broker));
    let broker = Broker::start_at(port);
    let early = Subscriber::start(port);
    wait_until(|| early.count() > 500);
    assert!(greeted());
    let report = serving.interrupt();
    assert!(
        !report.contains("refused: ") && !report.contains("abruptly: "),
        "an error's text comes twice: {report}"
    );
    drop(broker);
}

/// A publisher that had to wait for its broker must let subscribers connect first.
#[test]
fn what_waited_for_a_broker_comes_to_a_subscriber_that_connects_later() {
    let (broker, board) = (Broker::start(), SerialBoard::new());
    let relay = Relay::start(broker.port);
    relay.cut();
    let serving = Serving::publish(&board, relay.port);
    wait_until(|| board.frames() > 400);
    relay.mend();
    wait_until(|| relay.is_used());
    let subscriber = Subscriber::start(broker.port);
    wait_until(|| subscriber.count() > 500);
    let report = serving.interrupt();
    let all = subscriber.finish();
    for topic in ["frames", "diagnostics", "health"] {
        let found = indices(&all, &format!("ridgetone/f0/{topic}"));
        assert_eq!(
            (found.first(), gaps(&found)),
            (Some(&0), 0),
            "{topic}: {report}"
        );
    }
}

#[test]
fn a_broker_that_hangs_holds_up_no_board() {
    let broker = Broker::start();
    let board = SerialBoard::of_rate(2000.0);
    let serving = Serving::publish(&board, broker.port);
    sleep(Duration::from_secs(1));
    broker.hang();
    sleep(Duration::from_secs(8));
    board.stop();
    // A board blocked by the hanging broker would be 8 s late. Allow for shorter delays by a busy
    // processor.
    assert!(
        board.late_s() < 4.0 && board.frames() > 12_000,
        "{} s late, {} frames",
        board.late_s(),
        board.frames()
    );
    broker.go_on();
    sleep(Duration::from_secs(2));
    let report = serving.interrupt();
    assert!(
        report.contains("mqtt: ") && report.contains("delivered"),
        "{report}"
    );
}

#[test]
fn a_broker_that_is_not_there_is_waited_for() {
    let (port, board) = (mosquitto::free_port(), SerialBoard::new());
    let serving = Serving::publish(&board, port);
    sleep(Duration::from_secs(2));
    let broker = Broker::start_at(port);
    let subscriber = Subscriber::start(port);
    sleep(Duration::from_secs(3));
    let report = serving.interrupt();
    let all = subscriber.finish();
    assert!(!indices(&all, "ridgetone/f0/frames").is_empty(), "{report}");
    assert!(
        report.contains(&format!("ridgetone: mqtt: 127.0.0.1:{port}: "))
            && report.contains("; trying again"),
        "{report}"
    );
    drop(broker);
}

/// Acts like the Foxglove app: connects, gets the channels with their schemas, and subscribes to
/// all.
#[test]
fn foxglove_gets_channels_schemas_and_messages() {
    let (port, board) = (mosquitto::free_port(), SerialBoard::new());
    let serving = Serving::start(&board, &["--foxglove", &format!("127.0.0.1:{port}")]);
    let mut viewer = foxglove::Viewer::connect(port);
    viewer.subscribe_to(6);
    for topic in [
        "frames",
        "contact",
        "tone",
        "texture",
        "diagnostics",
        "health",
    ] {
        let channel = &viewer.channels[&format!("/ridgetone/f0/{topic}")];
        assert_eq!(
            (&channel["encoding"], &channel["schemaEncoding"]),
            (&"json".into(), &"jsonschema".into())
        );
        let schema: Value =
            serde_json::from_str(channel["schema"].as_str().expect("a schema")).expect("JSON");
        assert_eq!(schema["title"], format!("ridgetone.{topic}"));
    }
    let mut found: BTreeMap<String, Vec<(u64, Value)>> = BTreeMap::new();
    while found.get("/ridgetone/f0/frames").map_or(0, Vec::len) < 500 {
        let (topic, log_ns, message) = viewer.next().expect("a message");
        found.entry(topic).or_default().push((log_ns, message));
    }
    let frames = &found["/ridgetone/f0/frames"];
    for pair in frames.windows(2) {
        assert_eq!(
            pair[1].1["index"].as_u64(),
            pair[0].1["index"].as_u64().map(|index| index + 1)
        );
    }
    let (log_ns, last) = frames.last().expect("a frame");
    assert!(
        (*log_ns as f64 * 1e-9 - last["utc_s"].as_f64().expect("a time")).abs() < 1e-6,
        "{last}"
    );
    assert!(!found["/ridgetone/f0/health"].is_empty());
    // A viewer that connects long after the greeting must still get it.
    let mut late = foxglove::Viewer::connect(port);
    late.subscribe_to(6);
    let greeting = std::iter::from_fn(|| late.next())
        .take(100)
        .find(|(_, _, message)| message["type"] == "hello");
    assert!(greeting.is_some_and(|(topic, ..)| topic.ends_with("/diagnostics")));
    let report = serving.interrupt();
    assert!(
        report.contains(&format!("ridgetone: foxglove: ws://127.0.0.1:{port}")),
        "{report}"
    );
    // A second server cannot use the same address. Since it has no other sink, the command fails.
    let busy = std::net::TcpListener::bind(("127.0.0.1", port)).expect("free again");
    let address = format!("127.0.0.1:{port}");
    let second = common::run(&[
        "serve",
        "--finger",
        "a=/dev/no-such-port",
        "--foxglove",
        &address,
    ]);
    assert_eq!(second.status.code(), Some(1));
    assert!(
        common::stderr(&second).contains("no sink works"),
        "{}",
        common::stderr(&second)
    );
    drop(busy);
}
