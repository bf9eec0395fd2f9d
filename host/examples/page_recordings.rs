//! Writes the recordings that the page's tests use into a folder.

#[path = "../tests/common/board_recordings.rs"]
mod board_recordings;

use board_recordings::{packets, packets_at, recorded_as};
use ridgetone_proto::telemetry::{Event, Movement, OtherTone, Packet, Status};
use std::path::PathBuf;

fn main() {
    let folder = std::env::args_os()
        .nth(1)
        .map(PathBuf::from)
        .expect("a folder");
    let part = packets(3.2);
    let all = [
        ("touch.rec", packets(f64::INFINITY)),
        ("part.rec", part.clone()),
        ("begin.rec", packets(0.6)),
        ("quiet.rec", packets(0.5)),
        ("slower.rec", packets_at(20.0)),
        ("unsteady.rec", unsteady(part.clone())),
        ("wild.rec", wild(part)),
    ];
    for (name, packets) in all {
        recorded_as(&folder, name, &packets);
    }
}

/// Makes the latest estimate unsteady with a second tone, and removes the raw frames.
fn unsteady(mut packets: Vec<Packet>) -> Vec<Packet> {
    packets.retain(|packet| !matches!(packet.event, Event::Raw(_)));
    let mut estimates = packets.iter_mut().rev().filter_map(estimate);
    if let Some(estimate) = estimates.next() {
        estimate.status = Status::Unsteady;
        estimate.movement = Movement {
            wander: 0.02,
            wander_sigma: 0.001,
            ..Movement::default()
        };
        estimate.other_tone = Some(OtherTone {
            frequency: 12.5,
            fraction: 0.25,
        });
    }
    (0..)
        .zip(packets)
        .map(|(sequence, packet)| Packet { sequence, ..packet })
        .collect()
}

/// Makes one estimate wildly wrong, and one raw frame a spike in all channels.
fn wild(mut packets: Vec<Packet>) -> Vec<Packet> {
    if let Some(estimate) = packets.iter_mut().filter_map(estimate).nth(1) {
        (estimate.frequency, estimate.status) = (90.0, Status::Ambiguous);
    }
    let raw = |packet| match packet {
        &mut Packet {
            event: Event::Raw(ref mut raw),
            ..
        } => Some(raw),
        _ => None,
    };
    if let Some(raw) = packets.iter_mut().filter_map(raw).nth(700) {
        raw.codes = [7_000_000; 16];
    }
    packets
}

fn estimate(packet: &mut Packet) -> Option<&mut ridgetone_proto::telemetry::Estimate> {
    match &mut packet.event {
        Event::Estimate(estimate) => Some(estimate),
        _ => None,
    }
}
