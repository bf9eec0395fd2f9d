//! State of the screen, and the keys that change it.

use crate::feed::RawFrames;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

/// Lengths of the history that can be shown, seconds.
const HISTORY_S: [f64; 5] = [10.0, 30.0, 60.0, 180.0, 600.0];

/// Lengths of the strips that can be shown, seconds.
const STRIPS_S: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    Quit,
    Clear,
    /// Requests raw frames, or stops them.
    Raw,
}

#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// True if the screen is paused; packets are still processed.
    pub is_paused: bool,
    pub shows_help: bool,
    pub raw: RawFrames,
    /// True if alarms are red. All other text has the terminal's own colours.
    pub has_colour: bool,
    history: usize,
    strips: usize,
}

impl View {
    pub fn new(raw: RawFrames, has_colour: bool) -> Self {
        Self {
            is_paused: false,
            shows_help: false,
            raw,
            has_colour,
            history: 1,
            strips: 1,
        }
    }

    pub fn history_s(&self) -> f64 {
        HISTORY_S[self.history]
    }

    pub fn strips_s(&self) -> f64 {
        STRIPS_S[self.strips]
    }

    /// Handles a key. Returns the action that the caller must carry out.
    pub fn press(&mut self, key: KeyEvent) -> Option<Action> {
        if key.kind == KeyEventKind::Release {
            return None;
        }
        if self.shows_help && key.code != KeyCode::Char('c') {
            self.shows_help = false;
            return None;
        }
        match key.code {
            KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => {
                return Some(Action::Quit);
            }
            KeyCode::Char('q') | KeyCode::Esc => return Some(Action::Quit),
            KeyCode::Char('c') => return Some(Action::Clear),
            KeyCode::Char('r') => return Some(Action::Raw),
            KeyCode::Char('p' | ' ') => self.is_paused = !self.is_paused,
            KeyCode::Char('h' | '?') => self.shows_help = true,
            KeyCode::Char('+') => self.history = self.history.saturating_sub(1),
            KeyCode::Char('-') => self.history = (self.history + 1).min(HISTORY_S.len() - 1),
            KeyCode::Char(']') => self.strips = self.strips.saturating_sub(1),
            KeyCode::Char('[') => self.strips = (self.strips + 1).min(STRIPS_S.len() - 1),
            _ => {}
        }
        None
    }
}

/// Keys, for the last line of the screen.
pub const KEYS: &str = "q quit  p pause  c clear  r raw frames  +- history  [] channels  h help";

pub const HELP: &[&str] = &[
    "q, Esc, Ctrl-C  leave",
    "p, space        pause the screen; packets are still read",
    "c               clear history, channels, image and events",
    "r               request raw frames of the board, or end them",
    "+  -            shorter, longer history",
    "]  [            shorter, longer time of the channels",
    "",
    "The chart shows the frequency of every window with one",
    "standard deviation up and down; x: not good (see status).",
    "A strip is one channel's voltage about its mean, all on",
    "one scale. The map shows the level of each taxel in",
    "the latest hold, x to the right; times are device time.",
    "",
    "any key closes this",
];
