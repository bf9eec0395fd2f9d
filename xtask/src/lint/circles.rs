//! Circles of imports between the files of one crate: none of such files is understood without all
//! of the others.
//!
//! Looks at `use` lines at the top level of files that are compiled into the crate, not at its tests.
//! A name that a module only passes on with `use` counts for the file that declares it. A child with
//! methods of a type that its parent declares is a part of the parent, whose type it may import.

use std::collections::{BTreeMap, BTreeSet};

/// A file of a circle that is known, and why it stays for now.
const KNOWN: [(&str, &str); 1] = [(
    "crates/tone/src/blocks.rs",
    "the estimator's files, until its engine is built anew in layers",
)];

/// The files of one crate by the path of their module, such as `check::table`.
type Files<'a> = BTreeMap<String, File<'a>>;

struct File<'a> {
    path: &'a str,
    text: &'a str,
    /// Paths that it imports; those of `pub use` are only passed on.
    imports: Vec<(Vec<String>, bool)>,
}

/// The circles of all crates, a line each. `sources` are the workspace's files: path and text.
pub fn find(sources: &[(&str, String)]) -> Vec<String> {
    let mut crates: BTreeMap<&str, Vec<(&str, &str)>> = BTreeMap::new();
    for (path, text) in sources {
        let parts = path.strip_prefix("src/").map(|inner| ("", inner));
        if let Some((name, _)) = parts.or_else(|| path.split_once("/src/")) {
            crates.entry(name).or_default().push((path, text));
        }
    }
    let circles = crates.values().flat_map(|files| circles(files));
    let is_known = |circle: &Vec<&str>| KNOWN.iter().any(|(file, _)| circle.contains(file));
    circles
        .filter(|circle| !is_known(circle))
        .map(|circle| {
            format!(
                "these files import from each other in a circle, move what they share into a file of \
                 its own: {}",
                circle.join(", ")
            )
        })
        .collect()
}

/// Groups of files of which each reaches all others.
fn circles<'a>(sources: &[(&'a str, &'a str)]) -> Vec<Vec<&'a str>> {
    let mut files = Files::new();
    let tests: BTreeSet<String> = sources
        .iter()
        .flat_map(|(path, text)| test_modules(path, text))
        .collect();
    for (path, text) in sources {
        let module = module(path);
        let is_test = |test: &String| (module.clone() + "::").starts_with(&format!("{test}::"));
        if !tests.iter().any(is_test) {
            let imports = imports(text);
            files.insert(
                module,
                File {
                    path,
                    text,
                    imports,
                },
            );
        }
    }
    let next: BTreeMap<&str, BTreeSet<&str>> = files
        .iter()
        .map(|(module, file)| {
            let own = file
                .imports
                .iter()
                .filter(|(_, is_passed_on)| !is_passed_on);
            let own = own.filter(|(path, _)| !has_methods_of_parent(file, path));
            let targets = own.filter_map(|(path, _)| target(&files, module, path));
            (
                module.as_str(),
                targets.filter(|target| target != module).collect(),
            )
        })
        .collect();
    let reached: BTreeMap<&str, BTreeSet<&str>> = next
        .keys()
        .map(|from| (*from, reach(&next, from)))
        .collect();
    let mut groups = BTreeSet::new();
    for (from, all) in &reached {
        let circle: BTreeSet<&str> = all
            .iter()
            .copied()
            .filter(|other| reached[other].contains(from))
            .collect();
        groups.insert(
            circle
                .iter()
                .map(|module| files[*module].path)
                .collect::<Vec<_>>(),
        );
    }
    groups
        .into_iter()
        .filter(|circle| !circle.is_empty())
        .collect()
}

/// True if a path leads to the parent, and the file has methods of the type that it names.
fn has_methods_of_parent(file: &File<'_>, path: &[String]) -> bool {
    let [parent, name] = path else { return false };
    parent == "super" && file.text.contains(&format!("\nimpl {name} {{"))
}

/// Everything that is imported from a module on, step by step.
fn reach<'a>(next: &BTreeMap<&'a str, BTreeSet<&'a str>>, from: &'a str) -> BTreeSet<&'a str> {
    let (mut reached, mut ahead) = (BTreeSet::new(), vec![from]);
    while let Some(module) = ahead.pop() {
        ahead.extend(
            next[module]
                .iter()
                .filter(|target| reached.insert(**target)),
        );
    }
    reached
}

/// The path of a file's module; empty for the crate's root.
fn module(path: &str) -> String {
    let inner = path.rsplit_once("src/").map_or(path, |(_, inner)| inner);
    let parts = inner.trim_end_matches(".rs").split('/');
    let parts = parts.filter(|part| !["lib", "main", "mod"].contains(part));
    parts.collect::<Vec<_>>().join("::")
}

/// Modules that a file declares for tests alone.
fn test_modules(path: &str, text: &str) -> Vec<String> {
    let after = text.split("#[cfg(test)]\n").skip(1);
    let names = after.filter_map(|rest| rest.split_once("mod ")?.1.split_once(';'));
    let names = names
        .map(|(name, _)| name)
        .filter(|name| !name.contains(' '));
    names.map(|name| join(&module(path), name)).collect()
}

fn join(module: &str, name: &str) -> String {
    [module, name].join("::").trim_matches(':').to_owned()
}

