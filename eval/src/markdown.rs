//! Markdown of a run: tables, and a template whose gaps it fills.

use anyhow::{Context, Result};

/// A table in Markdown, figures to the right.
pub struct Table(String);

impl Table {
    /// With these headings, the first `left` of them over text.
    pub fn new(left: usize, headings: &[&str]) -> Self {
        let rule = (0..headings.len()).map(|column| if column < left { "---" } else { "---:" });
        Self(format!("| {} |\n|{}|\n", headings.join(" | "), rule.collect::<Vec<_>>().join("|")))
    }

    /// One more row.
    pub fn row(&mut self, cells: &[String]) {
        self.0 += &format!("| {} |\n", cells.join(" | "));
    }

    /// The table, without the line's end.
    pub fn end(self) -> String {
        self.0.trim_end().to_owned()
    }
}

/// A template with every `{{name}}` replaced by what `fill` gives for the name.
///
/// # Errors
/// Those of `fill`; a `{{` without its `}}`.
pub fn filled(template: &str, fill: impl Fn(&str) -> Result<String>) -> Result<String> {
    let mut parts = template.split("{{");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = part.split_once("}}").context("the template has a {{ without its }}")?;
        text += &fill(name)?;
        text += rest;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_gap_is_filled() {
        let fill = |name: &str| Ok(name.to_uppercase());
        assert_eq!(filled("a {{b}} c {{d}}{{e}}\n", fill).expect("text"), "a B c DE\n");
        assert!(filled("{{b", fill).is_err());
    }
}
