//! A feed to updates of the display, printed or on a screen.

use super::player::{Player, SILENCE_S, Update};
use super::screen;
use anyhow::{Context, Result};
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{KeyCode, KeyEventKind, KeyModifiers};
use ridgetone_host::feed::{Feed, Requester};
use ridgetone_host::keys;
use ridgetone_host::listen::{Heard, Listener};
use ridgetone_host::output;
use ridgetone_host::stop;
use std::time::{Duration, Instant};

/// Time between two looks at keys and at silence.
const LOOK: Duration = Duration::from_millis(50);

/// How updates are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    Screen,
    Lines,
    Json,
}

/// Follows a feed to its end, or until the user or this process is to stop. Gives the feed back,
/// for its counts.
pub fn run(feed: Feed, player: &mut Player, show: Show) -> (Feed, Result<()>) {
    let mut requester = Requester::default();
    requester.want_raw_if(feed.has_board());
    let mut listener = Listener::new(feed, requester);
    let shown = match show {
        Show::Screen => ratatui::try_init()
            .context("the terminal")
            .and_then(|mut terminal| {
                let shown = follow(&mut listener, player, &mut |source, update, player| {
                    draw(&mut terminal, source, update, player)
                });
                keys::restore(terminal);
                shown
            }),
        Show::Lines | Show::Json => lines(&mut listener, player, show),
    };
    (listener.feed, shown)
}

/// A line for each update.
fn lines(listener: &mut Listener, player: &mut Player, show: Show) -> Result<()> {
    let is_json = show == Show::Json;
    follow(listener, player, &mut |_, update, player| {
        if let Some((update, true)) = update {
            output::line(&match is_json {
                true => serde_json::to_string(update)?,
                false => screen::summary(update, player.setup().gain),
            })?;
        }
        Ok(true)
    })
}

/// Gives every update, and whether it is new, until the sink says false.
type Sink<'a> = dyn FnMut(&str, Option<(&Update, bool)>, &Player) -> Result<bool> + 'a;

fn follow(listener: &mut Listener, player: &mut Player, sink: &mut Sink<'_>) -> Result<()> {
    let (mut latest, mut heard_at) = (None, Instant::now());
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
        let is_new = update.is_some();
        latest = update.or(latest);
        let name = listener.feed.name();
        if !sink(
            &name,
            latest.as_ref().map(|latest| (latest, is_new)),
            player,
        )? {
            break;
        }
    }
    Ok(())
}

/// Draws an update that is new; false if the user leaves.
fn draw(
    terminal: &mut DefaultTerminal,
    source: &str,
    update: Option<(&Update, bool)>,
    player: &Player,
) -> Result<bool> {
    if update.is_none_or(|(_, is_new)| is_new) {
        terminal
            .draw(|frame| screen::draw(frame, source, update.map(|(update, _)| update), player))?;
    }
    while let Some(key) = keys::next()? {
        if key.kind != KeyEventKind::Release
            && (matches!(key.code, KeyCode::Char('q') | KeyCode::Esc)
                || key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL))
        {
            return Ok(false);
        }
    }
    Ok(true)
}
