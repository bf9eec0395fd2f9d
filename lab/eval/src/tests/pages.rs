//! That the pages and pictures in `docs/results` are what their figures give.

use super::{from_root, read};
use crate::page::{self, Tables, filled};
use crate::trade::scenes;
use crate::{noise, trade};
use std::path::PathBuf;

/// Topics, each a page and its figures.
const TOPICS: [&str; 4] = ["faults", "noise", "scene", "trade"];

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
    let trade = trade::figures(trade::load(&folder).expect("the data"));
    let scene = scenes::figures(scenes::load(&folder).expect("the data"));
    let noise = noise::figures(noise::load(&folder).expect("rows"));
    for (topic, expected) in [
        ("trade", &trade.tables),
        ("scene", &scene.tables),
        ("noise", &noise.tables),
    ] {
        assert!(
            tables(topic) == *expected,
            "{topic}: run `cargo run -p ridgetone-eval -- pages`"
        );
    }
    for (name, expected) in [
        ("trade", trade::picture(&trade.detail)),
        ("noise", noise::picture(&noise.detail)),
    ] {
        let path = format!("docs/results/{name}.svg");
        assert!(
            read(&path) == expected,
            "{path}: run `cargo run -p ridgetone-eval -- pages`"
        );
    }
}
