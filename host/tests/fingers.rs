//! Many fingers through one broker and one router of Zenoh, and what the commands take of a
//! computer: the figures of docs/results/live.json. `cargo xtask streams --fingers 100`.
#![cfg(target_os = "linux")]

mod common;
#[path = "streams/figures.rs"]
mod figures;
#[path = "streams/mosquitto.rs"]
mod mosquitto;
#[path = "common/process.rs"]
mod process;
#[path = "fingers/receiver.rs"]
mod receiver;
#[path = "common/serial_board.rs"]
mod serial_board;
#[path = "streams/serving.rs"]
mod serving;

use figures::{Table, tenths};
use mosquitto::{Broker, free_port};
use process::{find_memory_mb, find_processor_s, memory_mb, processor_s};
use receiver::{Arrivals, MqttReceiver, Router};
use ridgetone_proto::VERSION;
use ridgetone_proto::boot::{Boot, SettingsSource};
use ridgetone_proto::settings::{FRAME_RATE_HZ, Settings};
use ridgetone_proto::telemetry::{Event, Hello, PROTOCOL, Packet, Raw, WIRE_MAX, encode};
use serde_json::json;
use serial_board::SerialBoard;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Seconds that a measurement lasts unless `RIDGETONE_STREAMS_S` says otherwise.
const SECONDS: u32 = 20;

/// Time that receivers have after the last message was published.
const LAST: Duration = Duration::from_secs(2);

fn from_environment(name: &str, otherwise: u32) -> u32 {
    std::env::var(name).map_or(otherwise, |text| text.parse().expect("a number"))
}

/// A recording of so many seconds of raw frames of 16 channels, and the number of its frames.
fn recording(folder: &Path, seconds: u32) -> (PathBuf, u64) {
    let rate_hz = f64::from(FRAME_RATE_HZ);
    let frames = (f64::from(seconds) * rate_hz) as u32;
    let hello = Event::Hello(Hello {
        protocol: PROTOCOL,
        version: VERSION,
        frame_rate_hz: FRAME_RATE_HZ,
        settings: Settings::DEFAULT,
        source: SettingsSource::Default,
        boot: Boot::UNKNOWN,
        t_us: 0,
    });
    let raw = (0..frames).map(|number| {
        Event::Raw(Raw {
            t_us: (f64::from(number) / rate_hz * 1e6).round() as u64,
            number,
            present: u16::MAX,
            good: u16::MAX,
            codes: std::array::from_fn(|taxel| {
                2_000_000 + (number as i32 % 1000) * 100 + taxel as i32
            }),
        })
    });
    let (mut bytes, mut wire) = (Vec::new(), [0; WIRE_MAX]);
    for (number, event) in std::iter::once(hello).chain(raw).enumerate() {
        let packet = Packet {
            sequence: number as u16,
            event,
        };
        let used = encode(&packet, &mut wire).expect("it fits");
        bytes.extend_from_slice(&wire[..used]);
    }
    let path = folder.join("finger.rec");
    std::fs::write(&path, bytes).expect("written");
    (path, u64::from(frames))
}

/// What `serve` took and said until its recordings were over.
struct Served {
    seconds: f64,
    busy_s: f64,
    memory_mb: f64,
    stderr: String,
}

impl Served {
    fn run(fingers: u32, recording: &Path, arguments: &[&str]) -> Self {
        let names = (0..fingers).map(|n| format!("--finger=f{n}={}", common::text(recording)));
        let mut command = common::ridgetone();
        command
            .arg("serve")
            .args(names)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let begun = Instant::now();
        let mut child = command.spawn().expect("the command runs");
        let mut printed = child.stderr.take().expect("a pipe");
        let reader = std::thread::spawn(move || {
            let mut text = String::new();
            printed.read_to_string(&mut text).expect("UTF-8");
            text
        });
        let (mut busy_s, mut memory) = (0.0, 0.0f64);
        let status = loop {
            if let (Some(busy), Some(now)) =
                (find_processor_s(child.id()), find_memory_mb(child.id()))
            {
                (busy_s, memory) = (busy, memory.max(now));
            }
            if let Some(status) = child.try_wait().expect("a child") {
                break status;
            }
            sleep(Duration::from_millis(100));
        };
        let stderr = reader.join().expect("what it said");
        assert!(status.success(), "{stderr}");
        Self {
            seconds: begun.elapsed().as_secs_f64(),
            busy_s,
            memory_mb: memory,
            stderr,
        }
    }

