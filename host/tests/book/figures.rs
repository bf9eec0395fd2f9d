//! Figures in the documents follow from the JSON of the results. A table stands between the lines
//! `<!-- NAME -->` and `<!-- end -->`, a value in a sentence as `<!-- value: NAME -->3 %<!-- end -->`.
//! With `RIDGETONE_WRITE=1` they are written instead of compared.

use super::{documents, read, root};
use ridgetone_host::digits::significant;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

const END: &str = "<!-- end -->";

/// A table of the results: columns and rows of cells.
struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<Value>>,
}

impl Table {
    fn load(topic: &str, name: &str) -> Self {
        let table = figures(topic)["tables"][name].clone();
        let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
        let name = |column: &Value| column.as_str().unwrap_or_default().to_owned();
        Self {
            columns: list(&table["columns"]).iter().map(name).collect(),
            rows: list(&table["rows"]).iter().map(list).collect(),
        }
    }

    fn cell<'a>(&self, row: &'a [Value], column: &str) -> &'a Value {
        let at = self.columns.iter().position(|name| name == column);
        &row[at.unwrap_or_else(|| panic!("no column {column}"))]
    }

    fn number(&self, row: &[Value], column: &str) -> f64 {
        let cell = self.cell(row, column);
        cell.as_f64().unwrap_or_else(|| panic!("{column}: {cell}"))
    }
}

fn figures(topic: &str) -> Value {
    let path = root().join(format!("docs/results/{topic}.json"));
    serde_json::from_str(&read(&path)).expect("JSON")
}

/// Ridgetone with sixteen channels: a window, the harmonics of the tone, and those that are set.
#[derive(Clone, Copy)]
struct Choice {
    window_s: f64,
    there: u64,
    set: u64,
}

impl Choice {
    /// A figure that the trade measured of this choice.
    fn figure(self, choices: &Table, column: &str) -> f64 {
        let is_it = |row: &&Vec<Value>| {
            choices.cell(row, "method") == "Ridgetone"
                && *choices.cell(row, "window, s") == self.window_s
                && *choices.cell(row, "harmonics there") == self.there
                && *choices.cell(row, "set") == self.set
                && *choices.cell(row, "channels") == 16
        };
        choices.number(choices.rows.iter().find(is_it).expect("the choice"), column)
    }

    fn cells(self, choices: &Table) -> String {
        format!(
            "{} s | {} % | {} s | {} million |",
            self.window_s,
            significant(self.figure(choices, "RMS, %"), 2),
            significant(self.figure(choices, "latency, ms") / 1e3, 3),
            significant(self.figure(choices, "instructions") / 1e6, 2)
        )
    }
}

/// The tables by page and name.
fn tables() -> Vec<(&'static str, &'static str, String)> {
    let choices = Table::load("trade", "choices");
    let choice = |window_s, there, set| Choice {
        window_s,
        there,
        set,
    };
    let head = "window | RMS error | latency | instructions |\n";
    let rules = "---:|---:|---:|---:|\n";
    let mut readme = format!("| scene | set | {head}|---|---|{rules}");
    for (scene, set, choice) in [
        ("pure tone", "`--harmonics 1`", choice(1.0, 1, 1)),
        (
            "tone with three overtones",
            "the default",
            choice(1.0, 4, 4),
        ),
        (
            "tone with three overtones",
            "`--window 0.4`",
            choice(0.4, 4, 4),
        ),
    ] {
        readme += &format!("| {scene} | {set} | {}\n", choice.cells(&choices));
    }
    let mut windows = format!("| {head}|{rules}");
    for window_s in [0.2, 0.4, 1.0, 3.9] {
        windows += &format!("| {}\n", choice(window_s, 4, 4).cells(&choices));
    }
    vec![
        ("README.md", "trade", readme),
        ("docs/guide/3-speed-or-accuracy.md", "windows", windows),
    ]
}

