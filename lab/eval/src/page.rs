//! Tables of figures, as JSON and in the terminal.

use anyhow::{Context, Result};
use ridgetone_host::output;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Table of figures; each cell is a number, a text or empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    pub columns: Vec<String>,
    pub rows: Vec<Vec<Value>>,
}

pub type Tables = BTreeMap<String, Table>;

impl Table {
    /// Creates a table with headings separated by `|`.
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

    /// Formats the table in Markdown, with numbers right-aligned.
    fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let is_text = |column: usize| {
            self.rows
                .iter()
                .any(|row| row.get(column).is_some_and(Value::is_string))
        };
        let rules: Vec<&str> = (0..self.columns.len())
            .map(|column| if is_text(column) { "---" } else { "---:" })
            .collect();
        let mut text = line(self.columns.clone()) + &format!("|{}|\n", rules.join("|"));
        for row in &self.rows {
            text += &line(row.iter().map(shown).collect());
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

/// Cell with `decimals` decimals.
pub fn fixed(value: impl Into<Option<f64>>, decimals: usize) -> Value {
    let value = value.into().filter(|value| value.is_finite());
    value
        .and_then(|value| format!("{value:.decimals$}").parse().ok())
        .map_or(Value::Null, number)
}

/// Writes a whole number as an integer.
fn number(value: f64) -> Value {
    if value.fract() == 0.0 && value.abs() < 1e15 {
        Value::from(value as i64)
    } else {
        Value::from(value)
    }
}

/// Groups digits: 1234567 becomes 1,234,567.
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

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Requirement {
    pub requirement: String,
    pub limit: String,
    pub measured: String,
    pub met: bool,
}

impl Requirement {
    /// Requires that a number is at most `limit`.
    pub fn at_most(requirement: &str, limit: u64, measured: u64) -> Self {
        Self {
            requirement: requirement.into(),
            limit: format!("at most {}", grouped(limit)),
            measured: grouped(measured),
            met: measured <= limit,
        }
    }
}

pub fn requirements<'a>(requirements: impl IntoIterator<Item = &'a Requirement>) -> Table {
    let mut table = Table::new("what must hold|limit|measured|");
    for Requirement {
        requirement,
        limit,
        measured,
        met,
    } in requirements
    {
        let texts = [requirement, limit, measured].map(|text| Value::from(text.as_str()));
        table.row(texts.into_iter().chain([Value::from(*met)]));
    }
    table
}

/// Figures of a topic: the tables on its page, and details that reproduce them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures<T> {
    pub tables: Tables,
    #[serde(default)]
    pub detail: T,
}

/// No details in addition to the tables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct None {}

/// Reads the figures of a topic. Returns empty figures if nothing was measured.
pub fn load<T: DeserializeOwned + Default>(folder: &Path, topic: &str) -> Result<Figures<T>> {
    let path = folder.join(format!("{topic}.json"));
    if !path.is_file() {
        return Ok(Figures::default());
    }
    let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    serde_json::from_str(&text).with_context(|| path.display().to_string())
}

/// Writes the figures of a topic, from which `lab/pages.py` fills its page.
pub fn write<T: Serialize>(folder: &Path, topic: &str, figures: &Figures<T>) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    // One line per row and object, for readable diffs.
    let json = serde_json::to_string(figures)?;
    let json = json.replace("],[", "],\n[").replace("},{", "},\n{");
    let path = folder.join(format!("{topic}.json"));
    output::whole_text(&path, &(json + "\n"))?;
    output::line(&path.display().to_string())
}

pub fn print(tables: &Tables) -> Result<()> {
    for (name, table) in tables {
        output::line(&format!("{name}\n{}\n", table.markdown()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped() {
        assert_eq!(
            [0, 999, 1000, 1_234_567].map(grouped),
            ["0", "999", "1,000", "1,234,567"]
        );
    }
}
