//! How late frames arrive, and what is lost: `cargo xtask streams`.

use crate::foxglove::Viewer;
use crate::mosquitto::{self, Broker, Subscriber};
use crate::process::processor_s;
use crate::serial_board::SerialBoard;
use crate::serving::Serving;
use ridgetone_proto::settings::FRAME_RATE_HZ;
use serde_json::Value;
use std::collections::BTreeMap;
use std::thread::sleep;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// What a receiver got: moment of receipt, topic without a slash in front, message.
type Got = Vec<(f64, String, Value)>;

#[test]
#[ignore = "two minutes"]
fn ten_boards_and_a_fast_one_arrive_in_time_and_nothing_is_lost_silently() {
    let seconds = std::env::var("RIDGETONE_STREAMS_S")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(60);
    println!(
        "| boards | receiver | frames | lost, counted | lost, not counted | p50, ms | p99, ms | most, ms | processor |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let slow: Vec<SerialBoard> = (0..10)
        .map(|_| SerialBoard::waiting(f64::from(FRAME_RATE_HZ)))
        .collect();
    measure("10 at 241 Hz", &slow, seconds);
    measure("1 at 1480 Hz", &[SerialBoard::waiting(1480.0)], seconds);
}

fn measure(what: &str, boards: &[SerialBoard], seconds: u64) {
    let (broker, port) = (Broker::start(), mosquitto::free_port());
    let subscriber = Subscriber::start(broker.port);
    let (url, address) = (
        format!("mqtt://127.0.0.1:{}", broker.port),
        format!("127.0.0.1:{port}"),
    );
    let all: Vec<&SerialBoard> = boards.iter().collect();
    let serving = Serving::start(&all, &["--mqtt", &url, "--foxglove", &address]);
    let mut viewer = Viewer::connect(port);
    viewer.subscribe_to(6 * boards.len());
    boards.iter().for_each(SerialBoard::begin);
    let reader = std::thread::spawn(move || {
        let mut got = Got::new();
        while let Some((topic, _, message)) = viewer.next() {
            let now = SystemTime::now()
                .duration_since(UNIX_EPOCH)
                .expect("a clock");
            got.push((now.as_secs_f64(), topic[1..].to_owned(), message));
        }
        got
    });
    sleep(Duration::from_secs(seconds));
    // The processor's share of all that happened until now.
    let busy_s = processor_s(serving.id());
    boards.iter().for_each(SerialBoard::stop);
    sleep(Duration::from_millis(500));
    let stderr = serving.interrupt();
    let foxglove = reader.join().expect("messages");
    let mqtt = subscriber
        .finish()
        .into_iter()
        .map(|one| (one.utc_s, one.topic, one.message))
        .collect();
    let late_ms = 1e3 * boards.iter().map(SerialBoard::late_s).fold(0.0, f64::max);
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    eprintln!(
        "{what}: a board itself was {late_ms:.0} ms late at most; this computer's load: {}",
        load.trim()
    );
    let served = Served {
        what,
        boards,
        percent: 100.0 * busy_s / seconds as f64,
        stderr,
    };
    report(&served, "mqtt", &mqtt);
    report(&served, "foxglove", &foxglove);
}

/// What the boards sent, and what it cost to serve it.
struct Served<'a> {
    what: &'a str,
    boards: &'a [SerialBoard],
    /// A share of one core.
    percent: f64,
    stderr: String,
}

fn report(served: &Served, receiver: &str, got: &Got) {
    let Served {
        what,
        boards,
        percent,
        stderr,
    } = served;
    let mut late_ms = Vec::new();
    let mut numbers: BTreeMap<String, Vec<u64>> = BTreeMap::new();
    let mut counts: BTreeMap<&String, u64> = BTreeMap::new();
    for (utc_s, topic, message) in got {
        if let Some(number) = message["index"].as_u64() {
            numbers.entry(topic.clone()).or_default().push(number);
        }
        if message["at"] == receiver {
            let names = ["frames", "events", "frames_unconfirmed"];
            let total = names.iter().filter_map(|name| message[*name].as_u64());
            counts.insert(topic, total.sum());
        }
        if message["type"] == "raw" {
            let board: usize = topic
                .split('/')
                .nth(1)
                .and_then(|name| name[1..].parse().ok())
                .expect("a finger");
            let converted_s = boards[board].begun_utc_s()
                + message["t_s"].as_f64().expect("a time")
                + boards[board].frame_s;
            late_ms.push(1e3 * (utc_s - converted_s));
        }
    }
    let counted: u64 = counts.values().sum();
    // A viewer that subscribes later lacks the first messages of a topic.
    let missing: u64 = numbers
        .values()
        .map(|numbers| {
            numbers.last().unwrap_or(&0) + 1 - numbers.first().unwrap_or(&0) - numbers.len() as u64
        })
        .sum();
    let sent: u64 = boards.iter().map(SerialBoard::frames).sum();
    late_ms.sort_by(f64::total_cmp);
    let part = |share: f64| late_ms[((late_ms.len() - 1) as f64 * share) as usize];
    let (frames, silent) = (late_ms.len() as u64, missing.saturating_sub(counted));
    println!(
        "| {what} | {receiver} | {frames} of {sent} | {counted} | {silent} | {:.2} | {:.2} | {:.1} | {percent:.0} % of a core |",
        part(0.5),
        part(0.99),
        part(1.0)
    );
    assert_eq!(silent, 0, "{stderr}");
    assert_eq!(
        frames + counted,
        sent,
        "every frame arrives or is counted: {stderr}"
    );
}
