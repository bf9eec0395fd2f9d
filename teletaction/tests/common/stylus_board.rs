//! A stylus at a pseudo-terminal: its image's tasks run here in real time, with a hand that moves.
#![allow(dead_code, reason = "every test file uses a part of it")]

use super::serial_board::raw_end;
use ridgetone_finger::tasks::Outbox;
use ridgetone_finger::tasks::{Platform, Shared, Task};
use ridgetone_finger::tasks::{Received, RequestInbox, receive};
use ridgetone_proto::boot::Boot;
use ridgetone_proto::framing;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::telemetry::WIRE_MAX;
use ridgetone_teletaction::stylus::SAMPLE_US;
use ridgetone_teletaction::stylus::gate::State;
use ridgetone_teletaction::stylus::message::{Event, Mark, Packet};
use ridgetone_teletaction::stylus::parameters::Parameters;
use ridgetone_teletaction::stylus::reports::Reports;
use ridgetone_teletaction::stylus::sampler::Sampler;
use rtic_core::Exclusive;
use std::fs::File;
use std::io::{Read, Write};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// What the board did, sample by sample.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// Code of the converter for each sample.
    pub codes: Vec<u16>,
    /// What the gate said with it.
    pub states: Vec<State>,
    /// Parameters in force, as each greeting had them.
    pub parameters: Vec<Parameters>,
}

#[derive(Default)]
struct Inner {
    trace: Mutex<Trace>,
    is_mute: AtomicBool,
    restarts: AtomicBool,
    ends: AtomicBool,
}

pub struct StylusBoard {
    /// Name of its port.
    pub name: String,
    inner: Arc<Inner>,
}

impl StylusBoard {
    /// A board whose encoder counts what a hand does: counts by seconds since its start.
    pub fn new(counts: fn(f64) -> i64) -> Self {
        let (end, name) = raw_end();
        let inner = Arc::new(Inner::default());
        let board = Arc::clone(&inner);
        std::thread::spawn(move || run(&end, counts, &board));
        Self { name, inner }
    }

    pub fn trace(&self) -> Trace {
        self.inner.trace.lock().expect("a trace").clone()
    }

    /// It sends nothing from now on, or does again; it still hears.
    pub fn mute(&self, is_mute: bool) {
        self.inner.is_mute.store(is_mute, Relaxed);
    }

    /// As after a loss of power.
    pub fn restart(&self) {
        self.inner.restarts.store(true, Relaxed);
    }
}

impl Drop for StylusBoard {
    fn drop(&mut self) {
        self.inner.ends.store(true, Relaxed);
    }
}

/// Each task is called where an interrupt would start it.
struct Called;

impl Platform for Called {
    fn pend(_: &Shared<Self>, _: Task) {}

    fn now_us(&self) -> u32 {
        0
    }
}

struct Running {
    sampler: Sampler,
    reports: Reports,
    inbox: RequestInbox,
    outbox: Outbox<Mark<Event>>,
    shared: Shared<Called>,
}

impl Running {
    fn new() -> Self {
        Self {
            sampler: Sampler::new(),
            reports: Reports::new(Boot::UNKNOWN),
            inbox: RequestInbox::new(),
            outbox: Outbox::new(),
            shared: Shared::new(Called, Plan::PAPER),
        }
    }

    fn requests(&mut self) -> Vec<Packet> {
        let Self {
            sampler,
            reports,
            inbox,
            outbox,
            shared,
        } = self;
        let (mut sampler, mut inbox, mut outbox) =
            (Exclusive(sampler), Exclusive(inbox), Exclusive(outbox));
        reports.run(&mut sampler, &mut inbox, &mut outbox, shared);
        std::iter::from_fn(|| outbox.0.take()).collect()
    }
}

/// What comes from the other end, as it comes.
pub fn bytes_from(end: &File) -> Receiver<Vec<u8>> {
    let (bytes_in, bytes) = channel();
    let mut reader = end.try_clone().expect("an end");
    std::thread::spawn(move || {
        let mut read = [0; 256];
        loop {
            match reader.read(&mut read) {
                Ok(count) if bytes_in.send(read[..count].to_vec()).is_err() => return,
                Ok(_) => {}
                // Nobody has the other end.
                Err(_) => std::thread::sleep(Duration::from_millis(5)),
            }
        }
    });
    bytes
}

fn run(end: &File, counts: fn(f64) -> i64, inner: &Inner) {
    let bytes = bytes_from(end);
    let (mut board, begun, mut samples) = (Running::new(), Instant::now(), 0u32);
    // The counter of a board that starts is 0.
    let mut zero = 0;
    while !inner.ends.load(Relaxed) {
        if inner.restarts.swap(false, Relaxed) {
            board = Running::new();
            zero = counts(1e-6 * f64::from(samples) * f64::from(SAMPLE_US));
        }
        while let Ok(bytes) = bytes.try_recv() {
            for byte in bytes {
                receive(&mut board.inbox, Received::Byte(byte), &board.shared);
                let packets = board.requests();
                send(end, packets, inner);
            }
        }
        while f64::from(samples) * 1e-6 * f64::from(SAMPLE_US) < begun.elapsed().as_secs_f64() {
            samples += 1;
            let t_s = f64::from(samples) * 1e-6 * f64::from(SAMPLE_US);
            let code = board.sampler.next(
                samples.wrapping_mul(SAMPLE_US),
                0,
                (counts(t_s) - zero) as u16,
            );
            let is_due = board.sampler.written(false);
            {
                let mut trace = inner.trace.lock().expect("a trace");
                trace.codes.push(code);
                trace.states.push(board.sampler.look().state);
            }
            if is_due {
                let packets = board.requests();
                send(end, packets, inner);
            }
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn send(mut end: &File, packets: Vec<Packet>, inner: &Inner) {
    for packet in packets {
        if let Event::Hello(hello) = &packet.event.0 {
            inner
                .trace
                .lock()
                .expect("a trace")
                .parameters
                .push(hello.parameters);
        }
        let mut wire = [0; WIRE_MAX];
        let used = framing::encode(&packet, &mut wire).expect("it fits");
        if !inner.is_mute.load(Relaxed) {
            let _ = end.write_all(&wire[..used]);
        }
    }
}
