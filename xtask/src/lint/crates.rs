//! Third-party crates of the programs: their licences, and duplicate versions. For crates of
//! features that are off by default, only the licences are checked.

use crate::tools::{cargo, output_of, root};
use anyhow::{Context, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// Licences that require only attribution.
const LICENCES: &str = "MIT, Apache-2.0, Apache-2.0 WITH LLVM-exception, BSD-2-Clause, BSD-3-Clause, \
    0BSD, BSL-1.0, Unicode-3.0, Unlicense, Zlib";

/// File-level copyleft licence: a distributor must say where the source is available, as `NOTICE`
/// does.
const OF_FILES: &str = "MPL-2.0";

/// Crates allowed in two versions, because third-party crates require both.
const TWICE: &str = "bitflags cobs darling darling_core darling_macro syn thiserror thiserror-impl";

/// Findings about the crates, one per line.
pub fn check() -> Result<Vec<String>> {
    let notice = fs::read_to_string(root().join("NOTICE")).context("cannot read NOTICE")?;
    let mut found = complaints(&tree(&[])?, &notice, Some(TWICE));
    match tree(&["--all-features"]) {
        Ok(all) => found.extend(complaints(&all, &notice, None)),
        Err(error) => println!(
            "not checked: licences of features that are off by default, whose crates cannot be fetched: {error:#}"
        ),
    }
    Ok(found)
}

/// One line per crate, such as `syn v2.0.1 (proc-macro)|MIT OR Apache-2.0`.
fn tree(features: &[&str]) -> Result<String> {
    let tree = "tree --workspace --locked --edges normal --prefix none --format {p}|{l}";
    output_of(cargo(tree, []).args(features))
}

/// Checks the lines of [`tree`]. `twice` names the crates that may have two versions; `None` allows
/// any.
fn complaints(tree: &str, notice: &str, twice: Option<&str>) -> Vec<String> {
    let mut complaints = BTreeSet::new();
    let mut versions: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for line in tree.lines().filter(|line| !line.is_empty()) {
        let (package, licence) = line.split_once('|').unwrap_or((line, ""));
        // Cargo marks repeated lines.
        let licence = licence.trim_end_matches("(*)").trim_end();
        let mut words = package.split(' ');
        let (name, version) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
        // Crates with a path belong to the workspace.
        if words.any(|word| word.starts_with('(') && word != "(proc-macro)") {
            continue;
        }
        versions.entry(name).or_default().insert(version);
        let entry = format!("- {name}:");
        let is_named = notice.lines().any(|line| line.starts_with(&entry));
        if !is_allowed(licence, is_named) {
            complaints.insert(format!(
                "{name} {version}: the licence is {licence:?}: take another crate, or name a licence of files ({OF_FILES}) in NOTICE"
            ));
        }
    }
    let is_known = |name: &str| twice.is_none_or(|all| all.split(' ').any(|known| known == name));
    for (name, all) in versions {
        if all.len() > 1 && !is_known(name) {
            complaints.insert(format!(
                "{name} is there in {} versions: {all:?}",
                all.len()
            ));
        }
    }
    complaints.into_iter().collect()
}

/// True if an SPDX expression (SPDX 2.3, annex D; `/` is an old `OR`) can be satisfied.
fn is_allowed(licence: &str, is_named: bool) -> bool {
    let plain = licence.replace(['(', ')'], "").replace('/', " OR ");
    let is_met = |one: &str| {
        let one = one.trim();
        LICENCES.split(", ").any(|allowed| allowed == one) || is_named && one == OF_FILES
    };
    // `A OR B AND C`, as written here, means `(A OR B) AND C`: one alternative satisfies each part.
    plain
        .split(" AND ")
        .all(|part| part.split(" OR ").any(is_met))
}

#[cfg(test)]
mod tests {
    use super::complaints;

    #[test]
    fn licences_that_ask_for_more_and_crates_in_two_versions_are_refused() {
        let own = "ridgetone v0.1.0 (/somewhere/crates/finger)|";
        let fine =
            "a v1.0.0|MIT/Apache-2.0\nb v1.0.0 (proc-macro)|(MIT OR GPL-3.0-only) AND Unicode-3.0";
        let (files, twice) = ("c v2.0.0|MPL-2.0", "e v1.0.0|MIT\ne v2.0.0|MIT");
        let notice = "- c: https://example.org/c";
        for (tree, notice, part) in [
            ([own, fine, files, files].join("\n").as_str(), notice, ""),
            (files, "", "c v2.0.0: the licence is \"MPL-2.0\""),
            (files, "- cc: https://example.org/cc", "c v2.0.0"),
            ("d v1.0.0|GPL-3.0-only", notice, "d v1.0.0"),
            ("d v1.0.0|MIT AND GPL-3.0-only", notice, "d v1.0.0"),
            ("d v1.0.0|", notice, "d v1.0.0"),
            (twice, notice, "e is there in 2 versions"),
        ] {
            let found = complaints(tree, notice, Some("f"));
            assert_eq!(
                found.len(),
                usize::from(!part.is_empty()),
                "{tree}: {found:?}"
            );
            assert!(found.concat().contains(part), "{found:?}");
        }
        for known in [None, Some("f e")] {
            assert_eq!(complaints(twice, notice, known), [""; 0]);
        }
    }
}
