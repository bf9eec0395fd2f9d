//! Serves the page with the texture of a file, or the latest one reported by a finger.

use super::output::Output;
use super::page::{Page, Shown};
use crate::stimulus::Texture;
use crate::texture::{Follower, News};
use anyhow::Result;
use ridgetone_host::feed::Feed;
use ridgetone_host::stop;
use ridgetone_host::view::announce;
use ridgetone_host::view::server::Server;
use std::time::Duration;

/// Maximum time between checks of [`stop`].
const LOOK: Duration = Duration::from_millis(20);

/// The page's port, unless it is taken.
const PORT: u16 = 8322;

/// Source of the textures.
pub enum Textures {
    /// One texture, from the named file.
    Fixed(String, Texture),
    Finger(Box<Feed>),
}

/// Initial state of the page.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    pub open: bool,
    pub delay_ms: (f64, f64),
    pub carrier_hz: Option<f32>,
}

/// Serves the page until this process is asked to stop. Returns the feed, if there was one, for its
/// counts.
pub fn serve(textures: Textures, output: Output, options: Options) -> (Option<Feed>, Result<()>) {
    let (source, texture, mut finger) = match textures {
        Textures::Fixed(name, texture) => (name, Some(texture), None),
        Textures::Finger(feed) => (feed.name(), None, Some(Follower::new(*feed))),
    };
    let shown = Shown {
        source,
        status: match texture {
            Some(_) => "A texture of a file.".into(),
            None => WAITING.into(),
        },
        is_silent: false,
        texture,
        number: u64::from(texture.is_some()),
        delay_ms: options.delay_ms,
        carrier_hz: options.carrier_hz,
    };
    let served = with_page(shown, output, options, &mut finger);
    (finger.map(Follower::into_feed), served)
}

const WAITING: &str = "No texture yet: the finger has to slide over one.";
const FOUND: &str = "The texture under the finger.";

fn with_page(
    shown: Shown,
    output: Output,
    options: Options,
    finger: &mut Option<Follower>,
) -> Result<()> {
    let page = Page::new(output, shown)?;
    let server = Server::start(PORT, page.routes())?;
    announce::announce(&server, options.open)?;
    while !stop::is_requested() {
        match finger {
            Some(finger) => step(finger, &page)?,
            None => std::thread::sleep(LOOK),
        }
    }
    Ok(())
}

/// Waits for news from the finger, and shows it.
fn step(finger: &mut Follower, page: &Page) -> Result<()> {
    // An emulated board pauses while nobody watches.
    finger.idle(!page.is_watched());
    let news = match finger.next(LOOK) {
        Err(_) if stop::is_requested() => return Ok(()),
        news => news?,
    };
    match news {
        Some(News::Texture(texture)) => page.change(|shown| {
            (shown.texture, shown.number) = (Some(texture), shown.number + 1);
            (shown.is_silent, shown.status) = (false, FOUND.into());
        }),
        Some(News::Back) => {
            page.change(|shown| (shown.is_silent, shown.status) = (false, status(shown.texture)))
        }
        Some(News::Over) => {
            page.change(|shown| shown.status = "The recording is over: its last texture.".into())
        }
        Some(News::Disconnected(name, why)) => page.change(|shown| {
            (shown.is_silent, shown.status) = (true, format!("{name}: {why}. Plug it in again."))
        }),
        Some(News::Silent) => page.change(|shown| {
            (shown.is_silent, shown.status) = (
                true,
                "The finger is silent: the vibration has faded.".into(),
            )
        }),
        Some(News::Window(..)) | None => Ok(()),
    }
}

fn status(texture: Option<Texture>) -> String {
    if texture.is_some() { FOUND } else { WAITING }.into()
}
