//! `serve`: the messages of many boards to the buses of a robot.
//!
//! Each finger has a thread that reads its board and each sink a thread that delivers; between them
//! is one bounded [`queue`] a sink. So a sink that is slow or dead holds up no board and no other
//! sink.
//!
//! | step | where |
//! |---|---|
//! | what the command line names: `left=/dev/ttyUSB0` | [`name`] |
//! | a board, the emulated board, a recording or a page's address is opened | `open`, `url` |
//! | its messages are read, again after a failure | `finger` |
//! | a message gets its topic and its number there | [`message`], [`topic`] |
//! | it waits, or is lost and counted | [`queue`] |
//! | it is delivered | `lines`, `foxglove`, `mqtt`, `zenoh`, `ros2` |

mod finger;
#[cfg(feature = "foxglove")]
mod foxglove;
#[cfg(any(feature = "foxglove", feature = "mqtt"))]
mod latest;
mod lines;
pub mod message;
#[cfg(feature = "mqtt")]
mod mqtt;
pub mod name;
pub mod open;
mod publisher;
pub mod queue;
#[cfg(feature = "ros2")]
mod ros2;
pub mod schema;
mod sink;
pub mod topic;
mod url;
#[cfg(feature = "zenoh")]
mod zenoh;

pub use open::Emulator;
pub use sink::Sink;

use crate::note;
use crate::stop;
use crate::usage::UsageError;
use anyhow::{Result, bail};
use finger::Finger;
use name::Source;
use publisher::Publisher;
use queue::Queue;
use std::sync::Arc;
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant};
use topic::Names;

/// Time between two looks at what has ended.
const LOOK: Duration = Duration::from_millis(50);

/// Time that sinks have at the end for what waits.
const FINISH: Duration = Duration::from_secs(3);

/// Lines of JSON on standard output.
pub fn lines() -> Box<dyn Sink> {
    Box::new(lines::Lines)
}

/// Foxglove's WebSocket at an address of this computer.
#[cfg(feature = "foxglove")]
pub fn foxglove(address: std::net::SocketAddr) -> Result<Box<dyn Sink>> {
    Ok(Box::new(foxglove::Foxglove { address }))
}

#[cfg(not(feature = "foxglove"))]
pub fn foxglove(_: std::net::SocketAddr) -> Result<Box<dyn Sink>> {
    Err(not_built("Foxglove", "foxglove"))
}

/// A broker of MQTT 5 at `mqtt://[USER:PASSWORD@]HOST[:PORT]`.
#[cfg(feature = "mqtt")]
pub fn mqtt(url: &str) -> Result<Box<dyn Sink>> {
    Ok(Box::new(mqtt::Mqtt::new(url)?))
}

#[cfg(not(feature = "mqtt"))]
pub fn mqtt(_: &str) -> Result<Box<dyn Sink>> {
    Err(not_built("MQTT", "mqtt"))
}

/// Peers of Zenoh that multicast finds, and one at an address such as `tcp/robot.local:7447`.
#[cfg(feature = "zenoh")]
pub fn zenoh(address: Option<&str>) -> Result<Box<dyn Sink>> {
    Ok(Box::new(zenoh::Zenoh::new(address)?))
}

#[cfg(not(feature = "zenoh"))]
pub fn zenoh(_: Option<&str>) -> Result<Box<dyn Sink>> {
    Err(not_built("Zenoh", "zenoh"))
}

/// A node of ROS 2 in the domain of `ROS_DOMAIN_ID`.
#[cfg(feature = "ros2")]
pub fn ros2() -> Result<Box<dyn Sink>> {
    Ok(Box::new(ros2::Ros2))
}

#[cfg(not(feature = "ros2"))]
pub fn ros2() -> Result<Box<dyn Sink>> {
    Err(not_built("ROS 2", "ros2"))
}

#[cfg(not(all(
    feature = "foxglove",
    feature = "mqtt",
    feature = "ros2",
    feature = "zenoh"
)))]
fn not_built(what: &str, feature: &str) -> anyhow::Error {
    let why = format!(
        "this command is built without {what}: `cargo install --path host --features {feature}` adds it"
    );
    UsageError(why).into()
}

/// What is served.
pub struct Serve {
    pub names: Names,
    /// In the order of the names.
    pub sources: Vec<Source>,
    pub emulator: Option<Emulator>,
    /// Whether every frame is requested.
    pub frames: bool,
}

/// Serves until all sources are over, all sinks have failed, or this process is to stop; reports
/// the counts on standard error. Fails if no finger or no sink has ever worked.
pub fn run(serve: Serve, sinks: Vec<Box<dyn Sink>>) -> Result<()> {
    let Serve {
        names,
        sources,
        emulator,
        frames,
    } = serve;
    if sinks.is_empty() {
        return Err(UsageError(
            "nothing to serve to: choose --foxglove, --mqtt, --zenoh, --ros2 or --json".into(),
        )
        .into());
    }
    let (names, emulator) = (Arc::new(names), emulator.map(Arc::new));
    let mut delivering = Vec::new();
    for sink in sinks {
        let queue = Arc::new(Queue::new(sink.name(), names.fingers.len()));
        let (its, names) = (Arc::clone(&queue), Arc::clone(&names));
        let thread = std::thread::spawn(move || {
            sink.run(&its, &names).inspect_err(|error| {
                its.fail();
                note!("{}: {error:#}", its.sink);
            })
        });
        delivering.push((queue, thread));
    }
    let queues: Vec<Arc<Queue>> = delivering
        .iter()
        .map(|(queue, _)| Arc::clone(queue))
        .collect();
    let mut reading = Vec::new();
    for (number, source) in sources.into_iter().enumerate() {
        let publisher = Publisher::new(number, queues.clone());
        let finger = Finger::new(
            names.fingers[number].clone(),
            source,
            frames,
            emulator.clone(),
        );
        reading.push(std::thread::spawn(move || finger.run(publisher)));
    }
    let all_ended = |threads: &[JoinHandle<bool>]| threads.iter().all(JoinHandle::is_finished);
    while !stop::is_requested()
        && !all_ended(&reading)
        && !queues.iter().all(|queue| queue.has_failed())
    {
        sleep(LOOK);
    }
    let all_failed = queues.iter().all(|queue| queue.has_failed());
    // Fingers look at this too.
    stop::request();
    let worked = reading
        .into_iter()
        .filter_map(|thread| thread.join().ok())
        .fold(false, |any, one| any | one);
    queues.iter().for_each(|queue| queue.close());
    let begun = Instant::now();
    while begun.elapsed() < FINISH && !delivering.iter().all(|(_, thread)| thread.is_finished()) {
        sleep(LOOK);
    }
    for (queue, _) in &delivering {
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