/// The values by name.
fn values() -> BTreeMap<String, String> {
    let mut values = BTreeMap::new();
    let mut give = |name: &str, value: String| values.insert(name.to_owned(), value);

    // One harmonic where there are four, and four where there is one, over all windows.
    let choices = Table::load("trade", "choices");
    let most = |there: u64, set: [u64; 2], column: &str| {
        let ratio = |window_s| {
            let [a, b] = set.map(|set| {
                Choice {
                    window_s,
                    there,
                    set,
                }
                .figure(&choices, column)
            });
            a / b
        };
        [0.2, 0.3, 0.4, 0.6, 1.0, 3.9]
            .map(ratio)
            .into_iter()
            .fold(0.0, f64::max)
    };
    give("harmonics.error", significant(most(4, [1, 4], "RMS, %"), 2));
    give(
        "harmonics.instructions",
        significant(most(1, [4, 1], "instructions"), 2),
    );
    let lost = (100.0 * (most(1, [4, 1], "RMS, %") - 1.0)).ceil();
    give("harmonics.accuracy", lost.to_string());

    // What the register model adds to a window of the default plan; the age of a fast plan's answers.
    let plans = Table::load("trade", "plans");
    let (mut more_ms, mut fast_s) = (Vec::new(), Vec::new());
    for row in &plans.rows {
        let latency_ms = plans.number(row, "latency, ms");
        if *plans.cell(row, "plan") == "`paper`" {
            more_ms.push(latency_ms - plans.number(row, "window, ms"));
        } else {
            fast_s.push(latency_ms / 1e3);
        }
    }
    let min = |values: &[f64]| values.iter().copied().fold(f64::MAX, f64::min);
    let max = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    give(
        "latency.default_ms",
        format!("{:.0} to {:.0}", min(&more_ms), max(&more_ms)),
    );
    let fast = [min(&fast_s), max(&fast_s)].map(|s| significant(s, 2));
    give("latency.fast_s", fast.join(" to "));
    let load = |plan: &str| {
        let is_it = |row: &&Vec<Value>| {
            *plans.cell(row, "plan") == plan && *plans.cell(row, "window, ms") == 128
        };
        plans.number(plans.rows.iter().find(is_it).expect("a row"), "load, %")
    };
    let of_hand = 100.0 * load("`paper`") / load("`hand`");
    give("plans.load", format!("{of_hand:.0}"));

    // Values that a topic has itself, and requirements that are not met.
    for entry in root().join("docs/results").read_dir().expect("the results") {
        let path = entry.expect("an entry").path();
        let topic = path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        if path.extension().is_none_or(|extension| extension != "json") {
            continue;
        }
        let figures = figures(&topic);
        let own = figures["values"].as_object().into_iter().flatten();
        for (name, value) in own {
            let text = value.as_str().map_or(value.to_string(), str::to_owned);
            give(&format!("{topic}.{name}"), text);
        }
        let tables = figures["tables"].as_object().expect("tables").iter();
        let requirements = tables.filter(|(name, _)| *name == "bars" || name.ends_with("_bars"));
        let verdicts: Vec<bool> = requirements
            .flat_map(|(_, table)| table["rows"].as_array().expect("rows"))
            .filter_map(|row| row.as_array()?.iter().find_map(Value::as_bool))
            .collect();
        let unmet = verdicts.iter().filter(|is_met| !**is_met).count();
        give(
            &format!("unmet.{topic}"),
            format!("{unmet} of {}", verdicts.len()),
        );
    }
    values
}

/// A page with the values of its sentences filled in. An error names a value that there is not.
fn filled(page: &str, values: &BTreeMap<String, String>) -> Result<String, String> {
    const BEGIN: &str = "<!-- value: ";
    let mut parts = page.split(BEGIN);
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = part.split_once(" -->").ok_or("a marker without an end")?;
        let (_, after) = rest.split_once(END).ok_or(format!("{name}: no {END}"))?;
        let value = values
            .get(name)
            .ok_or(format!("no value is called {name}"))?;
        text += &[BEGIN, name, " -->", value, END, after].concat();
    }
    Ok(text)
}

/// Compares a page with what it has to be, or writes it.
fn compare_or_write(path: &Path, page: &str) {
    if std::env::var_os("RIDGETONE_WRITE").is_some() {
        std::fs::write(path, page).expect("written");
    }
    let found = read(path);
    let differs = found
        .lines()
        .zip(page.lines())
        .find(|(found, page)| found != page);
    assert!(
        found == page,
        "{}: run RIDGETONE_WRITE=1 cargo test -p ridgetone-host --test book figures\n{differs:#?}",
        path.display()
    );
}

#[test]
fn the_tables_are_those_of_the_results() {
    for (path, name, table) in tables() {
        let path = root().join(path);
        let page = read(&path);
        let begin = format!("<!-- {name} -->\n");
        let (before, rest) = page.split_once(&begin).expect("a beginning");
        let (_, after) = rest.split_once(END).expect("an end");
        compare_or_write(&path, &[before, &begin, &table, END, after].concat());
    }
}

#[test]
fn the_values_are_those_of_the_results() {
    let values = values();
    for path in documents() {
        let page = filled(&read(&path), &values);
        let page = page.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        compare_or_write(&path, &page);
    }
}

#[test]
fn a_value_is_filled_in_and_one_that_does_not_exist_is_refused() {
    let values = BTreeMap::from([("a.b".to_owned(), "3".to_owned())]);
    let page = "It takes <!-- value: a.b -->2<!-- end --> s.";
    let expected = "It takes <!-- value: a.b -->3<!-- end --> s.";
    assert_eq!(filled(page, &values).as_deref(), Ok(expected));
    assert!(filled("<!-- value: other -->2<!-- end -->", &values).is_err());
    assert!(filled("<!-- value: a.b -->2", &values).is_err());
}
