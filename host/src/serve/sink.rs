//! What a sink is.

use super::queue::Queue;
use super::topic::Names;
use anyhow::Result;

/// Delivers messages.
pub trait Sink: Send {
    /// Name for people and in messages about losses.
    fn name(&self) -> &'static str;

    /// Delivers until the queue is closed and empty. It waits for a receiver that is not there.
    /// Fails if it never can deliver.
    fn run(self: Box<Self>, queue: &Queue, names: &Names) -> Result<()>;
}
