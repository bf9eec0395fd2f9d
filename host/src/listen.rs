//! Packets as they come, to whoever takes them line by line: until the source is over, or nobody reads any more.

use crate::feed::{Feed, Happening, Source};
use crate::stop;
use anyhow::Result;
use ridgetone::telemetry::Packet;
use std::time::Duration;

/// How often it is looked whether to stop, and whether anything was lost.
const LOOK: Duration = Duration::from_millis(200);

/// Gives packets to `sink` and tells standard error when the board goes and comes, and what was lost. Ends when the source is
/// over, or when this process is asked to ([`stop`]).
///
/// # Errors
/// Those of the feed and of `sink`.
pub fn run<S: Source>(feed: &mut Feed<S>, sink: &mut dyn FnMut(&Packet) -> Result<()>) -> Result<()> {
    let mut told = 0;
    while !stop::is_asked() {
        match feed.next(LOOK)? {
            Some(Happening::Packet(packet)) => sink(&packet)?,
            Some(Happening::Came(name)) => eprintln!("ridgetone: {name}: the board is there"),
            Some(Happening::Went(name, why)) => eprintln!("ridgetone: {name}: {why}; waiting for the board"),
            Some(Happening::Over) => break,
            None => {}
        }
        let counts = feed.counts();
        if counts.missing > told {
            eprintln!("ridgetone: {} packets lost, {} damaged so far", counts.missing, counts.damaged);
            told = counts.missing;
        }
    }
    Ok(())
}
