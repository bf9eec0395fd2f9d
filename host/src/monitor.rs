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

use crate::feed::{Feed, Following, RawFrames};
use crate::live::Live;
use crate::stop;
use anyhow::{Context, Result};
use ratatui::crossterm::event::{self, Event as TerminalEvent};
use ridgetone_proto::settings::Settings;
use std::time::{Duration, Instant};
use view::{Action, View};

/// Between two pictures.
const BEAT: Duration = Duration::from_millis(50);

/// The screen and what is behind it.
pub struct Monitor {
    following: Following,
    /// What is known, as it goes on.
    live: Live,
    /// What was known when the screen was paused.
    still: Option<Box<Live>>,
    view: View,
}

impl Monitor {
    /// Of a feed; with `settings` these are put into force on the board first, but not stored.
    pub fn new(feed: Feed, settings: Option<Settings>) -> Self {
        let following = Following::new(feed, settings);
        // https://no-color.org
        let has_colour = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
        let (live, view) = (following.live(), View::new(following.raw().clone(), has_colour));
        Self { following, live, still: None, view }
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
        (self.following.leave(), shown)
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
                let wanted = self.view.raw != RawFrames::On;
                self.following.want_raw(wanted);
                self.view.raw = self.following.raw().clone();
                if self.view.raw == RawFrames::Off {
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
            let happening = self.following.next(left)?;
            self.following.fold(happening.as_ref(), &mut self.live);
            self.view.raw = self.following.raw().clone();
            if begun.elapsed() >= most {
                return Ok(());
            }
        }
    }
}
