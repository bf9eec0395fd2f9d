//! Tuple parameters of Rust functions.

/// Finds functions with a tuple parameter. Returns the line number and name of each.
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

/// Strips a line's comment. A URL in a string is not a comment.
fn without_comment(line: &str) -> &str {
    match line.find("//") {
        Some(at) if !line[..at].ends_with(':') => &line[..at],
        _ => line,
    }
}

/// Change of nesting depth at a character, from lists of opening and closing characters.
fn step(character: char, open: &str, close: &str) -> i32 {
    i32::from(open.contains(character)) - i32::from(close.contains(character))
}

/// The parameter list without its parentheses, after any generics, which may have parentheses too.
fn parameters(text: &str) -> Option<&str> {
    // A closure's arrow does not close a list of generics.
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

/// Splits a list at its top-level commas.
fn split(list: &str) -> impl Iterator<Item = &str> {
    let mut depth = 0;
    list.split(move |character| {
        depth += step(character, "([{", ")]}");
        depth == 0 && character == ','
    })
}

/// True if a parameter's type is a tuple or a reference to one.
fn is_tuple(parameter: &str) -> bool {
    let mut depth = 0;
    let colon = parameter.find(|character| {
        depth += step(character, "([{", ")]}");
        depth == 0 && character == ':'
    });
    let kind = colon.map_or("", |colon| parameter[colon + 1..].trim());
    let words = kind.trim_start_matches('&').split_inclusive(' ');
    let kind = words
        .skip_while(|word| word.starts_with('\'') || *word == "mut ")
        .collect::<String>();
    let inside = kind
        .strip_prefix('(')
        .and_then(|rest| rest.strip_suffix(')'));
    inside.is_some_and(|inside| split(inside).count() > 1)
}

#[test]
fn tuples_and_references_to_tuples_are_found() {
    let found = "(pair: (f32, f32))
        (&self, (from, to): (usize, usize))
        (first: u8, second: &(A, B),)
        (pair: &'a mut (A, B))
        (pair: (A<B>, [u8; 2]))
        <F: Fn(u8) -> u8>(f: F, pair: (u8, u8))";
    let free = "()
        (a: u8, b: u8)
        (f: impl Fn((u8, u8), u8))
        (f: &mut dyn FnMut(A, B) -> (A, B))
        (pairs: &[(f32, f32)])
        (pairs: Vec<(A, B)>)
        (one: &(dyn Fn(u8, u8) + Send))
        (none: ())
        <F: FnOnce((u8, u8))>(f: F)
        (/* none */) -> (A, B)";
    for (cases, expected) in [(found, vec![(2, "name".to_owned())]), (free, vec![])] {
        for case in cases
            .lines()
            .flat_map(|case| [case.into(), case.replace(", ", ",\n")])
        {
            // In two parts, so that the lint finds no function in this file.
            let text = format!(
                "/// {0} a(b: (u8, u8))\npub {0} name{1} {{\n}}\n",
                "fn",
                case.trim()
            );
            assert_eq!(tuples(&text), expected, "{text}");
        }
    }
}
