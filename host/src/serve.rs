//! `serve`: publishes the messages of many boards to other programs.
//!
//! Each finger has a thread that reads its board, and each sink a thread that delivers messages. A
//! bounded [`queue`] in front of each sink keeps a slow or dead sink from blocking the rest.
//!
//! | step | where |
//! |---|---|
//! | sources named on the command line: `left=/dev/ttyUSB0` | [`source`] |
//! | messages are read; a port is opened again after a failure | `finger` |
//! | a message gets its topic and its index | [`message`], [`topic`], `publisher` |
//! | the message waits, or is lost and counted | [`queue`] |
//! | the message is delivered | `Lines`, `foxglove`, `mqtt` |

mod finger;
#[cfg(feature = "foxglove")]
mod foxglove;
pub mod message;
#[cfg(feature = "mqtt")]
mod mqtt;
mod publisher;
pub mod queue;
pub mod schema;
pub mod source;
pub mod topic;

use crate::emulator::Firmware;
use crate::usage::UsageError;
use crate::{note, output, stop};
use anyhow::{Result, bail};
use finger::Finger;
use publisher::Publisher;
use queue::{Queue, Sink};
use source::Source;
use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant};
use topic::Names;

/// Interval between checks for threads that have ended.
const POLL: Duration = Duration::from_millis(50);

/// Time that sinks have at the end to send waiting messages.
const FINISH: Duration = Duration::from_secs(3);

/// Lines of JSON on standard output: `{"topic":"/ridgetone/left/tone","message":{...}}`.
pub struct Lines;

impl Sink for Lines {
    fn name(&self) -> &'static str {
        "json"
    }

    fn run(self: Box<Self>, queue: &Queue, names: &Names) -> Result<()> {
        let runtime = tokio::runtime::Builder::new_current_thread().build()?;
        while let Some(queued) = runtime.block_on(queue.next()) {
            let message = &queued.message;
            let topic = names.path(message.finger, message.topic);
            output::line(&format!(
                r#"{{"topic":"/{topic}","message":{}}}"#,
                message.json
            ))?;
        }
        Ok(())
    }
}

/// Creates a sink for Foxglove's WebSocket at an address of this computer.
pub fn foxglove(address: SocketAddr) -> Result<Box<dyn Sink>> {
    #[cfg(feature = "foxglove")]
    return Ok(Box::new(foxglove::Foxglove { address }));
    #[cfg(not(feature = "foxglove"))]
    Err(not_built(&format!("Foxglove ({address})"), "foxglove"))
}

/// Creates a sink for an MQTT 5 broker at `mqtt://[USER:PASSWORD@]HOST[:PORT]`.
pub fn mqtt(url: &str) -> Result<Box<dyn Sink>> {
    #[cfg(feature = "mqtt")]
    return Ok(Box::new(mqtt::Mqtt::new(url)?));
    #[cfg(not(feature = "mqtt"))]
    Err(not_built(&format!("MQTT ({url})"), "mqtt"))
}

#[cfg(not(all(feature = "foxglove", feature = "mqtt")))]
fn not_built(what: &str, feature: &str) -> anyhow::Error {
    let why = format!(
        "this command is built without {what}: `cargo install --path host --features {feature}` adds it"
    );
    UsageError(why).into()
}

/// Fingers to serve.
pub struct Serve {
    pub names: Names,
    /// Sources, in the order of the names.
    pub sources: Vec<Source>,
    /// Firmware of the emulated boards.
    pub firmware: Option<Firmware>,
    /// True if every frame is requested.
    pub frames: bool,
}

/// Serves until all sources have ended, all sinks have failed, or the process is asked to stop, and
/// reports the counts on standard error. Fails if no finger or no sink has ever worked.
pub fn run(serve: Serve, sinks: Vec<Box<dyn Sink>>) -> Result<()> {
    if sinks.is_empty() {
        return Err(
            UsageError("nothing to serve to: choose --foxglove, --mqtt or --json".into()).into(),
        );
    }
    let (names, firmware) = (Arc::new(serve.names), serve.firmware);
    let (mut queues, mut delivering) = (Vec::new(), Vec::new());
    for sink in sinks {
        let queue = Arc::new(Queue::new(sink.name(), names.fingers.len()));
        queues.push(Arc::clone(&queue));
        let names = Arc::clone(&names);
        delivering.push(std::thread::spawn(move || {
            sink.run(&queue, &names).inspect_err(|error| {
                queue.fail();
                note!("{}: {error:#}", queue.sink);
            })
        }));
    }
    let mut reading: Vec<JoinHandle<bool>> = Vec::new();
    for (number, source) in serve.sources.into_iter().enumerate() {
        let publisher = Publisher::new(number, queues.clone());
        let finger = Finger::new(
            names.fingers[number].clone(),
            source,
            serve.frames,
            firmware.clone(),
        );
        reading.push(std::thread::spawn(move || finger.run(publisher)));
    }
    let all_failed = || queues.iter().all(|queue| queue.has_failed());
    while !stop::is_requested() && !reading.iter().all(JoinHandle::is_finished) && !all_failed() {
        sleep(POLL);
    }
    let all_failed = all_failed();
    // Also stops the fingers' threads, which check this flag.
    stop::request();
    let received = reading.into_iter().map(|thread| thread.join());
    let worked = received.filter(|any| matches!(any, Ok(true))).count() > 0;
    queues.iter().for_each(|queue| queue.close());
    let begun = Instant::now();
    while begun.elapsed() < FINISH && !delivering.iter().all(JoinHandle::is_finished) {
        sleep(POLL);
    }
    for queue in &queues {
        note!("{}: {}", queue.sink, queue.counts());
    }
    if all_failed {
        bail!("nothing is served: no sink works");
    }
    if !worked {
        bail!("nothing was served: no finger works");
    }
    Ok(())
}
