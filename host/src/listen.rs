//! Packets of a feed one by one, until the source is over or the sink breaks off.

use crate::events;
use crate::feed::{Feed, FeedEvent, Requester};
use crate::stop;
use anyhow::{Result, bail};
use ridgetone_proto::command::Outcome;
use ridgetone_proto::telemetry::Packet;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Longest wait between two looks at [`stop`] and at due requests.
const LOOK: Duration = Duration::from_millis(50);

/// Time after which damage is reported without a loss.
const DAMAGED_ALONE: Duration = Duration::from_secs(1);

/// Gives packets to `sink`, sends the requester's requests, and reports connections and losses on standard error. Ends when
/// the source is over, when the sink breaks off, or when this process is to stop ([`stop`]).
pub fn run(
    feed: &mut Feed,
    requester: &mut Requester,
    sink: &mut dyn FnMut(&Packet) -> Result<ControlFlow<()>>,
) -> Result<()> {
    let (mut reported, mut damaged_since, mut is_connected) = ((0, 0), None, false);
    while !stop::is_requested() {
        let event = match feed.next(LOOK) {
            // Ctrl-C reaches the emulator too, which may end first.
            Err(_) if stop::is_requested() => break,
            event => event?,
        };
        match event {
            Some(FeedEvent::Data(packet)) => {
                is_connected = true;
                if let Some((_, outcome)) = requester.answered(&packet)
                    && !matches!(outcome, Outcome::Done | Outcome::DoneErased)
                {
                    bail!("{}: {}", feed.name(), events::outcome(&outcome));
                }
                if sink(&packet)?.is_break() {
                    break;
                }
            }
            Some(FeedEvent::Connected(name)) => eprintln!("ridgetone: {name}: open"),
            Some(FeedEvent::Disconnected(name, why)) => {
                is_connected = false;
                eprintln!("ridgetone: {name}: {why}; waiting for the board");
            }
            Some(FeedEvent::Over) => break,
            None => {}
        }
        if is_connected && feed.has_board() {
            requester.tick(feed)?;
        }
        let counts = feed.counts();
        if (counts.missing, counts.damaged) == reported {
            continue;
        }
        // A damaged packet mostly shows as a loss with the next packet. At a wrong baud rate there is no next packet.
        let since = *damaged_since.get_or_insert_with(Instant::now);
        if counts.missing > reported.0 || since.elapsed() > DAMAGED_ALONE {
            eprintln!("ridgetone: {} packets lost, {} damaged so far", counts.missing, counts.damaged);
            (reported, damaged_since) = ((counts.missing, counts.damaged), None);
        }
    }
    Ok(())
}
