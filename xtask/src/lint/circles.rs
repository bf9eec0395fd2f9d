//! Circular imports between the files of a crate: such files can only be understood together.
//! Checks `use` lines at the top level, but not in tests. A re-exported name counts for the file
//! that declares it. Methods of a parent's type may import the type.

use std::collections::{BTreeMap, BTreeSet};

/// Imports by file, such as `host/src/check/table`; true if an import is only a re-export.
type Imports = BTreeMap<String, Vec<(String, bool)>>;

/// Finds the circles of all crates, one per line. `sources` are paths and texts of the workspace's
/// files.
pub fn find(sources: &[(&str, String)]) -> Vec<String> {
    let mut all = Imports::new();
    for (path, text) in sources.iter().filter(|(path, _)| !path.contains("tests")) {
        let module = path.replace("/lib.rs", "").replace("/main.rs", "");
        all.insert(module.trim_end_matches(".rs").to_owned(), imports(text));
    }
    let mut reached = BTreeMap::<&String, BTreeSet<&String>>::new();
    for (from, imports) in &all {
        let own = imports.iter().filter(|(_, is_passed_on)| !is_passed_on);
        let targets = own.filter_map(|(path, _)| target(&all, from, path));
        reached.insert(from, targets.filter(|to| *to != from).collect());
    }
    let mut before = BTreeMap::new();
    while reached != before {
        before.clone_from(&reached);
        for to in reached.values_mut() {
            let beyond = to.iter().flat_map(|next| &before[next]).copied();
            *to = beyond.chain(to.iter().copied()).collect();
        }
    }
    let mut circles = BTreeSet::new();
    for (from, to) in reached.iter().filter(|(from, to)| to.contains(*from)) {
        let mut circle = to.clone();
        circle.retain(|other| reached[other].contains(from));
        circles.insert(format!("files that import from each other: {circle:?}"));
    }
    circles.into_iter().collect()
}

/// Returns the imports of a file, without those of its tests.
fn imports(text: &str) -> Vec<(String, bool)> {
    let code = text.split("\nmod tests {").next().unwrap_or_default();
    let code = format!("\n{code}").replace("\npub(crate) use ", "\npub use ");
    let mut imports = Vec::new();
    for statement in code.split(';') {
        let passed_on = statement.rsplit_once("\npub use ");
        if let Some((_, tree)) = passed_on.or_else(|| statement.rsplit_once("\nuse ")) {
            imports.extend(expand(tree).map(|path| (path, passed_on.is_some())));
        }
    }
    let is_parent = |name: &str| text.contains(&format!("\nimpl {name} {{"));
    imports.retain(|(path, _)| !path.strip_prefix("super/").is_some_and(is_parent));
    imports
}

/// Expands a tree such as `super::{a, b::{c, d}}` to paths with slashes.
fn expand(tree: &str) -> impl Iterator<Item = String> {
    let (mut stems, mut path, mut paths) = (Vec::<String>::new(), String::new(), Vec::new());
    let tree = tree.replace("::", "/").replace(" as ", "#") + ",";
    for character in tree.chars().filter(|character| !character.is_whitespace()) {
        match character {
            '{' => stems.push(path.clone()),
            ',' | '}' => {
                paths.extend(path.split('#').next().map(str::to_owned));
                path = stems.last().cloned().unwrap_or_default();
                stems.truncate(stems.len() - usize::from(character == '}' && !stems.is_empty()));
            }
            _ => path.push(character),
        }
    }
    paths.into_iter().filter(|path| !path.ends_with('/'))
}

/// The file from which a path imports; `from` itself if the path is in a different crate.
fn target<'a>(all: &'a Imports, from: &str, path: &str) -> Option<&'a String> {
    let (mut at, mut rest) = (from, path);
    while let Some((first @ ("crate" | "super" | "self"), behind)) = rest.split_once('/') {
        rest = behind;
        match first {
            "crate" => at = &from[..from.find("src")? + 3],
            "super" => at = at.rsplit_once('/')?.0,
            _ => {}
        }
    }
    let whole = format!("{at}/{rest}");
    let mut module = whole.as_str();
    while !all.contains_key(module) {
        module = module.rsplit_once('/')?.0;
    }
    let name = whole[module.len()..].split('/').nth(1);
    let (module, imports) = all.get_key_value(module)?;
    let is_it = |path: &str| module != from && path.rsplit('/').next() == name;
    let mut passed_on = imports.iter().filter(|(path, _)| is_it(path));
    let declared = passed_on.find_map(|(path, _)| target(all, module, path));
    declared.or(Some(module))
}

#[test]
fn circles_are_found_and_what_is_none_is_free() {
    let cases = "\
        siblings, by a tree and a name that is passed on = a/src/lib.rs: pub use b::B | a/src/b.rs: use crate::{c::{C}, x} | a/src/c.rs: use super::B
        a parent and its child = a/src/c.rs: use b::B | a/src/c/b.rs: use super::C
        not methods of the parent's type = a/src/c.rs: use b::B | a/src/c/b.rs: use super::C; impl C {
        not a parent that only passes on = src/main.rs: pub use b::B; pub use self::c::C | src/b.rs: use crate::C | src/c.rs: use std::fmt
        not tests in a file = a/src/b.rs: use super::c::C | a/src/c.rs: use a::B; mod tests {; use crate::b::B
        not files of tests = a/src/lib.rs: use b::B | a/src/b.rs: use std::fmt | a/src/tests.rs: use super::b::B
        not two crates = a/src/b.rs: use crate::c::C | d/src/c.rs: use crate::b::B | d/src/b.rs: ";
    for case in cases.lines() {
        let files = case.split(['=', '|']);
        let files = files.filter_map(|file| file.trim_start().split_once(": "));
        let lines = |text: &str| text.replace("; ", ";\n").replace("{;", "{") + ";\n";
        let sources: Vec<_> = files.map(|(path, text)| (path, lines(text))).collect();
        let is_free = case.trim().starts_with("not ");
        assert_eq!(find(&sources).is_empty(), is_free, "{case}");
    }
}
