//! Figures as JSON, and a page of Markdown beside them whose tables are filled in from the JSON.
//!
//! A person writes the page. A table stands between the lines `<!-- NAME -->` and `<!-- end -->`;
//! `<!-- NAME: 0 2 3 -->` shows some of its columns.

use anyhow::{Context, Result};
use ridgetone_host::digits::significant;
use ridgetone_host::output;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// A table of figures; each cell is a number, a text or nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    pub columns: Vec<String>,
    pub rows: Vec<Vec<Value>>,
}

/// The tables of a page by name.
pub type Tables = BTreeMap<String, Table>;

impl Table {
    /// A table with headings that `|` separates.
    pub fn new(headings: &str) -> Self {
        let columns = headings.split('|').map(str::to_owned).collect();
        Self {
            columns,
            rows: Vec::new(),
        }
    }

    pub fn row(&mut self, cells: impl IntoIterator<Item = Value>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// The table in Markdown, with these of its columns; figures stand to the right.
    fn markdown(&self, columns: &[usize]) -> String {
        let cell = |row: &[Value], column: &usize| row.get(*column).map_or_else(String::new, shown);
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let is_text = |column: &usize| {
            self.rows
                .iter()
                .any(|row| row.get(*column).is_some_and(Value::is_string))
        };
        let headings = columns
            .iter()
            .filter_map(|column| self.columns.get(*column).cloned());
        let rules: Vec<&str> = columns
            .iter()
            .map(|c| if is_text(c) { "---" } else { "---:" })
            .collect();
        let mut text = line(headings.collect()) + &format!("|{}|\n", rules.join("|"));
        for row in &self.rows {
            text += &line(columns.iter().map(|column| cell(row, column)).collect());
        }
        text.trim_end().to_owned()
    }
}

fn shown(cell: &Value) -> String {
    match (cell, cell.as_u64()) {
        (Value::String(text), _) => text.clone(),
        (Value::Bool(is_met), _) => if *is_met { "met" } else { "**not met**" }.into(),
        (_, Some(number)) => grouped(number),
        (Value::Number(number), None) => number.to_string(),
        _ => "-".into(),
    }
}

/// A cell with so many significant digits; nothing where there is no number.
pub fn figure(value: impl Into<Option<f64>>, digits: usize) -> Value {
    let value = value.into().filter(|value| value.is_finite());
    value
        .and_then(|value| significant(value, digits).parse::<f64>().ok())
        .map_or(Value::Null, number)
}

/// A cell with so many decimals.
pub fn fixed(value: impl Into<Option<f64>>, decimals: usize) -> Value {
    let value = value.into().filter(|value| value.is_finite());
    value
        .and_then(|value| format!("{value:.decimals$}").parse().ok())
        .map_or(Value::Null, number)
}

/// A share in percent, to a tenth; nothing of none.
pub fn percent(count: u32, of: u32) -> Value {
    fixed(
        (of > 0).then(|| 100.0 * f64::from(count) / f64::from(of)),
        1,
    )
}

/// A whole number is written as one.
fn number(value: f64) -> Value {
    if value.fract() == 0.0 && value.abs() < 1e15 {
        Value::from(value as i64)
    } else {
        Value::from(value)
    }
}

/// 1234567 as 1,234,567.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Something that must hold, and whether it does.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bar {
    pub bar: String,
    pub limit: String,
    pub measured: String,
    pub met: bool,
}

impl Bar {
    /// A number that must not be greater than `limit`.
    pub fn at_most(bar: &str, limit: u64, measured: u64) -> Self {
        Self {
            bar: bar.into(),
            limit: format!("at most {}", grouped(limit)),
            measured: grouped(measured),
            met: measured <= limit,
        }
    }
}

pub fn bars<'a>(bars: impl IntoIterator<Item = &'a Bar>) -> Table {
    let mut table = Table::new("what must hold|limit|measured|");
    for Bar {
        bar,
        limit,
        measured,
        met,
    } in bars
    {
        let texts = [bar, limit, measured].map(|text| Value::from(text.as_str()));
        table.row(texts.into_iter().chain([Value::from(*met)]));
    }
    table
}

