//! Makes untrusted text safe for a terminal: file names, column names, lines of a file.

use std::borrow::Cow;
use std::fmt::Write;

/// Longest message, characters.
const MAX: usize = 1200;
/// Characters kept from the end of a longer message, where the reason is.
const END: usize = 400;

/// Escapes control characters, which could clear a terminal or set its title, and marks that
/// reverse the direction of the following text, in Rust's notation. Line breaks and tabs become
/// spaces.
pub fn escaped(text: &str) -> Cow<'_, str> {
    if !text.contains(is_active) {
        return Cow::Borrowed(text);
    }
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '\n' | '\r' | '\t' => safe.push(' '),
            active if is_active(active) => {
                // Writing to a String cannot fail.
                let _ = write!(safe, "{}", active.escape_default());
            }
            other => safe.push(other),
        }
    }
    Cow::Owned(safe)
}

/// Returns an [`escaped`] text of bounded length: the middle of a longer text is cut out.
pub fn printable(text: &str) -> Cow<'_, str> {
    let safe = escaped(text);
    match safe.chars().count() > MAX {
        true => Cow::Owned(cut(&safe)),
        false => safe,
    }
}

fn cut(text: &str) -> String {
    let length = text.chars().count();
    let mark = format!(" ... ({length} characters) ... ");
    let begin = MAX - END - mark.len();
    let start: String = text.chars().take(begin).collect();
    let end: String = text.chars().skip(length - END).collect();
    start + &mark + &end
}

fn is_active(character: char) -> bool {
    let is_direction = matches!(
        character,
        '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
    );
    character.is_control() || is_direction
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_on_a_terminal_is_escaped_and_words_stay() {
        let word = "Zeit [ms], \"ä\", a\u{308}, 時間 \\";
        assert_eq!(printable(word), word);
        assert_eq!(
            printable("a\x1b]0;title\x07\0b\u{9b}1m\u{202e}\r\n"),
            r"a\u{1b}]0;title\u{7}\u{0}b\u{9b}1m\u{202e}  "
        );
    }

    #[test]
    fn a_long_message_keeps_its_beginning_and_its_end() {
        for filling in ["x", "\x1b", "ä"] {
            let long = format!("a.csv: line 5: {}: no number", filling.repeat(64_000));
            let cut = printable(&long);
            assert_eq!(cut.chars().count(), MAX);
            assert!(cut.starts_with("a.csv: line 5: ") && cut.ends_with(": no number"));
            assert_eq!(printable(&cut), cut);
        }
        let just = "x".repeat(MAX);
        assert_eq!(printable(&just), just);
    }
}
