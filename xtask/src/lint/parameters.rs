//! Tuples as parameters of Rust functions.

/// Functions that take a tuple: the lines on which they begin, and their names.
pub fn tuples(text: &str) -> Vec<(usize, String)> {
    let code: Vec<&str> = text.lines().map(without_comment).collect();
    let code = code.join("\n");
    let is_name = |character: char| character.is_alphanumeric() || character == '_';
    let mut found = Vec::new();
    for (start, _) in code.match_indices("fn ") {
        let rest = &code[start + 3..];
        let Some(end) = rest.find(|character| !is_name(character)) else {
            continue;
        };
        let parameters = parameters(&rest[end..]).unwrap_or_default();
        if !code[..start].ends_with(is_name) && split(parameters).any(is_tuple) {
            let line = code[..start].matches('\n').count() + 1;
            found.push((line, rest[..end].to_owned()));
        }
    }
    found
}

/// A line up to its comment. An address in a string is no comment.
fn without_comment(line: &str) -> &str {
    match line.find("//") {
        Some(at) if !line[..at].ends_with(':') => &line[..at],
        _ => line,
    }
}

/// By how much a character nests deeper, among those of these two lists.
fn step(character: char, open: &str, close: &str) -> i32 {
    i32::from(open.contains(character)) - i32::from(close.contains(character))
}

/// The list of parameters, without its parentheses, behind generics that may have some too.
fn parameters(text: &str) -> Option<&str> {
    // The arrow of a closure closes no list of generics.
    let text_without_arrows = text.replace("->", "  ");
    let mut depth = 0;
    let open = text_without_arrows.find(|character| {
        depth += step(character, "<", ">");
        depth == 0 && "({;".contains(character)
    })?;
    let list = text[open..].strip_prefix('(')?;
    depth = 1;
    let length = list.find(|character| {
        depth += step(character, "([{", ")]}");
        depth == 0
    })?;
    Some(&list[..length])
}

/// The elements of a list, which commas between them separate.
fn split(list: &str) -> impl Iterator<Item = &str> {
    let mut depth = 0;
    list.split(move |character| {
        depth += step(character, "([{", ")]}");
        depth == 0 && character == ','
    })
}

/// True if the type of a parameter is a tuple, or a reference to one.
fn is_tuple(parameter: &str) -> bool {
    let mut depth = 0;
    let colon = parameter.find(|character| {
        depth += step(character, "([{", ")]}");
        depth == 0 && character == ':'
    });
    let kind = colon.map_or("", |colon| parameter[colon + 1..].trim());
    let words = kind.trim_start_matches('&').split_inclusive(' ');
    let modifiers = words.take_while(|word| word.starts_with('\'') || *word == "mut ");
    let length = modifiers.map(str::len).sum();
    let kind = &kind.trim_start_matches('&')[length..];
    let inside = kind
        .strip_prefix('(')
        .and_then(|rest| rest.strip_suffix(')'));
    inside.is_some_and(|inside| split(inside).count() > 1)
}

#[cfg(test)]
mod tests {
    use super::tuples;

    #[test]
    fn tuples_and_references_to_tuples_are_found() {
        for (generics, list, is_found) in [
            ("", "pair: (f32, f32)", true),
            ("", "&self, (from, to): (usize, usize)", true),
            ("", "first: u8,\n    second: &(A, B),\n", true),
            ("", "pair: &'a mut (A, B)", true),
            ("", "pair: (A<B>, [u8; 2])", true),
            ("<F: Fn(u8) -> u8>", "f: F, pair: (u8, u8)", true),
            ("", "", false),
            ("", "a: u8, b: u8", false),
            ("", "f: impl Fn((u8, u8), u8)", false),
            ("", "f: &mut dyn FnMut(A, B) -> (A, B)", false),
            ("", "pairs: &[(f32, f32)]", false),
            ("", "pairs: Vec<(A, B)>", false),
            ("", "one: &(dyn Fn(u8, u8) + Send)", false),
            ("", "none: ()", false),
            ("<F: FnOnce((u8, u8))>", "f: F", false),
            ("", "/* none */) -> (A, B", false),
        ] {
            // In two parts, so that the lint finds nothing in this file.
            let text = format!(
                "/// Text.\npub {} name{generics}({list}) -> u32 {{\n}}\n",
                "fn"
            );
            let expected = is_found.then(|| (2, "name".to_owned()));
            assert_eq!(tuples(&text), Vec::from_iter(expected), "{text}");
        }
        let commented = format!("// {} a(pair: (A, B)) {{}}\n", "fn");
        assert_eq!(tuples(&commented), []);
    }
}
