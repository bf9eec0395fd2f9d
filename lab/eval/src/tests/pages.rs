//! That the pages and pictures in `docs/results` are what their figures give.

use super::{from_root, read};
use crate::page::{self, Figures, Tables, filled};
use crate::reproduce::results::Reproduction;
use crate::reproduce::{self, okamoto};
use crate::trade::scenes;
use crate::{noise, touch, trade};
use serde_json::Value;
use std::path::PathBuf;

/// Topics with bars, each a page and its figures.
const TOPICS: [&str; 7] = [
    "boards",
    "faults",
    "noise",
    "papers-runs",
    "scene",
    "touch",
    "trade",
];

/// Topics that have figures and no bars.
const WITHOUT_BARS: [&str; 2] = ["live", "papers"];

fn results() -> PathBuf {
    from_root("docs/results")
}

/// The tables of a topic as its JSON has them.
pub fn tables(topic: &str) -> Tables {
    page::load::<page::None>(&results(), topic)
        .expect("the figures")
        .tables
}

#[test]
fn every_page_is_what_its_figures_give() {
    for topic in TOPICS.into_iter().chain(WITHOUT_BARS) {
        let path = format!("docs/results/{topic}.md");
        let text = read(&path);
        let expected = filled(&text, &tables(topic)).expect("tables");
        assert!(
            text == expected,
            "{path}: run `cargo run -p ridgetone-eval -- pages`"
        );
        let has_bars = text
            .lines()
            .any(|line| line.starts_with("<!-- ") && line.contains("bars"));
        assert!(
            has_bars || WITHOUT_BARS.contains(&topic),
            "{path} does not say what must hold"
        );
        assert!(
            text.lines().count() <= 100,
            "{path} is longer than a screen"
        );
    }
}

#[test]
fn the_tables_and_pictures_are_what_was_measured() {
    let folder = results();
    let trade = trade::figures(trade::load(&folder).expect("the data"));
    let scene = scenes::figures(scenes::load(&folder).expect("the data"));
    let noise = noise::figures(noise::load(&folder).expect("rows"));
    let touch = touch::figures(touch::load(&folder).expect("rows"));
    let papers: Figures<Reproduction> = page::load(&folder, reproduce::TOPIC).expect("figures");
    let oddo = reproduce::figures(papers.detail.clone(), papers.clone());
    for (topic, expected) in [
        ("trade", &trade.tables),
        ("scene", &scene.tables),
        ("noise", &noise.tables),
        ("touch", &touch.tables),
        ("papers-runs", &oddo.tables),
    ] {
        assert!(
            tables(topic) == *expected,
            "{topic}: run `cargo run -p ridgetone-eval -- pages`"
        );
    }
    let wavelengths = &papers.tables["okamoto_wavelengths"];
    for (name, expected) in [
        ("trade", trade::picture(&trade.detail)),
        ("noise", noise::picture(&noise.detail)),
        ("papers", reproduce::picture(&papers.detail)),
        ("papers-wavelengths", okamoto::tables::picture(wavelengths)),
    ] {
        let path = format!("docs/results/{name}.svg");
        assert!(
            read(&path) == expected,
            "{path}: run `cargo run -p ridgetone-eval -- pages`"
        );
    }
}

/// Every topic with bars that are not met is on the README, with how many they are.
#[test]
fn the_readme_counts_what_is_not_met() {
    let readme = read("README.md");
    for topic in TOPICS {
        let tables = tables(topic);
        let bars = tables
            .iter()
            .filter(|(name, _)| *name == "bars" || name.ends_with("_bars"));
        let verdicts: Vec<bool> = bars
            .flat_map(|(_, table)| &table.rows)
            .map(|row| row.iter().find_map(Value::as_bool).expect("a verdict"))
            .collect();
        let unmet = verdicts.iter().filter(|is_met| !**is_met).count();
        assert!(!verdicts.is_empty(), "{topic} has no bars");
        let counted = format!("[{topic}](docs/results/{topic}.md#what-must-hold)");
        if unmet > 0 {
            let counted = format!("{counted} {unmet} of {} ", verdicts.len());
            assert!(readme.contains(&counted), "README.md lacks: {counted}");
        } else {
            assert!(
                !readme.contains(&counted),
                "README.md: all of {topic} is met"
            );
        }
    }
}
