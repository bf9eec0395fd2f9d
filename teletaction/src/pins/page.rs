//! The page: the latest update as three pictures.

use super::player::{Player, Update};
use super::screen;
use crate::latest::{self, Latest};
use anyhow::Result;
use axum::Router;
use axum::routing::get;
use ridgetone_host::view::announce;
use ridgetone_host::view::files::{File, ICON, STYLE};
use ridgetone_host::view::server::{Server, with_files};
use serde::Serialize;
use std::net::SocketAddr;

const FILES: &[File] = &[
    (
        "/",
        "text/html; charset=utf-8",
        include_str!("../../assets/pins/index.html"),
    ),
    STYLE,
    ICON,
    (
        "/pins.css",
        "text/css; charset=utf-8",
        include_str!("../../assets/pins/pins.css"),
    ),
    (
        "/pins.js",
        "text/javascript; charset=utf-8",
        include_str!("../../assets/pins/pins.js"),
    ),
];

#[derive(Serialize)]
struct State<'a> {
    source: &'a str,
    status: &'static str,
    /// None before the level without touch is known.
    update: Option<&'a Update>,
    summary: Option<String>,
    gain: f64,
    /// Greatest force of a pin, newtons.
    force_most_n: f32,
}

/// The page while it is served.
pub struct Page {
    latest: Latest,
    _server: Server,
}

impl Page {
    /// Serves it, and prints its address.
    pub fn start(
        address: SocketAddr,
        open: bool,
        source: &str,
        player: &Player<'_>,
    ) -> Result<Self> {
        let latest = Latest::new(json(source, None, player)?);
        let events = Router::new()
            .route("/events", get(latest::events))
            .with_state(latest.clone());
        let server = Server::start(&[address], with_files(Router::new(), FILES).merge(events))?;
        announce::announce(&server, open)?;
        Ok(Self {
            latest,
            _server: server,
        })
    }

    pub fn show(&self, source: &str, update: &Update, player: &Player<'_>) -> Result<()> {
        self.latest.publish(json(source, Some(update), player)?);
        Ok(())
    }
}

fn json(source: &str, update: Option<&Update>, player: &Player<'_>) -> Result<String> {
    let setup = player.setup();
    let status = match update {
        None => "Learning the level without touch.",
        Some(update) if screen::is_active(update) => "Pins active.",
        Some(_) => "Nothing is touched.",
    };
    Ok(serde_json::to_string(&State {
        source,
        status,
        update,
        summary: update.map(|update| screen::summary(update, setup.gain).trim().to_owned()),
        gain: setup.gain,
        force_most_n: setup.limits.greatest_n(),
    })?)
}
