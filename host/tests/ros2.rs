//! `serve` as a node of ROS 2, beside another node of the same crate, and beside Cyclone DDS: there
//! is no ROS here.
#![cfg(target_os = "linux")]

mod common;
#[path = "streams/peer.rs"]
mod peer;
#[path = "common/serial_board.rs"]
mod serial_board;
#[path = "streams/serving.rs"]
mod serving;

use peer::Peer;
use ros2_client::qos::WhenFull;
use ros2_client::{
    Context, ContextOptions, MessageTypeName, Name, NodeName, NodeOptions, QosProfile,
};
use serde::Deserialize;
use serde_json::Value;
use serial_board::SerialBoard;
use serving::Serving;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A domain that no robot nearby has.
const DOMAIN: u16 = 87;

/// `sensor_msgs/PointCloud2`, as far as it is looked at, in the order of its definition.
#[derive(Debug, Deserialize)]
#[allow(dead_code, reason = "fields have to be read in their order")]
struct Cloud {
    sec: i32,
    nanosec: u32,
    frame_id: String,
    height: u32,
    width: u32,
    fields: Vec<(String, u32, u8, u32)>,
    is_bigendian: bool,
    point_step: u32,
    row_step: u32,
    data: Vec<u8>,
    is_dense: bool,
}

#[test]
fn a_node_gets_frames_as_clouds_and_the_rest_as_json() {
    let context =
        Context::with_options(ContextOptions::new().domain_id(DOMAIN)).expect("a context");
    let name = NodeName::new("/", "reader").expect("a name");
    let mut node = context.new_node(name, NodeOptions::new()).expect("a node");
    let reliable = QosProfile::publisher_default().reliability_reliable(WhenFull::DEFAULT);
    let topic = |base: &str, package: &str, kind: &str, quality: &QosProfile| {
        let name = Name::new("/ridgetone/f0", base).expect("a name");
        node.create_topic(&name, MessageTypeName::new(package, kind), quality)
            .expect("a topic")
    };
    let frames = topic(
        "frames",
        "sensor_msgs",
        "PointCloud2",
        &QosProfile::subscription_default(),
    );
    let health = topic("health", "std_msgs", "String", &reliable);
    let clouds = node
        .create_subscription::<Cloud>(&frames, None)
        .expect("a subscription");
    let texts = node
        .create_subscription::<String>(&health, None)
        .expect("a subscription");
    let board = SerialBoard::new();
    let serving = Serving::start_with(
        &[&board],
        &["--ros2"],
        &[("ROS_DOMAIN_ID", &DOMAIN.to_string())],
    );
    let (mut found, mut said) = (Vec::new(), Vec::new());
    let begun = Instant::now();
    while found.len() < 500 || said.is_empty() {
        assert!(
            begun.elapsed() < Duration::from_secs(60),
            "{} clouds, {} texts",
            found.len(),
            said.len()
        );
        while let Ok(Some((cloud, _))) = clouds.take() {
            found.push(cloud);
        }
        while let Ok(Some((text, _))) = texts.take() {
            said.push(text);
        }
        sleep(Duration::from_millis(2));
    }
    let cloud = found.last().expect("a cloud");
    assert_eq!(
        (
            cloud.frame_id.as_str(),
            cloud.height,
            cloud.width,
            cloud.is_dense
        ),
        ("ridgetone/f0", 1, 16, true)
    );
    let names: Vec<(&str, u32)> = cloud
        .fields
        .iter()
        .map(|(name, offset, ..)| (name.as_str(), *offset))
        .collect();
    assert_eq!(names, [("x", 0), ("y", 4), ("z", 8), ("volts", 12)]);
    let numbers: Vec<f32> = cloud
        .data
        .chunks(4)
        .map(|bytes| f32::from_le_bytes(bytes.try_into().expect("four")))
        .collect();
    // Taxel 4 is in the second unit; its code is near 2,000,000, at 4.096 V for 7,864,320.
    assert!(
        (numbers[16] - 1.15e-3).abs() < 1e-9 && (1.0..1.2).contains(&numbers[19]),
        "{numbers:?}"
    );
    let utc_s = f64::from(cloud.sec) + 1e-9 * f64::from(cloud.nanosec);
    assert!(
        (utc_s - board.begun_utc_s() - begun.elapsed().as_secs_f64()).abs() < 60.0,
        "{utc_s}"
    );
    let text: Value = serde_json::from_str(&said[0]).expect("JSON");
    assert_eq!(text["type"], "health");
    let words = serving.interrupt();
    assert!(
        words.contains("ros2: open in domain 87") && words.contains("0 frames and 0 events lost"),
        "{words}"
    );
}

