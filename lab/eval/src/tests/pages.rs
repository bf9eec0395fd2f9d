//! That the pages and pictures in `docs/results` are what their figures give.

use super::{from_root, read};
use crate::page::{self, Figures, Tables, filled};
use crate::reproduce::results::Reproduction;
use crate::reproduce::{self, okamoto};
use crate::touch;
use std::path::PathBuf;

/// Topics, each a page and its figures.
const TOPICS: [&str; 5] = ["boards", "faults", "papers", "papers-runs", "touch"];

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
    for topic in TOPICS {
        let path = format!("docs/results/{topic}.md");
        let text = read(&path);
        let expected = filled(&text, &tables(topic)).expect("tables");
        assert!(
            text == expected,
            "{path}: run `cargo run -p ridgetone-eval -- pages`"
        );
    }
}

#[test]
fn the_tables_and_pictures_are_what_was_measured() {
    let folder = results();
    let touch = touch::figures(touch::load(&folder).expect("rows"));
    let papers: Figures<Reproduction> = page::load(&folder, reproduce::TOPIC).expect("figures");
    let oddo = reproduce::figures(papers.detail.clone(), papers.clone());
    for (topic, expected) in [("touch", &touch.tables), ("papers-runs", &oddo.tables)] {
        assert!(
            tables(topic) == *expected,
            "{topic}: run `cargo run -p ridgetone-eval -- pages`"
        );
    }
    let wavelengths = &papers.tables["okamoto_wavelengths"];
    for (name, expected) in [
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
