//! Packets as they come, to whoever takes them one by one: until the source is over, or nobody wants any more.

use crate::events;
use crate::feed::{Asking, Feed, Happening, Source};
use crate::stop;
use anyhow::{Result, bail};
use ridgetone_proto::command::Outcome;
use ridgetone_proto::telemetry::Packet;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// How often it is looked whether to stop, and what is to be sent.
const LOOK: Duration = Duration::from_millis(50);

/// After which time damage is told without a loss.
const DAMAGED_ALONE: Duration = Duration::from_secs(1);

/// Gives packets to `sink` and tells standard error when the board goes and comes, and what was lost; sends what is to be
/// asked. Ends when the source is over, when the sink breaks off, or when this process is asked to ([`stop`]).
///
/// # Errors
/// Those of the feed and of `sink`; the board refuses what it is asked, or does not answer.
pub fn run<S: Source>(
    feed: &mut Feed<S>,
    asking: &mut Asking,
    sink: &mut dyn FnMut(&Packet) -> Result<ControlFlow<()>>,
) -> Result<()> {
    let (mut told, mut untold_since, mut is_there) = ((0, 0), None, false);
    while !stop::is_asked() {
        let happening = match feed.next(LOOK) {
            // Ctrl-C reaches the emulator too, which may be the first to end.
            Err(_) if stop::is_asked() => break,
            happening => happening?,
        };
        match happening {
            Some(Happening::Packet(packet)) => {
                is_there = true;
                if let Some((_, outcome)) = asking.hear(&packet)
                    && !matches!(outcome, Outcome::Done | Outcome::DoneErased)
                {
                    bail!("{}: {}", feed.name(), events::outcome(&outcome));
                }
                if sink(&packet)?.is_break() {
                    break;
                }
            }
            Some(Happening::Came(name)) => eprintln!("ridgetone: {name}: open"),
            Some(Happening::Went(name, why)) => {
                is_there = false;
                eprintln!("ridgetone: {name}: {why}; waiting for the board");
            }
            Some(Happening::Over) => break,
            None => {}
        }
        if is_there && feed.has_board() {
            asking.tick(feed)?;
        }
        let counts = feed.counts();
        if (counts.missing, counts.damaged) == told {
            continue;
        }
        // What is damaged mostly turns out as lost with the next packet. At a wrong baud rate there is none.
        let since = *untold_since.get_or_insert_with(Instant::now);
        if counts.missing > told.0 || since.elapsed() > DAMAGED_ALONE {
            eprintln!("ridgetone: {} packets lost, {} damaged so far", counts.missing, counts.damaged);
            (told, untold_since) = ((counts.missing, counts.damaged), None);
        }
    }
    Ok(())
}
