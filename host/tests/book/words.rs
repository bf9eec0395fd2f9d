//! Names that the project has given up stay away, and a type name belongs to one type.

use super::{read, root};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Names that had several meanings, or none that a stranger knows. No item is called by them: no
/// crate, module, type, function or constant. As names of local values `rest`, `left`, `wait`,
/// `whole` and `keep` are ordinary words.
const GIVEN_UP: [&str; 39] = [
    "hot",
    "wire",
    "rivals",
    "Teller",
    "Checkup",
    "Stretch",
    "rough",
    "rest",
    "left",
    "chance",
    "dating",
    "sought",
    "climb",
    "Climber",
    "promise",
    "deal_one_by_one",
    "mishaps",
    "flips",
    "rooms",
    "Doubts",
    "cast_doubt",
    "Bouts",
    "Tally",
    "Ledger",
    "Vitals",
    "Feeder",
    "told",
    "tells",
    "asked",
    "said",
    "came",
    "went",
    "settle",
    "Line",
    "pull_rad",
    "OPEN",
    "SAME",
    "MANY",
    "PLAIN",
];

/// Types that were three: at most one each.
const ONE_OF_EACH: [&str; 2] = ["Verdict", "Order"];

/// What is declared in a line of Rust: the names behind these words.
const DECLARES: [&str; 8] = [
    "fn", "struct", "enum", "trait", "type", "mod", "const", "static",
];

#[test]
fn names_that_were_given_up_stay_away() {
    let mut counts: BTreeMap<&str, Vec<String>> = GIVEN_UP
        .iter()
        .chain(&ONE_OF_EACH)
        .map(|name| (*name, Vec::new()))
        .collect();
    let mut declared = 0;
    for path in sources() {
        let place = path
            .strip_prefix(root())
            .expect("in it")
            .display()
            .to_string();
        for part in Path::new(&place)
            .with_extension("")
            .iter()
            .filter_map(|part| part.to_str())
        {
            if let Some(places) = counts.get_mut(part) {
                places.push(place.clone());
            }
        }
        for (number, line) in read(&path).lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            let words: Vec<&str> = code
                .split(|c: char| !c.is_alphanumeric() && c != '_')
                .collect();
            for pair in words.windows(2).filter(|pair| DECLARES.contains(&pair[0])) {
                declared += 1;
                if let Some(places) = counts.get_mut(pair[1]) {
                    places.push(format!("{place}:{}", number + 1));
                }
            }
        }
    }
    assert!(declared > 5_000, "{declared} declarations");
    for (name, places) in &counts {
        println!("{name}: {} {}", places.len(), places.join(" "));
    }
    let too_many = |(name, places): &(&&str, &Vec<String>)| {
        places.len() > usize::from(ONE_OF_EACH.contains(name))
    };
    let found: Vec<_> = counts.iter().filter(too_many).collect();
    assert!(found.is_empty(), "{found:?}");
}

/// The table of what others ran into: each row ends with a test that there is.
#[test]
fn every_public_report_has_a_test() {
    let table = read(&root().join("docs/results/reports.md"));
    let sources: String = sources().iter().map(|path| read(path)).collect();
    let rows = table.lines().filter(|line| line.ends_with("` |"));
    let tests: Vec<_> = rows.filter_map(|line| line.rsplit('`').nth(1)).collect();
    assert_eq!(tests.len(), 20, "{tests:?}");
    for test in tests {
        assert!(
            sources.contains(&format!("\nfn {test}() {{")),
            "no test {test}"
        );
    }
}

/// Every file of Rust in the tree.
fn sources() -> Vec<PathBuf> {
    let mut folders = vec![root()];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in folder
            .read_dir()
            .expect("a folder")
            .map(|entry| entry.expect("an entry").path())
        {
            let name = entry
                .file_name()
                .and_then(|name| name.to_str())
                .unwrap_or_default();
            if entry.is_dir() && name != "target" && !name.starts_with('.') {
                folders.push(entry);
            } else if entry.extension().is_some_and(|extension| extension == "rs") {
                files.push(entry);
            }
        }
    }
    files
}
