//! Two fingers through all that goes wrong while a robot works, and counts that add up: `cargo xtask
//! soak`.

use crate::cable::Cable;
use crate::common;
use crate::figures::{Table, tenths};
use crate::mosquitto::{self, Broker, Received, Subscriber, Take};
use crate::process::{memory_mb, processor_s};
use crate::serial_board::SerialBoard;
use crate::serving::Serving;
use ridgetone_proto::settings::FRAME_RATE_HZ;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::ops::RangeInclusive;
use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Between two things that happen.
const CALM: Duration = Duration::from_secs(8);

/// How long a cable is pulled.
const PULLED: Duration = Duration::from_secs(3);

/// How long a broker is away, one after the other, seconds: the queue in front of it holds 8 s of
/// two fingers.
const AWAY_S: [u64; 3] = [2, 12, 5];

/// Seconds after a broker's return until a subscriber has come back, too.
const COMES_BACK_S: f64 = 8.0;

/// Silence after which a load has failed. A browser waits for ever, so that this is a bound for a
/// server that is stuck, not for a slow one: at a fiftieth of a core a load takes 10 s and more.
const SILENT: Duration = Duration::from_secs(120);

/// The messages of a subscriber, by topic: receipts by number, and the last status.
#[derive(Default)]
struct Arrivals {
    receipts: BTreeMap<String, BTreeMap<u64, f64>>,
    status: Value,
    count: usize,
    is_over: bool,
}

impl Take for Arrivals {
    fn take(&mut self, message: Received) {
        self.count += 1;
        self.is_over = message.is_end();
        if message.topic == "ridgetone/status" {
            self.status = message.message;
        } else if let (Some(index), false) =
            (message.message["index"].as_u64(), message.is_retained)
        {
            let topic = self.receipts.entry(message.topic).or_default();
            topic.entry(index).or_insert(message.utc_s);
        }
    }

    fn count(&self) -> usize {
        self.count
    }

    fn is_over(&self) -> bool {
        self.is_over
    }
}

/// How often a page was loaded, and the longest time until its state was there.
#[derive(Clone, Copy, Debug, Default)]
struct Loads {
    count: u64,
    slowest: Duration,
}

/// `ridgetone view` at a port, whose page is loaded again and again.
struct Page {
    child: Child,
    url: String,
    ends: Arc<AtomicBool>,
    loader: Option<JoinHandle<Loads>>,
}

impl Page {
    fn start(port: &Path) -> Self {
        let mut view = common::ridgetone();
        view.args(["view", "--port", common::text(port)]);
        let mut child = view
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the command runs");
        let mut url = String::new();
        BufReader::new(child.stdout.take().expect("a pipe"))
            .read_line(&mut url)
            .expect("a line");
        let url = url.trim().trim_end_matches('/').to_owned();
        let ends = Arc::new(AtomicBool::new(false));
        let (end, host) = (Arc::clone(&ends), url[7..].to_owned());
        let loader = std::thread::spawn(move || {
            let mut loads = Loads::default();
            while !end.load(Relaxed) {
                let begun = Instant::now();
                assert!(get(&host, "/").contains("<title>Ridgetone</title>"));
                assert!(state(&host)["update"].is_u64());
                loads.count += 1;
                loads.slowest = loads.slowest.max(begun.elapsed());
                sleep(Duration::from_millis(700));
            }
            loads
        });
        Self {
            child,
            url,
            ends,
            loader: Some(loader),
        }
    }

    /// Ends the loads, of which each must have succeeded.
    fn loads(&mut self) -> Loads {
        self.ends.store(true, Relaxed);
        let loader = self.loader.take().expect("once");
        loader.join().expect("every load succeeds")
    }

