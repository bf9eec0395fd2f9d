//! Tuples as parameters of Rust functions.

use super::Finding;

/// Lines on which a function begins that takes a tuple.
pub fn tuples(text: &str) -> Vec<Finding> {
    let code = without_comments(text);
    let mut findings = Vec::new();
    for (start, _) in code.match_indices("fn ") {
        let is_word =
            !code[..start].ends_with(|before: char| before.is_alphanumeric() || before == '_');
        if !is_word {
            continue;
        }
        let Some(name) = name_with_tuple(&code[start + 3..]) else {
            continue;
        };
        findings.push(Finding {
            line: code[..start].lines().count().max(1),
            what: format!(
                "`{name}` takes a tuple: give the values a struct with a name, or pass them one by one"
            ),
        });
    }
    findings
}

/// Source text without its line comments, line by line.
fn without_comments(text: &str) -> String {
    text.lines()
        .map(|line| match line.find("//") {
            // An address in a string is no comment.
            Some(at) if !line[..at].ends_with(':') => &line[..at],
            _ => line,
        })
        .flat_map(|line| [line, "\n"])
        .collect()
}

/// The name of a function, of which the text begins with the name, if one of its parameters is a
/// tuple.
fn name_with_tuple(text: &str) -> Option<&str> {
    let name_end = text.find(|next: char| !(next.is_alphanumeric() || next == '_'))?;
    let open = name_end + opening(&text[name_end..])?;
    let parameters = &text[open..open + length(&text[open..])?];
    let inside = &parameters[1..parameters.len() - 1];
    split(inside).any(is_tuple).then_some(&text[..name_end])
}

/// Where the list of parameters opens, after generics that may have parentheses of their own.
fn opening(text: &str) -> Option<usize> {
    if text.starts_with('(') {
        return Some(0);
    }
    let mut depth = 0_i32;
    let mut previous = ' ';
    for (at, character) in text.char_indices() {
        match character {
            '<' => depth += 1,
            '>' if previous != '-' => depth -= 1,
            '(' if depth == 0 => return Some(at),
            '{' | ';' => return None,
            _ => {}
        }
        previous = character;
    }
    None
}

/// The length of a list with its parentheses.
fn length(list: &str) -> Option<usize> {
    let mut depth = 0_i32;
    for (at, character) in list.char_indices() {
        depth += step(character);
        if depth == 0 {
            return Some(at + 1);
        }
    }
    None
}

fn step(character: char) -> i32 {
    match character {
        '(' | '[' | '{' => 1,
        ')' | ']' | '}' => -1,
        _ => 0,
    }
}

/// The elements of a list, which commas between them separate.
fn split(list: &str) -> impl Iterator<Item = &str> {
    let mut depth = 0_i32;
    list.split(move |character| {
        depth += step(character);
        depth == 0 && character == ','
    })
}

/// Whether the type of a parameter is a tuple, or a reference to one.
fn is_tuple(parameter: &str) -> bool {
    let mut depth = 0_i32;
    let colon = parameter.find(|character| {
        depth += step(character);
        depth == 0 && character == ':'
    });
    let Some(colon) = colon else { return false };
    let mut kind = parameter[colon + 1..].trim();
    while let Some(behind) = kind.strip_prefix('&') {
        kind = behind.trim_start();
        if let Some(lifetime) = kind.strip_prefix('\'') {
            kind = lifetime.trim_start_matches(|next: char| next.is_alphanumeric() || next == '_');
        }
        kind = kind.trim_start();
        kind = kind.strip_prefix("mut ").unwrap_or(kind).trim_start();
    }
    kind.starts_with('(') && kind.ends_with(')') && split(&kind[1..kind.len() - 1]).count() > 1
}