/// The imports of a file, up to its tests.
fn imports(text: &str) -> Vec<(Vec<String>, bool)> {
    let code = text
        .split("#[cfg(test)]\nmod tests {")
        .next()
        .unwrap_or_default();
    let mut imports = Vec::new();
    let mut lines = code.lines();
    while let Some(line) = lines.next() {
        let words = line
            .strip_prefix("pub(")
            .and_then(|rest| rest.split_once(") "));
        let passed_on = words
            .map(|(_, rest)| rest)
            .or_else(|| line.strip_prefix("pub "));
        if let Some(tree) = passed_on.unwrap_or(line).strip_prefix("use ") {
            let mut tree = tree.to_owned();
            while !tree.ends_with(';') {
                let Some(line) = lines.next() else { break };
                tree += line.trim();
            }
            let paths = expand(tree.trim_end_matches(';'));
            imports.extend(paths.into_iter().map(|path| (path, passed_on.is_some())));
        }
    }
    imports
}

/// The paths of a tree such as `super::{a, b::{c, d}}`.
fn expand(tree: &str) -> Vec<Vec<String>> {
    let (stem, branches) = tree.split_once('{').unwrap_or((tree, ""));
    let stem = stem.split(" as ").next().unwrap_or_default().split("::");
    let stem: Vec<String> = stem
        .map(|part| part.trim().to_owned())
        .filter(|part| !part.is_empty())
        .collect();
    let Some(branches) = branches.strip_suffix('}') else {
        return vec![stem];
    };
    let mut depth = 0;
    let branches = branches.split(|character| {
        depth += i32::from(character == '{') - i32::from(character == '}');
        character == ',' && depth == 0
    });
    branches
        .filter(|branch| !branch.trim().is_empty())
        .flat_map(|branch| expand(branch.trim()))
        .map(|path| [stem.clone(), path].concat())
        .collect()
}

/// The module of this crate from which a path imports.
fn target<'a>(files: &'a Files<'_>, from: &str, path: &[String]) -> Option<&'a str> {
    let mut rest = path;
    let mut at = from.to_owned();
    match rest.first()?.as_str() {
        "crate" => (at, rest) = (String::new(), &rest[1..]),
        "super" | "self" => {
            while let Some(step @ ("super" | "self")) = rest.first().map(String::as_str) {
                if step == "super" {
                    at = at
                        .rsplit_once("::")
                        .map_or("", |(parent, _)| parent)
                        .to_owned();
                }
                rest = &rest[1..];
            }
        }
        child if files.contains_key(&join(from, child)) => {}
        _ => return None,
    }
    while let Some(child) = rest.first().map(|name| join(&at, name)) {
        if !files.contains_key(&child) {
            break;
        }
        (at, rest) = (child, &rest[1..]);
    }
    let (module, file) = files.get_key_value(&at)?;
    let Some(name) = rest.first() else {
        return Some(module);
    };
    let passed_on = file
        .imports
        .iter()
        .filter(|(path, _)| path.last() == Some(name));
    let declared = passed_on
        .filter_map(|(path, _)| target(files, module, path))
        .next();
    Some(declared.unwrap_or(module))
}

#[cfg(test)]
mod tests {
    use super::find;

    /// Files as "path: line; line", where a line is one of a file.
    #[test]
    fn circles_are_found_and_what_is_none_is_free() {
        for (files, is_circle) in [
            // Two siblings, by a tree and by a name that the parent passes on.
            (
                "a/src/lib.rs: pub use b::B | a/src/b.rs: use crate::{c::{C, D}, x} | a/src/c.rs: use super::B",
                true,
            ),
            // A parent and its child.
            ("a/src/c.rs: use b::B | a/src/c/b.rs: use super::C", true),
            // A child with methods of its parent's type.
            (
                "a/src/c.rs: use b::B | a/src/c/b.rs: use super::C; impl C {",
                false,
            ),
            // A parent that only passes on, and a child that imports a sibling through it.
            (
                "src/main.rs: pub use b::B; pub use self::c::C | src/b.rs: use crate::C | src/c.rs: use std::fmt",
                false,
            ),
            // Tests import what they like.
            (
                "a/src/b.rs: use super::c::C | a/src/c.rs: #[cfg(test)]; mod tests {; use crate::b::B",
                false,
            ),
            (
                "a/src/lib.rs: use b::B; #[cfg(test)]; mod tests; | a/src/b.rs: use std::fmt | a/src/tests.rs: use super::b::B",
                false,
            ),
            // Two crates.
            (
                "a/src/b.rs: use crate::c::C | d/src/c.rs: use crate::b::B | d/src/b.rs: ",
                false,
            ),
        ] {
            let sources: Vec<(&str, String)> = files
                .split(" | ")
                .filter_map(|file| file.split_once(": "))
                .map(|(path, lines)| {
                    let lines = lines.split("; ").map(|line| {
                        match line.starts_with("use") || line.starts_with("pub use") {
                            true => line.to_owned() + ";\n",
                            false => line.to_owned() + "\n",
                        }
                    });
                    (path, lines.collect())
                })
                .collect();
            let found = find(&sources);
            assert_eq!(found.len(), usize::from(is_circle), "{files}: {found:?}");
        }
    }
}
