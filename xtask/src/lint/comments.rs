//! Openings of comments.

use super::Finding;

/// Words that no comment opens with: what follows them reads as translated, or depends on the
/// comment before.
const REFUSED: [&str; 7] = ["Of", "Nor", "And", "The same", "So too", "Unless", "Behind"];

/// Lines with a comment that opens with a refused word. `marker` begins a comment.
pub fn openings(text: &str, marker: &str) -> Vec<Finding> {
    let numbered = text.lines().zip(1..);
    let refused = numbered.filter_map(|(line, number)| Some((number, refused(line, marker)?)));
    refused
        .map(|(line, word)| Finding {
            line,
            what: format!(
                "the comment opens with \"{word}\": begin with a noun phrase that says what the \
                 thing is, or with a verb that says what it does, or delete the comment"
            ),
        })
        .collect()
}

/// The refused word that a line's comment opens with.
fn refused(line: &str, marker: &str) -> Option<&'static str> {
    let comment = comment(line, marker)?.trim_start();
    REFUSED.into_iter().find(|word| {
        comment
            .strip_prefix(word)
            .is_some_and(|rest| !rest.starts_with(|next: char| next.is_alphanumeric()))
    })
}

/// A line's comment without its marker: a line of its own, or what stands after code and a blank.
fn comment<'a>(line: &'a str, marker: &str) -> Option<&'a str> {
    let text = line.trim_start();
    let comment = text
        .strip_prefix(marker)
        .or_else(|| Some(text.split_once(&format!(" {marker} "))?.1))?;
    // `///`, `//!`, `#!`
    Some(comment.trim_start_matches(['/', '!', '#']))
}
