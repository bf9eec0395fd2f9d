//! Lines of JSON on standard output: `{"topic":"/ridgetone/left/tone","message":{...}}`.

use super::queue::Queue;
use super::sink::Sink;
use super::topic::Names;
use crate::output;
use anyhow::Result;

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