    /// Frames that `serve` counts as lost at a sink.
    fn lost(&self, sink: &str) -> u64 {
        let begins = format!("ridgetone: {sink}: ");
        let line = self.stderr.lines().find_map(|line| {
            line.strip_prefix(&begins)
                .filter(|line| line.contains(" messages delivered, "))
        });
        let line = line.unwrap_or_else(|| panic!("no counts of {sink}: {}", self.stderr));
        let numbers: Vec<u64> = line
            .split(' ')
            .filter_map(|word| word.parse().ok())
            .collect();
        let [_, frames, events, others @ ..] = &numbers[..] else {
            panic!("no counts: {line}")
        };
        assert_eq!(*events, 0, "an event is lost: {line}");
        frames + others.iter().sum::<u64>()
    }
}

/// A row: what became of the frames of so many fingers.
struct Row<'a> {
    fingers: u32,
    receiver: &'static str,
    sent: u64,
    arrivals: &'a Arrivals,
    /// By `serve`, and by the broker.
    counted: [u64; 2],
    served: &'a Served,
    /// Processor time of the broker or router and of the receiver, seconds.
    others_s: f64,
}

impl Row<'_> {
    fn add_to(self, table: &mut Table) {
        let Self {
            fingers,
            receiver,
            sent,
            arrivals,
            counted: [by_serve, by_broker],
            served,
            others_s,
        } = self;
        let arrived = arrivals.frames();
        let silent = sent.saturating_sub(arrived + by_serve + by_broker);
        let late_ms = arrivals.late_ms();
        let part = |share: f64| {
            late_ms
                .get(((late_ms.len().max(1) - 1) as f64 * share) as usize)
                .map(|ms| tenths(*ms))
        };
        let percent = |busy_s: f64| (100.0 * busy_s / served.seconds).round() as u64;
        let row = json!([
            fingers,
            receiver,
            sent,
            arrived,
            by_serve,
            by_broker,
            silent,
            part(0.5),
            part(0.99),
            percent(served.busy_s),
            percent(others_s),
            served.memory_mb.round() as u64,
        ]);
        println!("{row}");
        table.rows.push(row);
        assert!(arrived <= sent, "{arrived} of {sent}");
    }
}

const COLUMNS: [&str; 12] = [
    "fingers",
    "receiver",
    "frames",
    "arrived",
    "lost in `serve`, counted",
    "lost in the broker, counted by it",
    "lost, not counted",
    "p50, ms",
    "p99, ms",
    "`serve`, % of a core",
    "broker or router and receiver, % of a core",
    "`serve`, MB",
];

