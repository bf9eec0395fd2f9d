//! A simulated board on a pseudo-terminal. It greets, answers requests and sends frames in real time.
#![allow(dead_code, reason = "every test file uses a part of it")]

use ridgetone_finger::{CONVERSION_NS, FRAME_NS};
use ridgetone_proto::boot::{Boot, SettingsSource};
use ridgetone_proto::command::{Command, Outcome, REQUEST_WIRE_MAX, Reply, Request};
use ridgetone_proto::framing::{self, Inbox, Pushed};
use ridgetone_proto::settings::{FRAME_RATE_HZ, Settings};
use ridgetone_proto::telemetry::{Event, Health, Hello, PROTOCOL, Packet, Raw, WIRE_MAX, encode};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::fs::File;
use std::io::{Read, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, channel};
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Duration of a byte at 921600 baud, seconds.
const BYTE_S: f64 = 10.0 / 921_600.0;

#[derive(Default)]
struct Shared {
    /// UTC at board time 0 in nanoseconds; 0 before the board begins.
    begun_ns: AtomicU64,
    frames: AtomicU64,
    /// Maximum delay of a packet on the line, microseconds.
    late_us: AtomicU64,
    stops: AtomicBool,
}

pub struct SerialBoard {
    pub name: String,
    shared: Arc<Shared>,
}

impl SerialBoard {
    pub fn new() -> Self {
        Self::of_rate(f64::from(FRAME_RATE_HZ))
    }

    /// Creates a board with this frame rate. Above the default rate, sending takes no time, because
    /// a real line carries only 1,100 frames per second.
    pub fn of_rate(rate_hz: f64) -> Self {
        let (end, name) = raw_end();
        let is_fast = rate_hz > f64::from(FRAME_RATE_HZ) + 1.0;
        // Time from a frame's stamp to the end of its last conversion.
        let frame_s = if is_fast {
            rate_hz.recip()
        } else {
            (FRAME_NS - CONVERSION_NS) as f64 * 1e-9
        };
        let shared = Arc::new(Shared::default());
        let mut line = BoardEnd {
            end,
            sequence: 0,
            byte_s: if is_fast { 0.0 } else { BYTE_S },
            shared: Arc::clone(&shared),
        };
        std::thread::spawn(move || line.run(rate_hz, frame_s));
        Self { name, shared }
    }

    /// Returns UTC at board time 0, seconds.
    pub fn begun_utc_s(&self) -> f64 {
        self.shared.begun_ns.load(Relaxed) as f64 * 1e-9
    }

    pub fn frames(&self) -> u64 {
        self.shared.frames.load(Relaxed)
    }

    /// Returns the maximum delay of a packet on the line, seconds.
    pub fn late_s(&self) -> f64 {
        self.shared.late_us.load(Relaxed) as f64 * 1e-6
    }

    pub fn stop(&self) {
        self.shared.stops.store(true, Relaxed);
    }
}

/// Returns the board's end of a line, and the name of the far end.
pub fn raw_end() -> (File, String) {
    let end =
        openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).expect("a terminal");
    grantpt(&end).expect("granted");
    unlockpt(&end).expect("unlocked");
    let mut modes = tcgetattr(&end).expect("modes");
    modes.make_raw();
    tcsetattr(&end, OptionalActions::Now, &modes).expect("raw");
    let name = ptsname(&end, Vec::new())
        .expect("a name")
        .into_string()
        .expect("ASCII");
    (File::from(end), name)
}

struct BoardEnd {
    end: File,
    sequence: u16,
    byte_s: f64,
    shared: Arc<Shared>,
}

impl BoardEnd {
    fn run(&mut self, rate_hz: f64, frame_s: f64) {
        let requests = requests(self.end.try_clone().expect("an end"));
        let hello = Event::Hello(Hello {
            protocol: PROTOCOL,
            version: [0, 1, 0],
            frame_rate_hz: rate_hz as f32,
            settings: Settings::DEFAULT,
            source: SettingsSource::Default,
            boot: Boot::UNKNOWN,
            t_us: 0,
        });
        // Waits until a program opens the line and requests frames.
        let mut wants = false;
        while !wants {
            self.send(hello.clone(), Instant::now());
            sleep(Duration::from_millis(50));
            wants = self.answer(&requests);
        }
        let (begun, utc) = (Instant::now(), SystemTime::now());
        let since = utc.duration_since(UNIX_EPOCH).expect("a clock");
        self.shared.begun_ns.store(since.as_nanos() as u64, Relaxed);
        for number in 0u32.. {
            if self.shared.stops.load(Relaxed) {
                return;
            }
            let t_s = f64::from(number) / rate_hz;
            let due = begun + Duration::from_secs_f64(t_s + frame_s);
            sleep(due.saturating_duration_since(Instant::now()));
            let t_us = (t_s * 1e6).round() as u64;
            let codes = std::array::from_fn(|taxel| {
                2_000_000 + (number as i32 % 1000) * 100 + taxel as i32
            });
            self.send(
                Event::Raw(Raw {
                    t_us,
                    number,
                    present: u16::MAX,
                    good: u16::MAX,
                    codes,
                }),
                due,
            );
            self.shared.frames.fetch_add(1, Relaxed);
            if number % rate_hz as u32 == 0 {
                self.send(
                    Event::Health(Health {
                        t_us,
                        frames: number,
                        ..Health::default()
                    }),
                    due,
                );
            }
            self.answer(&requests);
        }
    }

    /// Answers requests. Returns true if frames were requested.
    fn answer(&mut self, requests: &Receiver<Request>) -> bool {
        let mut wants = false;
        while let Ok(Request { number, command }) = requests.try_recv() {
            wants |= matches!(command, Command::Raw { .. });
            self.send(
                Event::Reply(Reply::new(number, Outcome::Done)),
                Instant::now(),
            );
        }
        wants
    }

    /// Sends a packet after the time that its bytes take on the line, and records its delay.
    fn send(&mut self, event: Event, due: Instant) {
        let mut wire = [0; WIRE_MAX];
        let used = encode(
            &Packet {
                sequence: self.sequence,
                event,
            },
            &mut wire,
        )
        .expect("it fits");
        self.sequence = self.sequence.wrapping_add(1);
        sleep(Duration::from_secs_f64(self.byte_s * used as f64));
        // Ignore errors, because writing fails if the far end is closed.
        let _ = self.end.write_all(&wire[..used]);
        self.shared
            .late_us
            .fetch_max(due.elapsed().as_micros() as u64, Relaxed);
    }
}

/// Receives requests from a line and returns them through a channel.
fn requests(mut end: File) -> Receiver<Request> {
    let (found, requests) = channel();
    std::thread::spawn(move || {
        let (mut inbox, mut bytes) = (Inbox::<REQUEST_WIRE_MAX>::new(), [0; 256]);
        loop {
            // Reading fails while the far end is closed.
            let Ok(count) = end.read(&mut bytes) else {
                sleep(Duration::from_millis(10));
                continue;
            };
            for byte in &bytes[..count] {
                if inbox.push(*byte) == Pushed::Whole
                    && let Some(request) = inbox
                        .take()
                        .and_then(|mut frame| framing::decode(&mut frame))
                {
                    // If the board has stopped, nobody receives the request, but its line is still
                    // read.
                    let _ = found.send(request);
                }
            }
        }
    });
    requests
}
