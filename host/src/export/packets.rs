//! The packets of a recording, one by one.

use crate::feed::{Feed, FeedEvent};
use crate::live::Counts;
use crate::output::Progress;
use crate::recording::Recorded;
use crate::stop;
use crate::utc::Receipt;
use anyhow::{Result, bail};
use ridgetone_proto::telemetry::Packet;
use std::path::Path;
use std::time::Duration;

/// Passes every packet of a recording to `sink`, and shows the progress.
pub fn packets(
    path: &Path,
    sink: &mut dyn FnMut(&Packet, Option<Receipt>) -> Result<()>,
) -> Result<Counts> {
    let recorded = Recorded::open(path)?;
    let bytes = recorded.bytes;
    let mut feed = Feed::new(recorded);
    let mut progress = Progress::default();
    loop {
        match feed.next(Duration::ZERO)? {
            Some(FeedEvent::Data(packet)) => sink(&packet, feed.receipt())?,
            Some(FeedEvent::Over) => break,
            _ => {}
        }
        progress.show_count("bytes", feed.bytes(), bytes);
        if stop::is_requested() {
            progress.end();
            bail!("{}: interrupted, nothing is written", feed.name());
        }
    }
    progress.end();
    Ok(feed.counts())
}
