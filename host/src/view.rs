//! `view`: shows a board live on a page in a browser. Like the terminal's screen, the page shows
//! [`crate::live`].
//!
//! | step | file |
//! |---|---|
//! | messages to the pages | [`message`], [`hub`] |
//! | runs to look back at, and recordings | [`mod@run`], [`runs`], [`recorder`] |
//! | the server | [`server`], [`run_routes`] |
//! | access control | [`guard`] |
//! | the page's files | [`files`] |
//! | its address, and the browser | [`announce`] |
//! | the status line | [`status`] |
//!
//! The page itself is in `host/assets`. It is built into the binary with the plotting library
//! ([uPlot](https://github.com/leeoniya/uPlot), MIT), and loads nothing from elsewhere.

pub mod announce;
pub mod answer;
pub mod files;
pub mod guard;
pub mod hub;
pub mod message;
pub mod recorder;
pub mod run;
pub mod run_routes;
pub mod runs;
pub mod server;
pub mod status;

use crate::feed::{Feed, Following};
use crate::note;
use crate::stop;
use crate::tables::TableForm;
use answer::App;
use anyhow::{Context, Result};
use hub::{Hub, UPDATE_EVERY};
use ridgetone_proto::settings::Settings;
use run::How;
use runs::Runs;
use server::Server;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Maximum time between two checks of [`stop`].
const LOOK: Duration = Duration::from_millis(20);

/// The page's port, unless it is taken.
const PORT: u16 = 8321;

/// Options of the page.
#[derive(Clone, Debug)]
pub struct Options {
    pub open: bool,
    /// A file that pages can look back at from the beginning.
    pub run: Option<RunFile>,
}

/// A file to show.
#[derive(Clone, Debug)]
pub struct RunFile {
    pub path: PathBuf,
    /// Settings that replace those in the file.
    pub settings: Option<Settings>,
    /// Rows per second of a table, in place of its stamps.
    pub rate_hz: Option<f64>,
    pub form: TableForm,
    /// True if only this file is shown: if it cannot be opened, the command ends.
    pub is_alone: bool,
}

impl RunFile {
    fn open(self, runs: &Runs) -> Result<()> {
        let name = self.path.file_name().map_or_else(
            || self.path.display().to_string(),
            |name| name.to_string_lossy().into(),
        );
        let how = How {
            settings: self.settings,
            rate_hz: self.rate_hz,
            form: self.form,
            max_bytes: usize::MAX,
            ..How::default()
        };
        runs.open(&name, &self.path, how)?;
        Ok(())
    }
}

/// Prints the URL of the page and serves it until the process is asked to stop. `settings` are
/// first applied to the board, but not stored. Returns the feed, so that its counts can be read.
pub fn run(feed: Feed, settings: Option<Settings>, options: &Options) -> (Feed, Result<()>) {
    let mut following = Following::new(feed, settings);
    let served = serve(&mut following, options);
    (following.finish(), served)
}

fn serve(following: &mut Following, options: &Options) -> Result<()> {
    let folder = tempfile::Builder::new()
        .prefix("ridgetone-")
        .tempdir()
        .context("a temporary folder")?;
    let (hub, runs) = (Hub::new(following.live()), Runs::new(folder.path()));
    let (hub, runs) = (Arc::new(hub), Arc::new(runs));
    let server = Server::start(
        PORT,
        server::routes(App {
            hub: Arc::clone(&hub),
            runs: Arc::clone(&runs),
        }),
    )?;
    match options.run.clone() {
        Some(file) if file.is_alone => file.open(&runs)?,
        Some(file) => {
            std::thread::spawn(move || {
                if let Err(error) = file.open(&runs) {
                    note!("{error:#}");
                }
            });
        }
        None => {}
    }
    announce::announce(&server, options.open)?;
    let mut published = Instant::now();
    while !stop::is_requested() {
        if let Some(board) = hub.connected() {
            *following = Following::new(board, None);
        }
        if following.idle(!hub.is_watched()) {
            hub.forget_clock();
        }
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
