//! `monitor`: what a board does, live on the terminal. The screen is drawn from [`crate::live`]; here are the terminal, the
//! keys and the beat.

mod chart;
mod health;
mod map;
pub mod screen;
mod strips;
#[cfg(test)]
mod tests;
mod tone;
pub mod view;

use crate::events;
use crate::feed::{Asking, Feed, Happening};
use crate::live::{Line, Live};
use crate::stop;
use anyhow::{Context, Result};
use ratatui::crossterm::event::{self, Event as TerminalEvent};
use ridgetone::command::{Command, Outcome};
use ridgetone::settings::Settings;
use std::time::{Duration, Instant};
use view::{Action, RawFrames, View};

/// Between two pictures.
const BEAT: Duration = Duration::from_millis(50);

/// The screen and what is behind it.
pub struct Monitor {
    feed: Feed,
    /// What is known, as it goes on.
    live: Live,
    /// What was known when the screen was paused.
    still: Option<Box<Live>>,
    view: View,
    asking: Asking,
}

impl Monitor {
    /// Of a feed; with `settings` these are put into force on the board first, but not stored.
    pub fn new(feed: Feed, settings: Option<Settings>) -> Self {
        let raw = if feed.has_board() { RawFrames::On } else { RawFrames::Unavailable };
        let mut asking = Asking::default();
        if let Some(settings) = settings {
            asking.give(Command::Set { settings, keep: false });
        }
        if raw == RawFrames::On {
            asking.want_raw(true);
        }
        // https://no-color.org
        let has_colour = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
        let live = Live::new(feed.name());
        Self { feed, live, still: None, view: View::new(raw, has_colour), asking }
    }

    /// Shows it until the user leaves, or this process is asked to end. Gives the feed back, with what it has counted.
    ///
    /// # Errors
    /// The terminal does not work; those of the feed. The terminal is as it was before in any case.
    pub fn run(mut self) -> (Feed, Result<()>) {
        let shown = ratatui::try_init().context("the terminal").and_then(|mut terminal| {
            let shown = self.show(&mut terminal);
            ratatui::restore();
            shown
        });
        self.leave();
        (self.feed, shown)
    }

    fn show(&mut self, terminal: &mut ratatui::DefaultTerminal) -> Result<()> {
        while !stop::is_asked() {
            terminal.draw(|frame| screen::draw(frame, self.still.as_deref().unwrap_or(&self.live), &self.view))?;
            self.take(BEAT)?;
            while event::poll(Duration::ZERO)? {
                if let TerminalEvent::Key(key) = event::read()?
                    && let Some(action) = self.view.press(key)
                    && !self.act(action)
                {
                    return Ok(());
                }
            }
            self.still = self.view.is_paused.then(|| self.still.take().unwrap_or_else(|| Box::new(self.live.clone())));
        }
        Ok(())
    }

    /// Does what a key asks for. False: leave.
    fn act(&mut self, action: Action) -> bool {
        match action {
            Action::Quit => return false,
            Action::Clear => {
                self.live.clear();
                self.still = None;
            }
            Action::Raw => {
                let wanted = match self.view.raw {
                    RawFrames::Unavailable => return true,
                    RawFrames::On => false,
                    RawFrames::Off | RawFrames::Refused(_) => true,
                };
                self.view.raw = if wanted { RawFrames::On } else { RawFrames::Off };
                self.asking.want_raw(wanted);
                if !wanted {
                    self.live.strips = Default::default();
                }
            }
        }
        true
    }

    /// Takes what comes within a time.
    fn take(&mut self, most: Duration) -> Result<()> {
        let begun = Instant::now();
        loop {
            let left = most.saturating_sub(begun.elapsed());
            match self.feed.next(left)? {
                Some(Happening::Packet(packet)) => {
                    self.live.take(&packet);
                    if let Some((command, outcome)) = self.asking.hear(&packet)
                        && !matches!(outcome, Outcome::Done | Outcome::DoneErased)
                    {
                        self.refused(&command, events::outcome(&outcome));
                    }
                }
                Some(Happening::Came(name)) => {
                    self.live.source.clone_from(&name);
                    (self.live.line, _) = (Line::There, self.live.note(format!("{name}: the board is there")));
                }
                Some(Happening::Went(name, why)) => {
                    self.live.note(format!("{name}: {why}"));
                    self.live.line = Line::Gone { why };
                }
                Some(Happening::Over) => self.live.line = Line::Over,
                None => {}
            }
            self.live.counts = self.feed.counts();
            if self.feed.has_board()
                && self.live.line == Line::There
                && let Err(error) = self.asking.tick(&mut self.feed)
            {
                self.live.note(format!("{error:#}"));
                self.view.raw = RawFrames::Refused("no raw frames: no answer (RX?)".into());
            }
            if begun.elapsed() >= most {
                return Ok(());
            }
        }
    }

    fn refused(&mut self, command: &Command, why: String) {
        if matches!(command, Command::Raw { .. }) {
            self.view.raw = RawFrames::Refused(format!("no raw frames: {why}"));
        }
        self.live.note(why);
    }

    /// A board is not left with raw frames on its line. Whether it hears that is not waited for: they end by themselves.
    fn leave(&mut self) {
        if self.view.raw == RawFrames::On {
            self.asking.want_raw(false);
            let _ = self.asking.tick(&mut self.feed);
        }
    }
}
