//! Reads exports back with independent readers.

use super::*;
use crate::input::Input;
use crate::recording::Keep;
use crate::serve::schema;
use crate::serve::topic::Topic;
use crate::tables::Table;
use crate::{recording, replay};
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Event, Packet, Raw, WIRE_MAX, encode};
use std::path::PathBuf;

/// Records the default scene and 100 raw frames, of which number 50 lacks a taxel.
fn recorded(folder: &Path) -> PathBuf {
    let path = folder.join("touch.rec");
    let mut bytes = replay::run(
        Input::default().open().unwrap(),
        Settings::DEFAULT,
        &mut |_| Ok(()),
        &mut |_, _| {},
    )
    .unwrap()
    .serial;
    let sent = bytes.iter().filter(|byte| **byte == 0).count() as u16;
    for number in 0..100 {
        let codes = std::array::from_fn(|taxel| (number as i32 + 1) * 1000 * taxel as i32);
        let present = if number == 50 { !2 } else { u16::MAX };
        let raw = Raw {
            t_us: 6_000_000 + 4147 * u64::from(number),
            number,
            present,
            good: !1,
            codes,
        };
        let mut wire = [0; WIRE_MAX];
        let packet = Packet {
            sequence: sent + number as u16,
            event: Event::Raw(raw),
        };
        let used = encode(&packet, &mut wire).unwrap();
        bytes.extend(&wire[..used]);
    }
    recording::create(&path, "a test", 0.0)
        .unwrap()
        .keep(&bytes, None)
        .unwrap();
    path
}

fn exported(format: Format, kind: Kind) -> (Vec<u8>, Counts) {
    let folder = tempfile::tempdir().unwrap();
    let mut out = Vec::new();
    let counts = run(&recorded(folder.path()), format, kind, &mut out).unwrap();
    assert_eq!((counts.missing, counts.damaged), (0, 0));
    (out, counts)
}

#[test]
fn frames_become_a_table_that_replay_takes() {
    let (csv, _) = exported(Format::Csv, Kind::Frames);
    let table = Table::parse(&csv, "frames").unwrap();
    assert_eq!((table.names().len(), table.rows().len()), (TAXELS, 99));
    assert_eq!(table.time_s().unwrap()[1], 6.004147);
    // Taxel 0 was never good; 7,864,320 codes are the reference of 4.096 V (SBAS297G).
    for (channel, volts) in table.rows()[9].iter().enumerate() {
        let expected = 10_000.0 * channel as f64 * 4.096 / 7_864_320.0;
        assert!((volts - expected).abs() < 1e-7, "{channel}: {volts}");
    }
}

#[test]
fn estimates_and_health_have_a_row_each_and_no_number_where_none_is_known() {
    let (csv, _) = exported(Format::Csv, Kind::Estimates);
    let mut rows = csv::Reader::from_reader(csv.as_slice());
    let header = rows.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|found| found == name).unwrap();
    let rows: Vec<_> = rows.records().map(Result::unwrap).collect();
    assert!(rows.len() > 3);
    let whole = rows
        .iter()
        .find(|row| &row[column("span")] == "slide")
        .unwrap();
    assert!(
        (whole[column("frequency_hz")].parse::<f64>().unwrap() / (30.0 / 3.6) - 1.0).abs() < 1e-3
    );
    let (csv, _) = exported(Format::Csv, Kind::Health);
    assert_eq!(
        csv::Reader::from_reader(csv.as_slice()).records().count(),
        6
    );
}

#[test]
fn a_texture_has_a_row_each() {
    let (csv, _) = exported(Format::Csv, Kind::Texture);
    let mut rows = csv::Reader::from_reader(csv.as_slice());
    let header = rows.headers().unwrap().clone();
    assert_eq!(
        header.iter().collect::<Vec<_>>(),
        [
            "t_s",
            "plan",
            "period_mm",
            "period_sigma_mm",
            "power_v2",
            "power_sigma_v2",
            "overtones_0_amplitude",
            "overtones_0_phase_cycles",
            "overtones_1_amplitude",
            "overtones_1_phase_cycles",
            "overtones_2_amplitude",
            "overtones_2_phase_cycles",
            "level_v"
        ]
    );
    let rows: Vec<_> = rows.records().map(Result::unwrap).collect();
    assert_eq!((rows.len(), &rows[0][1]), (1, "paper"));
    // The period must be that of the default scene's grating.
    let [period_mm, sigma_mm] = [2, 3].map(|at| rows[0][at].parse::<f64>().unwrap());
    assert!(
        (period_mm - 3.6).abs() < 4.0 * sigma_mm,
        "{period_mm} {sigma_mm}"
    );
}

#[test]
fn a_recording_without_frames_says_how_to_get_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("empty.rec");
    recording::create(&path, "a test", 0.0).unwrap();
    let error = run(&path, Format::Csv, Kind::Frames, &mut Vec::new())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("empty.rec") && error.contains("record with --raw"),
        "{error}"
    );
    assert!(run(&path, Format::Mcap, Kind::Frames, &mut Vec::new()).is_err());
}

#[test]
fn json_lines_have_every_packet() {
    let (lines, counts) = exported(Format::Ndjson, Kind::Estimates);
    let text = String::from_utf8(lines).unwrap();
    assert_eq!(text.lines().count() as u64, counts.received);
    assert!(text.lines().all(|line| {
        serde_json::from_str::<serde_json::Value>(line).unwrap()["sequence"].is_u64()
    }));
}

#[test]
fn mcap_holds_every_packet_on_the_topics_of_serve() {
    let (bytes, counts) = exported(Format::Mcap, Kind::Estimates);
    let mut kinds = std::collections::BTreeMap::new();
    for message in ::mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let channel = &message.channel;
        let schema = channel.schema.as_ref().unwrap();
        assert_eq!(
            (schema.encoding.as_str(), channel.message_encoding.as_str()),
            ("jsonschema", "json")
        );
        let metadata = &channel.metadata;
        assert_eq!(
            [
                &metadata["board"],
                &metadata["finger"],
                &metadata["version"]
            ],
            ["ridgetone", "finger", env!("CARGO_PKG_VERSION")]
        );
        let settings = crate::settings_form::json(&Settings::DEFAULT).unwrap();
        assert_eq!(metadata["settings"], settings);
        let schema: serde_json::Value = serde_json::from_slice(&schema.data).unwrap();
        let value: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
        let topic = Topic::of(value["type"].as_str().unwrap());
        assert_eq!(schema, schema::json(topic));
        assert_eq!(channel.topic, format!("/ridgetone/finger/{topic}"));
        if let Some(t_s) = value["t_s"].as_f64() {
            assert_eq!(message.log_time, (t_s * 1e6).round() as u64 * 1000);
        }
        let count = kinds.entry(channel.topic.clone()).or_insert(0u64);
        assert_eq!(value["index"], *count, "{value}");
        *count += 1;
    }
    assert_eq!(kinds.values().sum::<u64>(), counts.received);
    // Other readers find messages through the summary.
    let summary = ::mcap::Summary::read(&bytes).unwrap().unwrap();
    let statistics = summary.stats.as_ref().unwrap();
    assert_eq!(statistics.message_count, counts.received);
    assert_eq!(summary.channels.len(), Topic::ALL.len());
    assert!(!summary.chunk_indexes.is_empty());
    let count = |topic: &str| kinds[&format!("/ridgetone/finger/{topic}")];
    assert_eq!((count("frames"), count("texture")), (100, 1));
    assert!(count("contact") > 4);
}