/// A subscriber that knows ROS 2 by its design pages alone gets the same messages.
#[test]
#[ignore = "needs Cyclone DDS: cargo xtask streams"]
fn a_subscriber_of_another_dds_gets_frames_and_texts() {
    const FRAMES: usize = 1000;
    let domain = (DOMAIN + 1).to_string();
    let peer = Peer::start("cyclone.py", &[&domain, "120"]);
    let board = SerialBoard::new();
    let serving = Serving::start_with(&[&board], &["--ros2"], &[("ROS_DOMAIN_ID", &domain)]);
    let lines = peer.until("cloud", FRAMES);
    let texts: Vec<&Value> = lines.iter().filter_map(|line| line.get("text")).collect();
    assert!(
        texts.len() > 2 && texts.iter().all(|text| text["type"] == "health"),
        "{texts:?}"
    );
    assert!(
        texts
            .windows(2)
            .all(|pair| pair[1]["index"].as_u64()
                == pair[0]["index"].as_u64().map(|index| index + 1))
    );
    let (mut numbers, mut times_s) = (Vec::new(), Vec::new());
    for cloud in lines.iter().filter_map(|line| line.get("cloud")) {
        assert_eq!(cloud["frame_id"], "ridgetone/f0");
        assert_eq!(cloud["size"], serde_json::json!([1, 16, 16, 256]));
        assert_eq!(
            cloud["fields"],
            serde_json::json!([
                ["x", 0, 7, 1],
                ["y", 4, 7, 1],
                ["z", 8, 7, 1],
                ["volts", 12, 7, 1]
            ])
        );
        assert_eq!(cloud["flags"], serde_json::json!([false, true]));
        let values: Vec<f64> = cloud["numbers"]
            .as_array()
            .expect("a list")
            .iter()
            .filter_map(Value::as_f64)
            .collect();
        assert!(
            (values[16] - 1.15e-3).abs() < 1e-9 && values.len() == 64,
            "{values:?}"
        );
        // The board's codes are 2,000,000 and 100 a frame and 1 a taxel, at 4.096 V for 7,864,320.
        let codes: Vec<f64> = values
            .chunks(4)
            .map(|point| point[3] / 4.096 * 7_864_320.0 - 2e6)
            .collect();
        let number = (codes[0] / 100.0).round();
        for (taxel, code) in codes.iter().enumerate() {
            assert!(
                (code - 100.0 * number - taxel as f64).abs() < 0.3,
                "{codes:?}"
            );
        }
        numbers.push(number as u64);
        times_s.push(cloud["utc_s"].as_f64().expect("a time"));
    }
    let steps: Vec<u64> = numbers
        .windows(2)
        .map(|pair| (pair[1] + 1000 - pair[0]) % 1000)
        .collect();
    let lost: u64 = steps.iter().map(|step| step - 1).sum();
    println!(
        "{FRAMES} clouds, {lost} lost on the way, which is best effort; {} texts",
        texts.len()
    );
    assert!(lost < FRAMES as u64 / 20, "{steps:?}");
    let late_s: Vec<f64> = times_s
        .windows(2)
        .zip(&steps)
        .map(|(pair, step)| pair[1] - pair[0] - *step as f64 / 241.0)
        .collect();
    assert!(
        late_s.iter().all(|late_s| late_s.abs() < 0.01),
        "{late_s:?}"
    );
    let words = serving.interrupt();
    assert!(words.contains("0 frames and 0 events lost"), "{words}");
}
