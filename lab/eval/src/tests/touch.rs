//! Touches against their truth: that it runs, and that the page is what was measured.

use super::{from_root, read};
use crate::page::table_of;
use crate::touch;

#[test]
fn the_page_is_what_its_data_give() {
    let data = touch::load(&from_root("docs/results")).expect("the data");
    // `cargo xtask touch --write docs/results` measures.
    assert!(
        touch::page(&data, &read("docs/results/touch.md")).expect("a page")
            == read("docs/results/touch.md")
    );
}

/// Each row of today's has its like among those of before.
#[test]
fn both_detectors_have_the_same_rows() {
    let page = read("docs/results/touch.md");
    let names = |table: &str| -> Vec<String> {
        let rows = table_of(&page, table).expect("a table").lines().skip(2);
        rows.map(|row| row.split(" | ").next().expect("a name").to_owned())
            .collect()
    };
    for group in [
        "tones",
        "lengths",
        "early",
        "contact",
        "lift",
        "disturbances",
    ] {
        assert_eq!(names(group), names(&format!("before_{group}")));
    }
}

/// The measured figures repeat: a few traces of each cell of a group, on any number of cores.
#[test]
fn equal_seeds_give_equal_rows() {
    let rows = || touch::rows(2, 5, Some("lift")).expect("rows");
    let first = rows();
    assert!(first.len() > 5 && first == rows());
}