    /// The counts of the line, as the page has them.
    fn counts(&self) -> Counts {
        let counts = &state(&self.url[7..])["live"]["counts"];
        let [received, missing, damaged] =
            ["received", "missing", "damaged"].map(|name| counts[name].as_u64().expect("a count"));
        Counts {
            received,
            missing,
            damaged,
        }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.ends.store(true, Relaxed);
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What a server answers to a path, up to the end of its first event or of it all.
fn get(host: &str, path: &str) -> String {
    let mut line = TcpStream::connect(host).expect("it listens");
    line.set_read_timeout(Some(SILENT)).expect("a limit");
    let request = format!("GET {path} HTTP/1.0\r\nHost: {host}\r\n\r\n");
    line.write_all(request.as_bytes()).expect("sent");
    let (mut bytes, mut part) = (Vec::new(), [0; 65_536]);
    let begun = Instant::now();
    loop {
        match line.read(&mut part) {
            Ok(0) => break,
            Ok(length) => bytes.extend_from_slice(&part[..length]),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => panic!(
                "{path}: {error} after {:.1?} and {} bytes",
                begun.elapsed(),
                bytes.len()
            ),
        }
        let is_event = path == "/events" && bytes.ends_with(b"\n\n");
        if is_event && bytes.windows(5).any(|part| part == b"data:") {
            break;
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The state that a page gets when it is loaded.
fn state(host: &str) -> Value {
    let events = get(host, "/events");
    let data = events.lines().find_map(|line| line.strip_prefix("data:"));
    let data = data.unwrap_or_else(|| panic!("no state: {events:?}"));
    serde_json::from_str(data).expect("JSON")
}

/// What a reader says of a board's line.
#[derive(Clone, Copy, Debug)]
struct Counts {
    received: u64,
    missing: u64,
    damaged: u64,
}

impl Counts {
    /// As `serve` reports them at its end.
    fn reported(stderr: &str, finger: &str) -> Self {
        let name = format!("ridgetone: {finger}: ");
        let line = stderr.lines().find_map(|line| {
            line.strip_prefix(&name)
                .filter(|line| line.contains("telemetry frames received"))
        });
        let numbers: Vec<u64> = line
            .unwrap_or_else(|| panic!("no counts of {finger}: {stderr}"))
            .split(' ')
            .filter_map(|word| word.parse().ok())
            .collect();
        Self {
            received: numbers[0],
            missing: numbers[1],
            damaged: numbers[2],
        }
    }

    /// Every packet of the board was received or is missing by its number. Which of its greetings
    /// was the first, before anybody listened, is not known.
    fn check(&self, finger: &str, packets: &RangeInclusive<u64>, wrong: &mut Vec<String>) {
        let Self {
            received,
            missing,
            damaged,
        } = self;
        println!(
            "{finger}, line: {} to {} packets sent = {received} received + {missing} lost ({damaged} damaged)",
            packets.start(),
            packets.end()
        );
        if !packets.contains(&(received + missing)) {
            wrong.push(format!("{finger}: the packets of the line"));
        }
    }
}

/// Gives what is lacking on a topic, apart from the seconds around the broker's restarts, and in all.
fn lacking(receipts: &BTreeMap<u64, f64>, restarts: &[RangeInclusive<f64>]) -> [u64; 2] {
    let (mut before, mut found) = ((u64::MAX, 0.0), [0, 0]);
    for (index, utc_s) in receipts {
        let missing = index.wrapping_sub(before.0.wrapping_add(1));
        let is_excused = restarts
            .iter()
            .any(|restart| *restart.start() <= *utc_s && before.1 <= *restart.end());
        found[0] += if is_excused { 0 } else { missing };
        found[1] += missing;
        before = (*index, *utc_s);
    }
    found
}

fn now_utc_s() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.expect("a clock").as_secs_f64()
}

#[test]
#[ignore = "an hour, or RIDGETONE_SOAK_MINUTES"]
fn two_fingers_a_broker_that_restarts_pages_that_reload_and_cables_that_are_pulled() {
    let minutes =
        std::env::var("RIDGETONE_SOAK_MINUTES").map_or(60.0, |text| text.parse().expect("minutes"));
    let folder = common::directory();
    let boards = [(); 2].map(|()| SerialBoard::waiting(f64::from(FRAME_RATE_HZ)));
    let cables =
        [0, 1].map(|n| Cable::new(&boards[n].name, folder.path().join(format!("port{n}"))));
    let port = mosquitto::free_port();
    let mut broker = Some(Broker::start_at(port));
    let subscriber = Subscriber::<Arrivals>::of(port);
    let mut page = Page::start(&cables[1].path);
    let url = format!("mqtt://127.0.0.1:{port}");
    let serving = Serving::of(
        &[common::text(&cables[0].path), &page.url],
        &["--mqtt", &url],
        &[],
    );
    boards.iter().for_each(SerialBoard::begin);

    let (begun, mut restarts, mut pulls, mut damages) = (Instant::now(), Vec::new(), 0, 0);
    let mut memory = Vec::new();
    for round in 0.. {
        sleep(CALM);
        memory.push([serving.id(), page.child.id()].map(memory_mb));
        if begun.elapsed().as_secs_f64() > 60.0 * minutes {
            break;
        }
        match round % 4 {
            0 => {
                let from_s = now_utc_s() - 2.0;
                drop(broker.take());
                let away_s = AWAY_S[restarts.len() % AWAY_S.len()];
                sleep(Duration::from_secs(away_s));
                broker = Some(Broker::start_at(port));
                restarts.push(from_s..=now_utc_s() + COMES_BACK_S);
            }
            2 => {
                cables.iter().for_each(Cable::damage);
                damages += cables.len();
            }
            pulled => {
                let cable = &cables[pulled / 2];
                cable.pull(true);
                sleep(PULLED);
                cable.pull(false);
                pulls += 1;
            }
        }
    }
    sleep(CALM);
    boards.iter().for_each(SerialBoard::stop);
    sleep(Duration::from_secs(2));

    let length_s = begun.elapsed().as_secs_f64();
    let busy = [serving.id(), page.child.id()].map(|id| 100.0 * processor_s(id) / length_s);
    let (at_page, loads) = (page.counts(), page.loads());
    let stderr = serving.interrupt();
    let arrivals = subscriber.finish();
    println!(
        "{length_s:.0} s: {} restarts of the broker, {pulls} cables pulled, {damages} bytes damaged, {} loads of the page, the slowest {:.1?}",
        restarts.len(),
        loads.count,
        loads.slowest
    );
    let mut happened = Table::new(&["what happened", "times"]);
    happened.rows = vec![
        json!(["minutes", tenths(length_s / 60.0)]),
        json!(["broker restarted", restarts.len()]),
        json!(["cable pulled", pulls]),
        json!(["byte damaged", damages]),
        json!(["page loaded", loads.count]),
        json!([
            "slowest load of the page, s",
            tenths(loads.slowest.as_secs_f64())
        ]),
    ];
    let mut frames = Table::new(&[
        "finger",
        "frames sent",
        "published",
        "lost on the line",
        "received",
        "lost and counted",
        "published while the subscriber was away",
    ]);
    let mut wrong = Vec::new();
    Counts::reported(&stderr, "f0").check("f0", &boards[0].packets(), &mut wrong);
    at_page.check("f1", &boards[1].packets(), &mut wrong);
    for (board, finger, line) in [
        (&boards[0], "f0", Counts::reported(&stderr, "f0")),
        (&boards[1], "f1", at_page),
    ] {
        let row = check_frames(board, finger, &line, &arrivals, &mut wrong);
        frames.rows.push(row);
    }
    for (topic, receipts) in &arrivals.receipts {
        let [unexcused, all] = lacking(receipts, &restarts);
        println!(
            "{topic}: {} received, {all} lacking, of which {unexcused} away from a restart",
            receipts.len()
        );
        if unexcused > 0 {
            wrong.push(format!(
                "{topic}: {unexcused} lacking while the broker was there"
            ));
        }
    }
    let (early, late) = (memory[memory.len() / 4], memory[memory.len() - 1]);
    let mut memory_of = Table::new(&[
        "command",
        "% of a core",
        "MB after a quarter",
        "MB at the end",
    ]);
    for (n, name) in ["serve", "view"].into_iter().enumerate() {
        let [early_mb, late_mb] = [early[n], late[n]].map(|mb| mb.round() as u64);
        memory_of
            .rows
            .push(json!([name, tenths(busy[n]), early_mb, late_mb]));
        println!(
            "{name}: {:.1} % of a core, {:.0} MB after a quarter, {:.0} MB at the end",
            busy[n], early[n], late[n]
        );
    }
    if loads.count == 0 || restarts.is_empty() || pulls == 0 {
        wrong.push("too short for anything to happen".into());
    }
    drop((broker, page));
    assert!(wrong.is_empty(), "does not add up: {wrong:#?}\n{stderr}");
    println!("all counts add up");
    happened.write("soak");
    frames.write("soak_frames");
    memory_of.write("soak_commands");
}

/// A board's frames are published, or lost on the line, where packets of other kinds are lost, too.
/// Published frames that do not arrive are counted as lost, or came while the subscriber was away.
/// Gives the counts as a row.
fn check_frames(
    board: &SerialBoard,
    finger: &str,
    line: &Counts,
    arrivals: &Arrivals,
    wrong: &mut Vec<String>,
) -> Value {
    let status = &arrivals.status["fingers"][finger];
    let published = status["published"]["frames"].as_u64().unwrap_or(0);
    let lost = status["lost"]["frames"].as_u64().unwrap_or(0);
    let topic = format!("ridgetone/{finger}/frames");
    let received = arrivals
        .receipts
        .get(&topic)
        .map_or(0, |receipts| receipts.len() as u64);
    let on_line = board.frames() - published;
    let (sent, away) = (board.frames(), (published - lost).saturating_sub(received));
    println!(
        "{finger}, frames: {sent} sent = {published} published + {on_line} lost on the line; {received} received, {lost} lost and counted, {away} while the subscriber was away"
    );
    let others = board.packets().end() - board.frames();
    if !(line.missing.saturating_sub(others)..=line.missing).contains(&on_line) {
        wrong.push(format!(
            "{finger}: {on_line} frames lost on a line that lost {} packets",
            line.missing
        ));
    }
    if received + lost > published {
        wrong.push(format!("{finger}: more frames than were published"));
    }
    json!([finger, sent, published, on_line, received, lost, away])
}
