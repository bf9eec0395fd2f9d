//! `view`: what a board does, live on one page in a browser. The page shows [`crate::live`], as the terminal does; here is
//! what brings it there.
//!
//! | what | where |
//! |---|---|
//! | what the page is told, and when | [`hub`] |
//! | where it is fetched from: this computer only | [`server`] |
//! | why there is nothing to see, in words | [`words`] |
//!
//! The page itself is in `host/assets`, inside the binary with the plotting library ([uPlot](https://github.com/leeoniya/uPlot),
//! MIT). Nothing is fetched from anywhere else.

pub mod hub;
pub mod server;
pub mod words;

use crate::feed::{Feed, Following};
use crate::{output, stop};
use anyhow::Result;
use hub::{BEAT, Hub};
use ridgetone_proto::settings::Settings;
use server::Server;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The longest that nobody looks whether to stop.
const LOOK: Duration = Duration::from_millis(20);

/// Serves the page at a [`server::loopback`] address, of which it prints the URL, until this process is asked to end. With
/// `settings` these are put into force on the board first, but not stored. Gives the feed back, with what it has counted.
///
/// # Errors
/// The port is in use; those of the feed.
pub fn run(feed: Feed, settings: Option<Settings>, address: SocketAddr) -> (Feed, Result<()>) {
    let mut following = Following::new(feed, settings);
    let served = serve(&mut following, address);
    (following.leave(), served)
}

fn serve(following: &mut Following, address: SocketAddr) -> Result<()> {
    let hub = Arc::new(Hub::new(following.live()));
    let server = Server::start(address, Arc::clone(&hub))?;
    output::line(&format!("http://{}/", server.address()))?;
    let mut told = Instant::now();
    while !stop::is_asked() {
        let happening = following.next(LOOK)?;
        hub.take(happening.as_ref(), following);
        if told.elapsed() >= BEAT {
            told = Instant::now();
            hub.publish()?;
        }
    }
    Ok(())
}
