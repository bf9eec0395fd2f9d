//! `view`: the messages to its pages, the server, and the page in a browser, which `cargo xtask
//! test` installs.
#![cfg(target_os = "linux")]

mod common;
#[path = "view/page.rs"]
mod page;
#[path = "view/served.rs"]
mod served;
#[path = "view/served_runs.rs"]
mod served_runs;
#[path = "view/updates.rs"]
mod updates;

use ridgetone_finger::Pipeline;
use ridgetone_host::input::Input;
use ridgetone_host::recording::Keep;
use ridgetone_host::{recording, replay};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Packet, WIRE_MAX, encode};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};

/// What a board sends of the default scene up to a device time, with every frame as it was read.
fn packets(until_s: f64) -> Vec<Packet> {
    packets_with(Settings::DEFAULT, until_s)
}

fn packets_with(settings: Settings, until_s: f64) -> Vec<Packet> {
    packets_of(Input::default(), settings, until_s)
}

/// The packets of a slide at another speed.
fn packets_at(speed_mm_s: f64) -> Vec<Packet> {
    let mut input = Input::default();
    input.scene.speed_mm_s = speed_mm_s;
    packets_of(input, Settings::DEFAULT, f64::INFINITY)
}

fn packets_of(input: Input, settings: Settings, until_s: f64) -> Vec<Packet> {
    let mut events = Vec::new();
    let mut pipeline = Box::new(Pipeline::new(settings));
    pipeline.report_raw(u32::MAX);
    events.push(pipeline.hello());
    let mut first_us = None;
    let mut take = |timed: ridgetone_finger::TimedConversion| {
        let t_s = f64::from(timed.t_us - *first_us.get_or_insert(timed.t_us)) / 1e6;
        if t_s < until_s {
            pipeline.push(timed, &mut |event: Event| events.push(event));
        }
        Ok(())
    };
    replay::conversions(input.open().expect("a scene"), &mut take).expect("a run");
    (0..)
        .zip(events)
        .map(|(sequence, event)| Packet { sequence, event })
        .collect()
}

/// The packets as a recording.
fn recorded(folder: &Path, packets: &[Packet]) -> PathBuf {
    recorded_as(folder, "touch.rec", packets)
}

fn recorded_as(folder: &Path, name: &str, packets: &[Packet]) -> PathBuf {
    let path = folder.join(name);
    let mut file = recording::create(&path, "a test", 0.0).expect("a file");
    for packet in packets {
        let mut wire = [0; WIRE_MAX];
        let used = encode(packet, &mut wire).expect("it fits");
        file.keep(&wire[..used], None).expect("written");
    }
    path
}

/// `ridgetone view`, at its usual port or another free one.
struct View {
    child: Child,
    /// Such as `http://127.0.0.1:34567/`.
    url: String,
}

impl View {
    fn start(arguments: &[&str]) -> Self {
        Self::with(arguments, &[])
    }

    /// With some variables of the environment.
    fn with(arguments: &[&str], environment: &[(&str, &str)]) -> Self {
        let mut child = common::ridgetone()
            .arg("view")
            .args(arguments)
            .envs(environment.iter().copied())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command runs");
        let stdout = child.stdout.take().expect("a pipe");
        let mut url = String::new();
        BufReader::new(stdout).read_line(&mut url).expect("a line");
        Self {
            child,
            url: url.trim().to_owned(),
        }
    }

    /// Address and port.
    fn address(&self) -> &str {
        self.url.trim_start_matches("http://").trim_end_matches('/')
    }
}

impl Drop for View {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
