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

/// Shortens a text to a number of columns; an ellipsis shows that it was cut.
pub fn fitted(text: &str, columns: usize) -> String {
    if text.chars().count() <= columns {
        return text.to_owned();
    }
    let kept = text.chars().take(columns.saturating_sub(1));
    kept.chain(['…']).collect()
}

/// Breaks a text between words into lines of a maximum width.
pub fn wrapped(text: &str, columns: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let begun = lines.last_mut().filter(|line| {
            line.is_empty() || line.chars().count() + 1 + word.chars().count() <= columns
        });
        match begun {
            Some(line) if line.is_empty() => word.clone_into(line),
            Some(line) => *line += &format!(" {word}"),
            // Continued lines are indented.
            None => lines.push(format!("  {word}")),
        }
    }
    lines.iter().map(|line| fitted(line, columns)).collect()
}

pub fn boxed(title: impl Into<String>) -> Block<'static> {
    Block::bordered().title(format!(" {} ", title.into()))
}
