//! Pages in Markdown: a person writes the text, a run fills in the tables.
//!
//! A table stands between the lines `<!-- table: NAME -->` and `<!-- end -->`.

use anyhow::{Context, Result};
use ridgetone_host::output;
use serde::de::DeserializeOwned;
use std::fs;
use std::path::Path;

/// A table in Markdown, figures to the right.
pub struct Table(String);

impl Table {
    /// With headings that `|` separates, the first `left` of them over text.
    pub fn new(left: usize, headings: &str) -> Self {
        let headings: Vec<&str> = headings.split('|').collect();
        let rule = (0..headings.len()).map(|column| if column < left { "---" } else { "---:" });
        Self(format!(
            "| {} |\n|{}|\n",
            headings.join(" | "),
            rule.collect::<Vec<_>>().join("|")
        ))
    }

    pub fn row(&mut self, cells: &[String]) {
        self.0 += &format!("| {} |\n", cells.join(" | "));
    }

    /// The table, without the end of its last line.
    pub fn end(self) -> String {
        self.0.trim_end().to_owned()
    }
}

const START: &str = "<!-- table: ";
const START_END: &str = " -->\n";
const END: &str = "\n<!-- end -->";

/// The page with every table replaced by what `table` gives for its name.
pub fn filled(page: &str, table: impl Fn(&str) -> Option<String>) -> Result<String> {
    let mut parts = page.split(START);
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = part
            .split_once(START_END)
            .context("a table without a name")?;
        let (_, rest) = rest
            .split_once(END)
            .with_context(|| format!("table {name}: no end"))?;
        let table = table(name).with_context(|| format!("no table is called {name}"))?;
        text += &format!("{START}{name}{START_END}{table}{END}{rest}");
    }
    Ok(text)
}

/// A table of a page as it is.
pub fn table_of<'a>(page: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = page.split_once(&format!("{START}{name}{START_END}"))?;
    rest.split_once(END).map(|(table, _)| table)
}

/// The data of a page, from their JSON file.
pub fn load<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let text = fs::read_to_string(path).with_context(|| path.display().to_string())?;
    serde_json::from_str(&text).with_context(|| path.display().to_string())
}

/// The data of a page from a folder; nothing where nothing was measured.
pub fn load_measured<T: DeserializeOwned + Default>(folder: &Path, data: &str) -> Result<T> {
    let path = folder.join(data);
    if path.is_file() {
        load(&path)
    } else {
        Ok(T::default())
    }
}

/// Fills in a page of a folder, and says which.
pub fn render(
    folder: &Path,
    page: &str,
    filled: impl FnOnce(&str) -> Result<String>,
) -> Result<()> {
    let path = folder.join(page);
    let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    output::whole_text(&path, &filled(&text)?)?;
    output::line(&path.display().to_string())
}

/// A figure of `decimals` decimals, or a dash where there is none.
pub fn figure(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{value:.decimals$}"))
}

/// A ratio of error and bound: two decimals near the bound, fewer far from it.
pub fn over_bound(ratio: f64) -> String {
    if ratio < 10.0 {
        format!("{ratio:.2}")
    } else {
        grouped(ratio.round() as u64)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_table_is_replaced_and_the_text_stays() {
        let table = |name: &str| (name != "c").then(|| name.to_uppercase());
        let page = "1\n<!-- table: a -->\nold\n<!-- end -->\n2 <!-- a comment -->\n<!-- table: b -->\n\n<!-- end -->\n3";
        let new = "1\n<!-- table: a -->\nA\n<!-- end -->\n2 <!-- a comment -->\n<!-- table: b -->\nB\n<!-- end -->\n3";
        assert_eq!(filled(page, table).expect("tables"), new);
        assert_eq!(filled(new, table).expect("tables"), new);
        assert!(filled("<!-- table: c -->\n\n<!-- end -->", table).is_err());
        assert!(filled("<!-- table: a -->\n", table).is_err());
    }

    #[test]
    fn numbers_are_grouped() {
        assert_eq!(
            [0, 999, 1000, 1_234_567].map(grouped),
            ["0", "999", "1,000", "1,234,567"]
        );
    }
}
