//! Styles and boxes that the parts of the screen share.

use super::view::View;
use ratatui::style::{Color, Modifier, Style};
use ratatui::widgets::Block;

pub fn alarm(view: &View) -> Style {
    if view.has_colour {
        bold().fg(Color::Red)
    } else {
        bold().add_modifier(Modifier::REVERSED)
    }
}

pub fn bold() -> Style {
    Style::new().add_modifier(Modifier::BOLD)
}

pub fn boxed(title: impl Into<String>) -> Block<'static> {
    Block::bordered().title(format!(" {} ", title.into()))
}
