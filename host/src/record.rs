//! Records the telemetry of a feed to a file.

use crate::digits::time_s;
use crate::feed::{Feed, Requester};
use crate::listen;
use crate::output::Progress;
use crate::recording::create;
use anyhow::Result;
use ridgetone_proto::telemetry::Packet;
use std::ops::ControlFlow;
use std::path::Path;

/// Writes all bytes of a feed to a new file until the source ends, `length_s` of device time
/// have passed, or the process is interrupted. The file is valid at any moment. Returns the feed,
/// so that its counts can be read.
pub fn record(
    feed: Feed,
    path: &Path,
    requester: Requester,
    length_s: Option<f64>,
) -> Result<(Feed, Result<()>)> {
    let file = create(path, &feed.name(), feed.byte_s())?;
    let feed = feed.recorded(Box::new(file));
    let mut progress = Progress::default();
    let (mut begun_s, mut packets) = (None, 0u64);
    let mut sink = |packet: &Packet, _| {
        packets += 1;
        if let Some(t_s) = time_s(&packet.event) {
            let done_s = t_s - *begun_s.get_or_insert(t_s);
            progress.show(format_args!("{done_s:.1} s recorded, {packets} packets"));
            if length_s.is_some_and(|length_s| done_s >= length_s) {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    };
    let (feed, ended) = listen::run(feed, requester, &mut sink);
    progress.end();
    Ok((feed, ended))
}
