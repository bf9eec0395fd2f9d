//! `serve` as a node of ROS 2, beside another node of the same crate: there is no ROS here.
#![cfg(target_os = "linux")]

mod common;
#[path = "common/serial_board.rs"]
mod serial_board;
#[path = "streams/serving.rs"]
mod serving;

use ros2_client::qos::WhenFull;
use ros2_client::{Context, ContextOptions, MessageTypeName, Name, NodeName, NodeOptions, QosProfile};
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
    let context = Context::with_options(ContextOptions::new().domain_id(DOMAIN)).expect("a context");
    let name = NodeName::new("/", "reader").expect("a name");
    let mut node = context.new_node(name, NodeOptions::new()).expect("a node");
    let reliable = QosProfile::publisher_default().reliability_reliable(WhenFull::DEFAULT);
    let topic = |base: &str, package: &str, kind: &str, quality: &QosProfile| {
        let name = Name::new("/ridgetone/f0", base).expect("a name");
        node.create_topic(&name, MessageTypeName::new(package, kind), quality).expect("a topic")
    };
    let frames = topic("frames", "sensor_msgs", "PointCloud2", &QosProfile::subscription_default());
    let health = topic("health", "std_msgs", "String", &reliable);
    let clouds = node.create_subscription::<Cloud>(&frames, None).expect("a subscription");
    let texts = node.create_subscription::<String>(&health, None).expect("a subscription");
    let board = SerialBoard::new();
    let serving = Serving::start_with(&[&board], &["--ros2"], &[("ROS_DOMAIN_ID", &DOMAIN.to_string())]);
    let (mut found, mut said) = (Vec::new(), Vec::new());
    let begun = Instant::now();
    while found.len() < 500 || said.is_empty() {
        assert!(begun.elapsed() < Duration::from_secs(60), "{} clouds, {} texts", found.len(), said.len());
        while let Ok(Some((cloud, _))) = clouds.take() {
            found.push(cloud);
        }
        while let Ok(Some((text, _))) = texts.take() {
            said.push(text);
        }
        sleep(Duration::from_millis(2));
    }
    let cloud = found.last().expect("a cloud");
    assert_eq!((cloud.frame_id.as_str(), cloud.height, cloud.width, cloud.is_dense), ("ridgetone/f0", 1, 16, true));
    let names: Vec<(&str, u32)> = cloud.fields.iter().map(|(name, offset, ..)| (name.as_str(), *offset)).collect();
    assert_eq!(names, [("x", 0), ("y", 4), ("z", 8), ("volts", 12)]);
    let numbers: Vec<f32> =
        cloud.data.chunks(4).map(|bytes| f32::from_le_bytes(bytes.try_into().expect("four"))).collect();
    // Taxel 4 is in the second unit; its code is near 2,000,000, at 4.096 V for 7,864,320.
    assert!((numbers[16] - 1.15e-3).abs() < 1e-9 && (1.0..1.2).contains(&numbers[19]), "{numbers:?}");
    let utc_s = f64::from(cloud.sec) + 1e-9 * f64::from(cloud.nanosec);
    assert!((utc_s - board.begun_utc_s() - begun.elapsed().as_secs_f64()).abs() < 60.0, "{utc_s}");
    let text: Value = serde_json::from_str(&said[0]).expect("JSON");
    assert_eq!(text["type"], "health");
    let words = serving.interrupt();
    assert!(words.contains("ros2: open in domain 87") && words.contains("0 frames and 0 events lost"), "{words}");
}
