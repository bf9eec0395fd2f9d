//! `monitor`: shows a board live on the terminal. The screen is drawn from [`crate::live`]; this
//! file handles the terminal, the keys and the refresh.

mod chart;
mod health;
mod map;
pub mod screen;
mod strips;
mod style;
#[cfg(test)]
mod tests;
mod tone;
pub mod view;

use crate::feed::{Feed, Following, RawFrames};
use crate::keys;
use crate::live::Live;
use crate::stop;
use anyhow::{Context, Result};
use ridgetone_proto::settings::Settings;
use std::time::{Duration, Instant};
use view::{Action, View};

/// Time between two redraws.
const REFRESH: Duration = Duration::from_millis(50);

/// True if alarms may be red, see <https://no-color.org>.
pub fn has_colour() -> bool {
    std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

pub struct Monitor {
    following: Following,
    live: Live,
    /// The state when the screen was paused.
    paused: Option<Box<Live>>,
    view: View,
}

impl Monitor {
    /// Creates a screen for a feed. `settings` are first applied to the board, but not stored.
    pub fn new(feed: Feed, settings: Option<Settings>) -> Self {
        let following = Following::new(feed, settings);
        let (live, view) = (
            following.live(),
            View::new(following.raw.clone(), has_colour()),
        );
        Self {
            following,
            live,
            paused: None,
            view,
        }
    }

    /// Shows the screen until the user quits or the process is asked to stop. Returns the feed, so
    /// that its counts can be read.
    pub fn run(mut self) -> (Feed, Result<()>) {
        let shown = ratatui::try_init()
            .context("the terminal")
            .and_then(|mut terminal| {
                let shown = self.show(&mut terminal);
                keys::restore(terminal);
                shown
            });
        (self.following.finish(), shown)
    }

    fn show(&mut self, terminal: &mut ratatui::DefaultTerminal) -> Result<()> {
        while !stop::is_requested() {
            terminal.draw(|frame| {
                screen::draw(
                    frame,
                    self.paused.as_deref().unwrap_or(&self.live),
                    &self.view,
                )
            })?;
            self.take(REFRESH)?;
            while let Some(key) = keys::next()? {
                if let Some(action) = self.view.press(key)
                    && !self.act(action)
                {
                    return Ok(());
                }
            }
            self.paused = self.view.is_paused.then(|| {
                self.paused
                    .take()
                    .unwrap_or_else(|| Box::new(self.live.clone()))
            });
        }
        Ok(())
    }

    /// Carries out an action. Returns false if the user quits.
    fn act(&mut self, action: Action) -> bool {
        match action {
            Action::Quit => return false,
            Action::Clear => {
                self.live.clear();
                self.paused = None;
            }
            Action::Raw => {
                self.following.want_raw(self.view.raw != RawFrames::On);
                self.view.raw = self.following.raw.clone();
                if self.view.raw == RawFrames::Off {
                    self.live.strips = Default::default();
                }
            }
        }
        true
    }

    fn take(&mut self, max: Duration) -> Result<()> {
        let begun = Instant::now();
        loop {
            let left = max.saturating_sub(begun.elapsed());
            let event = self.following.next(left)?;
            self.following.fold(event.as_ref(), &mut self.live);
            self.view.raw = self.following.raw.clone();
            if begun.elapsed() >= max {
                return Ok(());
            }
        }
    }
}
