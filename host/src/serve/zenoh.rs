//! Zenoh: a key expression a topic, without a slash in front; JSON.
//!
//! A receiver that is slow holds the session up, and not the boards: what is lost then is lost in
//! the queue, by count.

use super::queue::Queue;
use super::sink::Sink;
use super::topic::{Names, Topic};
use crate::note;
use crate::usage::UsageError;
use anyhow::{Result, anyhow};
use std::collections::BTreeMap;
use zenoh::Config;
use zenoh::bytes::Encoding;
use zenoh::qos::{CongestionControl, Priority};

pub struct Zenoh {
    config: Config,
}

impl Zenoh {
    /// A peer that finds others by multicast, or connects to this address too, such as
    /// `tcp/robot.local:7447`.
    pub fn new(address: Option<&str>) -> Result<Self> {
        let mut config = Config::default();
        if let Some(address) = address {
            let wrong = |why: &dyn std::fmt::Display| {
                UsageError(format!("--zenoh {address}: {why}; write tcp/HOST:PORT"))
            };
            if !address.contains('/') || !address.contains(':') {
                return Err(wrong(&"no address").into());
            }
            let list = serde_json::to_string(&[address])?;
            config
                .insert_json5("connect/endpoints", &list)
                .map_err(|error| wrong(&error))?;
        }
        Ok(Self { config })
    }
}

impl Sink for Zenoh {
    fn name(&self) -> &'static str {
        "zenoh"
    }

    fn run(self: Box<Self>, queue: &Queue, names: &Names) -> Result<()> {
        // The session has threads of its own.
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()?;
        runtime
            .block_on(publish(self.config, queue, names))
            .map_err(|error| anyhow!(error))
    }
}

async fn publish(config: Config, queue: &Queue, names: &Names) -> zenoh::Result<()> {
    let session = zenoh::open(config).await?;
    note!("zenoh: open as {}", session.zid());
    let mut publishers = BTreeMap::new();
    for finger in 0..names.fingers.len() {
        for topic in Topic::ALL {
            // The queue counts what is lost; the session would not.
            let publisher = session
                .declare_publisher(names.path(finger, topic))
                .encoding(Encoding::APPLICATION_JSON)
                .congestion_control(CongestionControl::Block)
                .priority(if topic == Topic::Frames {
                    Priority::Data
                } else {
                    Priority::DataHigh
                })
                .await?;
            publishers.insert((finger, topic), publisher);
        }
    }
    while let Some(queued) = queue.next().await {
        let message = &queued.message;
        publishers[&(message.finger, message.topic)]
            .put(message.json.as_str())
            .await?;
    }
    drop(publishers);
    session.close().await
}