/// The page with each of its tables filled in.
pub fn filled(page: &str, tables: &Tables) -> Result<String> {
    let (mut text, mut lines) = (String::new(), page.lines());
    while let Some(line) = lines.next() {
        text += line;
        text.push('\n');
        let Some(marker) = line
            .strip_prefix("<!-- ")
            .and_then(|rest| rest.strip_suffix(" -->"))
        else {
            continue;
        };
        let (name, columns) = marker.split_once(": ").unwrap_or((marker, ""));
        let table = tables
            .get(name)
            .with_context(|| format!("no table is called {name}"))?;
        let columns: Result<Vec<usize>, _> = columns.split_whitespace().map(str::parse).collect();
        let mut columns = columns.with_context(|| line.to_owned())?;
        if columns.is_empty() {
            columns = (0..table.columns.len()).collect();
        }
        lines
            .find(|line| *line == "<!-- end -->")
            .with_context(|| format!("{name}: no end"))?;
        text += &format!("{}\n<!-- end -->\n", table.markdown(&columns));
    }
    Ok(text)
}

/// The figures of a topic: the tables of its page, and what they were made of.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures<T> {
    pub tables: Tables,
    #[serde(default)]
    pub detail: T,
}

/// Nothing beside the tables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct None {}

/// Reads the figures of a topic; none where nothing was measured.
pub fn load<T: DeserializeOwned + Default>(folder: &Path, topic: &str) -> Result<Figures<T>> {
    let path = folder.join(format!("{topic}.json"));
    if !path.is_file() {
        return Ok(Figures::default());
    }
    let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    serde_json::from_str(&text).with_context(|| path.display().to_string())
}

/// Writes the figures of a topic, and fills in its page if the folder has one.
pub fn write<T: Serialize>(folder: &Path, topic: &str, figures: &Figures<T>) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    // A line for each row and each object, so that a diff shows what changed.
    let json = serde_json::to_string(figures)?;
    let json = json.replace("],[", "],\n[").replace("},{", "},\n{");
    output::whole_text(&folder.join(format!("{topic}.json")), &(json + "\n"))?;
    let page = folder.join(format!("{topic}.md"));
    if page.is_file() {
        let text = fs::read_to_string(&page).with_context(|| page.display().to_string())?;
        output::whole_text(&page, &filled(&text, &figures.tables)?)?;
    }
    output::line(&page.display().to_string())
}

/// Prints all tables.
pub fn print(tables: &Tables) -> Result<()> {
    for (name, table) in tables {
        let columns: Vec<usize> = (0..table.columns.len()).collect();
        output::line(&format!("{name}\n{}\n", table.markdown(&columns)))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_filled_in_and_the_text_stays() {
        let mut table = Table::new("what|n|share|");
        table.row(["a".into(), 1234.into(), figure(0.012_34, 2), true.into()]);
        table.row(["b".into(), Value::Null, fixed(2.0, 1), false.into()]);
        let tables = Tables::from([("t".to_owned(), table)]);
        let page = "1\n<!-- t: 0 3 -->\nold\n<!-- end -->\n2\n<!-- t -->\n<!-- end -->\n";
        let new = filled(page, &tables).expect("tables");
        assert_eq!(
            new,
            "1\n<!-- t: 0 3 -->\n| what |  |\n|---|---:|\n| a | met |\n| b | **not met** |\n<!-- end -->\n2\n\
             <!-- t -->\n| what | n | share |  |\n|---|---:|---:|---:|\n| a | 1,234 | 0.012 | met |\n\
             | b | - | 2 | **not met** |\n<!-- end -->\n"
        );
        assert_eq!(filled(&new, &tables).expect("tables"), new);
        assert!(filled("<!-- other -->\n<!-- end -->\n", &tables).is_err());
        assert!(filled("<!-- t -->\n", &tables).is_err());
    }

    #[test]
    fn numbers_are_grouped() {
        assert_eq!(
            [0, 999, 1000, 1_234_567].map(grouped),
            ["0", "999", "1,000", "1,234,567"]
        );
    }
}
