//! Foxglove's WebSocket: one channel per topic, JSON with a schema.
//!
//! The crate has its own queue for each viewer. A slow viewer loses the oldest messages, and the
//! crate does not report how many; the `index` of the messages shows it.

use super::message::Latest;
use super::queue::{Queue, Sink};
use super::schema;
use super::topic::{Names, Topic};
use crate::note;
use anyhow::{Context, Result};
use foxglove::websocket::{ChannelView, Client, ServerListener};
use foxglove::{PartialMetadata, RawChannel, Schema};
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};

/// Maximum number of messages that wait for each viewer: 1.7 s of ten fingers.
const BACKLOG: usize = 4096;

pub struct Foxglove {
    pub address: SocketAddr,
}

/// Channels of each finger, with the latest states, which are sent first to a new viewer.
#[derive(Default)]
struct Channels {
    by_finger: Vec<Vec<Arc<RawChannel>>>,
    latest: Latest,
}

/// Channels that the server's listener shares.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Channels>>);

impl Shared {
    fn with<T>(&self, step: impl FnOnce(&mut Channels) -> T) -> T {
        step(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl ServerListener for Shared {
    fn on_subscribe(&self, client: Client, view: ChannelView) {
        self.with(|channels| {
            for message in channels.latest.all() {
                let channel = &channels.by_finger[message.finger][message.topic as usize];
                if channel.id() == view.id() {
                    let time = PartialMetadata::with_log_time(message.time_ns);
                    channel.log_with_meta_to_sink(message.json.as_bytes(), time, client.sink_id());
                }
            }
        });
    }
}

impl Sink for Foxglove {
    fn name(&self) -> &'static str {
        "foxglove"
    }

    fn run(self: Box<Self>, queue: &Queue, names: &Names) -> Result<()> {
        // This runtime also runs the server's tasks.
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()?;
        runtime.block_on(self.serve(queue, names))
    }
}

impl Foxglove {
    async fn serve(&self, queue: &Queue, names: &Names) -> Result<()> {
        let (context, shared) = (foxglove::Context::new(), Shared::default());
        let server = context
            .websocket_server()
            .name("ridgetone")
            .bind(self.address.ip().to_string(), self.address.port())
            .message_backlog_size(BACKLOG)
            .listener(Arc::new(shared.clone()))
            .tokio_runtime(&tokio::runtime::Handle::current())
            .start()
            .await
            .with_context(|| self.address.to_string())?;
        let (ip, port) = (self.address.ip(), server.port());
        note!(
            "foxglove: ws://{}; or open {}",
            SocketAddr::new(ip, port),
            server.app_url()
        );
        let channel = |finger, topic: Topic| -> Result<Arc<RawChannel>> {
            let schema = schema::json(topic).to_string().into_bytes();
            Ok(context
                .channel_builder(format!("/{}", names.path(finger, topic)))
                .message_encoding("json")
                .metadata(names.metadata(finger))
                .schema(Schema::new(
                    format!("ridgetone.{topic}"),
                    "jsonschema",
                    schema,
                ))
                .build_raw()?)
        };
        let channels = (0..names.fingers.len())
            .map(|finger| {
                Topic::ALL
                    .iter()
                    .map(|topic| channel(finger, *topic))
                    .collect()
            })
            .collect::<Result<Vec<Vec<_>>>>()?;
        shared.with(|all| all.by_finger = channels);
        while let Some(queued) = queue.next().await {
            let message = &queued.message;
            let time = PartialMetadata::with_log_time(message.time_ns);
            shared.with(|channels| {
                channels.latest.take(message);
                channels.by_finger[message.finger][message.topic as usize]
                    .log_with_meta(message.json.as_bytes(), time);
            });
            // Let the server's tasks run.
            tokio::task::yield_now().await;
        }
        server.stop().wait().await;
        Ok(())
    }
}
