//! Serves the page, with a texture of a file or with those of a finger as it finds them.

use super::output::Output;
use super::page::{Page, Shown};
use crate::feed::{Feed, Requester};
use crate::listen::{Heard, Listener, SILENT};
use crate::stop;
use crate::texture::Found;
use crate::view::announce;
use crate::view::guard::Access;
use crate::view::server::Server;
use anyhow::Result;
use ridgetone_proto::telemetry::Event;
use ridgetone_stimulus::Texture;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

/// Longest wait between two looks at [`stop`].
const LOOK: Duration = Duration::from_millis(20);

/// Where textures come from.
pub enum Textures {
    /// One, of a file of this name.
    Fixed(String, Texture),
    Finger(Box<Feed>),
}

/// Where the page is served, and how it begins.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    pub address: SocketAddr,
    pub open: bool,
    pub delay_ms: (f64, f64),
}

/// Serves the page until this process is to stop. Gives the feed back, if there was one, for its counts.
pub fn serve(textures: Textures, output: Output, options: Options) -> (Option<Box<Feed>>, Result<()>) {
    let shown = |source: String, status: &str, texture| Shown {
        source,
        status: status.into(),
        is_silent: false,
        texture,
        number: u64::from(texture.is_some()),
        delay_ms: options.delay_ms,
    };
    match textures {
        Textures::Fixed(name, texture) => {
            let shown = shown(name, "A texture of a file.", Some(texture));
            (None, with_page(shown, output, options, &mut |_| std::thread::sleep(LOOK)).map(drop))
        }
        Textures::Finger(feed) => {
            let shown = shown(feed.name(), WAITING, None);
            let mut finger = Finger::new(*feed);
            let mut failed = Ok(());
            let served = with_page(shown, output, options, &mut |page| {
                if let Err(error) = finger.step(page) {
                    failed = Err(error);
                    stop::request();
                }
            });
            (Some(Box::new(finger.listener.feed)), served.and(failed))
        }
    }
}

const WAITING: &str = "No texture yet: the finger has to slide over one.";
const FOUND: &str = "The texture under the finger.";

fn with_page(shown: Shown, output: Output, options: Options, step: &mut dyn FnMut(&Page)) -> Result<()> {
    let page = Page::new(output, shown)?;
    let server = Server::start(Access::new(options.address)?, page.routes())?;
    announce::announce(&server.access, options.open)?;
    while !stop::is_requested() {
        step(&page);
    }
    Ok(())
}

struct Finger {
    listener: Listener,
    found: Found,
    heard_at: Instant,
    is_silent: bool,
    is_over: bool,
}

impl Finger {
    fn new(feed: Feed) -> Self {
        let listener = Listener::new(feed, Requester::default());
        Self { listener, found: Found::default(), heard_at: Instant::now(), is_silent: false, is_over: false }
    }

    /// Waits for what the finger sends next, and shows it.
    fn step(&mut self, page: &Page) -> Result<()> {
        // An emulated board waits while nobody looks.
        if self.listener.feed.idle(!page.is_watched()) || !page.is_watched() {
            self.heard_at = Instant::now();
        }
        let heard = match self.listener.next(LOOK) {
            Err(_) if stop::is_requested() => return Ok(()),
            heard => heard?,
        };
        match heard {
            Some(Heard::Packet(packet, _)) => {
                self.heard_at = Instant::now();
                if std::mem::take(&mut self.is_silent) {
                    page.change(|shown| (shown.is_silent, shown.status) = (false, status(shown.texture)))?;
                }
                if matches!(packet.event, Event::Hello(_)) && packet.sequence == 0 {
                    self.found = Found::default();
                }
                if let Some(texture) = self.found.take(&packet) {
                    page.change(|shown| {
                        (shown.texture, shown.number) = (Some(texture), shown.number + 1);
                        shown.status = FOUND.into();
                    })?;
                }
            }
            Some(Heard::Over) => {
                self.is_over = true;
                page.change(|shown| shown.status = "The recording is over: its last texture.".into())?;
            }
            Some(Heard::Disconnected(name, why)) => {
                self.is_silent = true;
                page.change(|shown| {
                    (shown.is_silent, shown.status) = (true, format!("{name}: {why}. Plug it in again."))
                })?;
            }
            _ if !self.is_over && !self.is_silent && self.heard_at.elapsed() > SILENT => {
                self.is_silent = true;
                page.change(|shown| {
                    (shown.is_silent, shown.status) = (true, "The finger is silent: the vibration has faded.".into())
                })?;
            }
            _ => {}
        }
        Ok(())
    }
}

fn status(texture: Option<Texture>) -> String {
    if texture.is_some() { FOUND } else { WAITING }.into()
}
