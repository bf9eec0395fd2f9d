//! Reads keys from the terminal, and detects when it is closed.

use crate::stop;
use anyhow::Result;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyEvent};
use std::time::Duration;

/// Returns the next key that was pressed, without waiting; `None` if there is none. If the terminal
/// is gone, requests the end of the process, because crossterm's `poll` would never return
/// (<https://github.com/crossterm-rs/crossterm/issues/793>).
pub fn next() -> Result<Option<KeyEvent>> {
    loop {
        if is_terminal_gone() {
            stop::request();
            return Ok(None);
        }
        if !event::poll(Duration::ZERO)? {
            return Ok(None);
        }
        if let Event::Key(key) = event::read()? {
            return Ok(Some(key));
        }
    }
}

/// Restores the terminal, unless it is gone. ratatui would fail on a closed terminal and report it
/// on standard error; if that is the same terminal, the report panics and the process aborts.
pub fn restore(terminal: DefaultTerminal) {
    if is_terminal_gone() {
        std::mem::forget(terminal);
    } else {
        ratatui::restore();
    }
}

/// True if the terminal, or the connection that it belongs to, was closed.
#[cfg(unix)]
fn is_terminal_gone() -> bool {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    use std::io::IsTerminal;
    use std::sync::LazyLock;
    // Check once at the start, because a closed terminal no longer counts as one. If standard input
    // is not a terminal, keys do not come from it, and its end is ignored.
    static IS_TERMINAL: LazyLock<bool> = LazyLock::new(|| std::io::stdin().is_terminal());
    let stdin = std::io::stdin();
    let mut ends = [PollFd::new(&stdin, PollFlags::IN)];
    let at_once = Timespec::default();
    let gone = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
    *IS_TERMINAL && poll(&mut ends, Some(&at_once)).is_ok() && ends[0].revents().intersects(gone)
}

#[cfg(not(unix))]
fn is_terminal_gone() -> bool {
    false
}
