//! ROS 2 by DDS, without an installation of ROS: frames as `sensor_msgs/PointCloud2`, all other
//! messages as JSON in `std_msgs/String`.
//!
//! A subscriber that is slow holds the node up, and not the boards: what is lost then is lost in
//! the queue, by count.

use super::message::{Message, positions_mm};
use super::queue::Queue;
use super::sink::Sink;
use super::topic::{Names, Topic};
use crate::note;
use anyhow::{Context as _, Result, anyhow};
use ros2_client::qos::{History, WhenFull};
use ros2_client::{
    Context, ContextOptions, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher,
    QosProfile, WriteError,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Messages that a subscriber may be behind: four seconds of frames, a minute and more of all
/// others.
const DEPTH: usize = 1000;

/// The variable that chooses a domain.
const DOMAIN: &str = "ROS_DOMAIN_ID";

/// `sensor_msgs/PointField`, FLOAT32.
const FLOAT32: u8 = 7;

/// Fields of a point: three coordinates in metres, and volts; NaN where they are not valid.
const FIELDS: [&str; 4] = ["x", "y", "z", "volts"];

/// Bytes of a point.
const POINT: u32 = 4 * FIELDS.len() as u32;

/// `builtin_interfaces/Time`.
#[derive(Clone, Serialize)]
struct Time {
    sec: i32,
    nanosec: u32,
}

/// `std_msgs/Header`.
#[derive(Clone, Serialize)]
struct Header {
    stamp: Time,
    frame_id: String,
}

/// `sensor_msgs/PointField`.
#[derive(Clone, Serialize)]
struct PointField {
    name: String,
    offset: u32,
    datatype: u8,
    count: u32,
}

/// `sensor_msgs/PointCloud2`.
#[derive(Clone, Serialize)]
struct PointCloud2 {
    header: Header,
    height: u32,
    width: u32,
    fields: Vec<PointField>,
    is_bigendian: bool,
    point_step: u32,
    row_step: u32,
    data: Vec<u8>,
    is_dense: bool,
}

/// What a cloud needs of a frame's message.
#[derive(Deserialize)]
struct Volts {
    volts: Vec<Option<f32>>,
}

pub struct Ros2;

impl Sink for Ros2 {
    fn name(&self) -> &'static str {
        "ros2"
    }

    fn run(self: Box<Self>, queue: &Queue, names: &Names) -> Result<()> {
        let domain = std::env::var(DOMAIN).unwrap_or_else(|_| "0".into());
        let domain = domain
            .parse()
            .map_err(|_| anyhow!("{DOMAIN}={domain}: no number of a domain"))?;
        let context = Context::with_options(ContextOptions::new().domain_id(domain))
            .map_err(|error| anyhow!("{error:?}"))?;
        let node = NodeName::new("/", "ridgetone").map_err(|error| anyhow!("{error:?}"))?;
        let mut node = context
            .new_node(node, NodeOptions::new())
            .map_err(|error| anyhow!("{error:?}"))?;
        let mut publishers = BTreeMap::new();
        for finger in 0..names.fingers.len() {
            for topic in Topic::ALL {
                publishers.insert(
                    (finger, topic),
                    Channel::new(&mut node, names, finger, topic)?,
                );
            }
        }
        note!("ros2: open in domain {domain}");
        let runtime = tokio::runtime::Builder::new_current_thread().build()?;
        while let Some(queued) = runtime.block_on(queue.next()) {
            let message = &queued.message;
            publishers[&(message.finger, message.topic)].publish(message, names)?;
        }
        Ok(())
    }
}

enum Channel {
    Cloud(Publisher<PointCloud2>),
    Json(Publisher<String>),
}

impl Channel {
    fn new(node: &mut Node, names: &Names, finger: usize, topic: Topic) -> Result<Self> {
        let path = names.path(finger, topic);
        let wrong = |error: &dyn std::fmt::Debug| anyhow!("/{path}: {error:?}");
        let (namespace, base) = path.rsplit_once('/').context("a path")?;
        let name = Name::new(&format!("/{namespace}"), base).map_err(|error| wrong(&error))?;
        let quality = QosProfile::publisher_default().history(History::KeepLast { depth: DEPTH });
        let (package, kind, quality) = match topic {
            Topic::Frames => (
                "sensor_msgs",
                "PointCloud2",
                quality.reliability_best_effort(),
            ),
            _ => (
                "std_msgs",
                "String",
                quality.reliability_reliable(WhenFull::DEFAULT),
            ),
        };
        let place = node
            .create_topic(&name, MessageTypeName::new(package, kind), &quality)
            .map_err(|error| wrong(&error))?;
        Ok(match topic {
            Topic::Frames => Self::Cloud(
                node.create_publisher(&place, None)
                    .map_err(|error| wrong(&error))?,
            ),
            _ => Self::Json(
                node.create_publisher(&place, None)
                    .map_err(|error| wrong(&error))?,
            ),
        })
    }

    fn publish(&self, message: &Message, names: &Names) -> Result<()> {
        match self {
            Self::Cloud(publisher) => give(publisher, cloud(message, names)?),
            Self::Json(publisher) => give(publisher, message.json.clone()),
        }
    }
}

/// Publishes, and waits for a subscriber that is slow.
fn give<M: Serialize>(publisher: &Publisher<M>, message: M) -> Result<()> {
    let mut message = message;
    loop {
        match publisher.publish(message) {
            Ok(()) => return Ok(()),
            Err(WriteError::WouldBlock { data }) => message = data,
            Err(_) => return Err(anyhow!("the node does not take a message")),
        }
    }
}

/// A frame as a cloud of its taxels.
fn cloud(message: &Message, names: &Names) -> Result<PointCloud2> {
    let Volts { volts } = serde_json::from_str(&message.json).context("a frame")?;
    let points = positions_mm().into_iter().zip(&volts);
    let data: Vec<u8> = points
        .flat_map(|([x_mm, y_mm], volts)| {
            [
                x_mm as f32 * 1e-3,
                y_mm as f32 * 1e-3,
                0.0,
                volts.unwrap_or(f32::NAN),
            ]
        })
        .flat_map(f32::to_le_bytes)
        .collect();
    let field = |(at, name): (usize, &&str)| PointField {
        name: (*name).to_owned(),
        offset: 4 * at as u32,
        datatype: FLOAT32,
        count: 1,
    };
    let stamp = Time {
        sec: (message.time_ns / 1_000_000_000) as i32,
        nanosec: (message.time_ns % 1_000_000_000) as u32,
    };
    Ok(PointCloud2 {
        header: Header {
            stamp,
            frame_id: format!("{}/{}", names.board, names.fingers[message.finger]),
        },
        height: 1,
        width: data.len() as u32 / POINT,
        fields: FIELDS.iter().enumerate().map(field).collect(),
        is_bigendian: false,
        point_step: POINT,
        row_step: data.len() as u32,
        is_dense: volts.iter().all(Option::is_some),
        data,
    })
}
