//! A feed to updates of the display, printed line by line.

use super::player::{Player, SILENCE_S};
use anyhow::Result;
use ridgetone_host::feed::{Feed, Requester};
use ridgetone_host::listen::{Heard, Listener};
use ridgetone_host::output;
use ridgetone_host::stop;
use std::time::{Duration, Instant};

/// Time between two looks at silence.
const LOOK: Duration = Duration::from_millis(50);

/// Follows a feed to its end, or until this process is to stop, and prints each update: as JSON or
/// for people. Gives the feed back, for its counts.
pub fn run(feed: Feed, player: &mut Player, is_json: bool) -> (Feed, Result<()>) {
    let mut requester = Requester::default();
    requester.want_raw_if(feed.has_board());
    let mut listener = Listener::new(feed, requester);
    let done = follow(&mut listener, player, is_json);
    (listener.feed, done)
}

fn follow(listener: &mut Listener, player: &mut Player, is_json: bool) -> Result<()> {
    let mut heard_at = Instant::now();
    while !stop::is_requested() {
        let heard = match listener.next(LOOK) {
            Err(_) if stop::is_requested() => break,
            heard => heard?,
        };
        let update = match heard {
            Some(Heard::Packet(packet, _)) => {
                heard_at = Instant::now();
                player.take(&packet)?
            }
            Some(Heard::Over) => break,
            _ if heard_at.elapsed().as_secs_f64() > SILENCE_S => {
                player.silent(LOOK.as_secs_f64())?
            }
            _ => None,
        };
        if let Some(update) = update {
            output::line(&if is_json {
                serde_json::to_string(&update)?
            } else {
                update.text(player.setup().gain)
            })?;
        }
    }
    Ok(())
}