/// Every frame of a number that two cores bear arrives; of more, what does not is counted.
#[test]
#[ignore = "minutes: cargo xtask streams --fingers 100"]
fn many_fingers_through_a_broker_and_a_router() {
    let most = from_environment("RIDGETONE_FINGERS", 10);
    let seconds = from_environment("RIDGETONE_STREAMS_S", SECONDS);
    let folder = common::directory();
    let (path, frames) = recording(folder.path(), seconds);
    let mut table = Table::new(&COLUMNS);
    for share in [10, 4, 2, 1] {
        let fingers = most.div_ceil(share);
        let sent = frames * u64::from(fingers);

        let broker = Broker::start();
        let receiver = MqttReceiver::start(broker.port);
        let url = format!("mqtt://127.0.0.1:{}", broker.port);
        let served = Served::run(fingers, &path, &["--mqtt", &url]);
        sleep(LAST);
        let others_s = processor_s(broker.id()) + receiver.processor_s();
        let dropped = receiver::dropped(broker.port);
        let arrivals = receiver.finish();
        let counted = [served.lost("mqtt"), dropped];
        Row {
            fingers,
            receiver: "mqtt",
            sent,
            arrivals: &arrivals,
            counted,
            served: &served,
            others_s,
        }
        .add_to(&mut table);

        let (port, before_s) = (free_port(), processor_s(std::process::id()));
        let router = Router::start(port);
        let address = format!("tcp/127.0.0.1:{port}");
        let served = Served::run(fingers, &path, &["--zenoh", &address]);
        sleep(LAST);
        let others_s = processor_s(std::process::id()) - before_s;
        let arrivals = router.finish();
        Row {
            fingers,
            receiver: "zenoh",
            sent,
            arrivals: &arrivals,
            counted: [served.lost("zenoh"), 0],
            served: &served,
            others_s,
        }
        .add_to(&mut table);
    }
    for row in &table.rows {
        assert_eq!(row[6], 0, "frames are lost that nobody counts: {row}");
    }
    table.write("fingers");
}

/// A command that reads a board at a port, and is ended after the measurement.
struct Reader(Child);

impl Reader {
    fn start(arguments: &[&str], port: &str) -> Self {
        let mut command = common::ridgetone();
        command
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        command.args(match arguments[0] {
            "serve" => vec![format!("--finger=f0={port}")],
            _ => vec!["--port".to_owned(), port.to_owned()],
        });
        Self(command.spawn().expect("the command runs"))
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Takes what a command prints; of `view`, the events of its page too.
fn drain(mut out: impl Read + Send + 'static) {
    std::thread::spawn(move || {
        let mut bytes = [0; 65_536];
        let mut is_first = true;
        while let Ok(length @ 1..) = out.read(&mut bytes) {
            let text = String::from_utf8_lossy(&bytes[..length]);
            if let (true, Some(host)) = (is_first, text.trim().strip_prefix("http://")) {
                let host = host.trim_end_matches('/');
                let mut page = TcpStream::connect(host).expect("it listens");
                write!(page, "GET /events HTTP/1.0\r\nHost: {host}\r\n\r\n").expect("sent");
                drain(page);
            }
            is_first = false;
        }
    });
}

#[test]
#[ignore = "minutes: cargo xtask streams --fingers 100"]
fn memory_and_processor_time_of_the_commands() {
    let seconds = from_environment("RIDGETONE_STREAMS_S", SECONDS);
    let folder = common::directory();
    let file = folder.path().join("touch.rec");
    let mut table = Table::new(&["command", "% of a core", "MB"]);
    let record = ["record", "--raw", "-o", common::text(&file)];
    let commands: [&[&str]; 6] = [
        &["monitor", "--plain", "--raw"],
        &["monitor", "--plain"],
        &["monitor", "--raw", "--json"],
        &record,
        &["view", "--listen", "127.0.0.1:0"],
        &["serve", "--json"],
    ];
    for arguments in commands {
        let board = SerialBoard::new();
        let mut reader = Reader::start(arguments, &board.name);
        drain(reader.0.stdout.take().expect("a pipe"));
        sleep(Duration::from_secs(3));
        let (id, before, begun) = (reader.0.id(), board.frames(), Instant::now());
        let busy_s = processor_s(id);
        sleep(Duration::from_secs(u64::from(seconds)));
        let percent = 100.0 * (processor_s(id) - busy_s) / begun.elapsed().as_secs_f64();
        let is_raw = arguments != ["monitor", "--plain"];
        assert!(
            !is_raw || board.frames() > before,
            "{arguments:?} reads no frames"
        );
        let shown = match arguments[0] {
            "record" => "record --raw -o touch.rec".to_owned(),
            "view" => "view, one page open".to_owned(),
            _ => arguments.join(" "),
        };
        let row = json!([shown, tenths(percent), memory_mb(id).round() as u64]);
        println!("{row}");
        table.rows.push(row);
    }
    table.write("commands");
}
