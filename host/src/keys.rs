//! Keys pressed on the terminal, and its end.

use crate::stop;
use anyhow::Result;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyEvent};
use std::time::Duration;

/// The next key that was pressed, without waiting; None if there is none. Once the terminal is gone
/// this requests the end of the process: crossterm's `poll` would never return then
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

/// Restores the terminal, unless it is gone. ratatui would fail on one that is gone and report it on
/// standard error; where that is the same terminal, the report panics and the process aborts.
pub fn restore(terminal: DefaultTerminal) {
    if is_terminal_gone() {
        std::mem::forget(terminal);
    } else {
        ratatui::restore();
    }
}

/// True if the terminal was closed, or the connection that it belongs to.
#[cfg(unix)]
fn is_terminal_gone() -> bool {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    use std::io::IsTerminal;
    use std::sync::LazyLock;
    // Asked at first, because a terminal that is gone is none. Where standard input is no terminal,
    // keys come from another, and an end here says nothing.
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
