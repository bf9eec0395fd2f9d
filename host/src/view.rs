//! `view`: a board live on one page in a browser. The page shows [`crate::live`], as the terminal does.
//!
//! | step | file |
//! |---|---|
//! | what the pages get, and when | [`hub`] |
//! | the server | [`server`] |
//! | who may ask it | [`guard`] |
//! | the page's files | [`files`] |
//! | the status line | [`status`] |
//!
//! The page itself is in `host/assets`, inside the binary with the plotting library ([uPlot](https://github.com/leeoniya/uPlot),
//! MIT). It loads nothing from anywhere else.

pub mod files;
pub mod guard;
pub mod hub;
pub mod server;
pub mod status;

use crate::feed::{Feed, Following};
use crate::{output, stop};
use anyhow::Result;
use hub::{Hub, UPDATE_EVERY};
use ridgetone_proto::settings::Settings;
use server::Server;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Longest wait between two looks at [`stop`].
const LOOK: Duration = Duration::from_millis(20);

/// Serves the page at a [`guard::loopback`] address, and prints its URL, until this process is to stop. `settings` are put
/// into force on the board first, but not stored. Gives the feed back, for its counts.
pub fn run(feed: Feed, settings: Option<Settings>, address: SocketAddr) -> (Feed, Result<()>) {
    let mut following = Following::new(feed, settings);
    let served = serve(&mut following, address);
    (following.finish(), served)
}

fn serve(following: &mut Following, address: SocketAddr) -> Result<()> {
    let hub = Arc::new(Hub::new(following.live()));
    let server = Server::start(address, Arc::clone(&hub))?;
    output::line(&format!("http://{}/", server.address))?;
    let mut published = Instant::now();
    while !stop::is_requested() {
        let event = following.next(LOOK)?;
        hub.take(event.as_ref(), following);
        if let Some(settings) = hub.wanted() {
            following.set(settings);
        }
        if published.elapsed() >= UPDATE_EVERY {
            published = Instant::now();
            hub.publish()?;
        }
    }
    Ok(())
}
