//! Recordings of the simulated finger, as sent by a board.
#![allow(dead_code, reason = "every program uses a part of it")]

use ridgetone_finger::Pipeline;
use ridgetone_host::input::Input;
use ridgetone_host::recording::Keep;
use ridgetone_host::{recording, replay};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Packet, WIRE_MAX, encode};
use std::path::{Path, PathBuf};

/// Returns the packets of the default scene up to this device time, with every raw frame.
pub fn packets(until_s: f64) -> Vec<Packet> {
    packets_of(Input::default(), until_s)
}

pub fn packets_at(speed_mm_s: f64) -> Vec<Packet> {
    let mut input = Input::default();
    input.scene.speed_mm_s = speed_mm_s;
    packets_of(input, f64::INFINITY)
}

fn packets_of(input: Input, until_s: f64) -> Vec<Packet> {
    let mut events = Vec::new();
    let mut pipeline = Box::new(Pipeline::new(Settings::DEFAULT));
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

pub fn recorded(folder: &Path, packets: &[Packet]) -> PathBuf {
    recorded_as(folder, "touch.rec", packets)
}

pub fn recorded_as(folder: &Path, name: &str, packets: &[Packet]) -> PathBuf {
    let path = folder.join(name);
    let mut file = recording::create(&path, "a test", 0.0).expect("a file");
    for packet in packets {
        let mut wire = [0; WIRE_MAX];
        let used = encode(packet, &mut wire).expect("it fits");
        file.keep(&wire[..used], None).expect("written");
    }
    path
}
