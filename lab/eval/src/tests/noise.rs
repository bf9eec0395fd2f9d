//! Noise that is not white: that it runs, and that the page is what was measured.

use super::{from_root, read};
use crate::noise;

#[test]
fn the_page_is_what_its_data_give() {
    let rows = noise::load(&from_root("docs/results")).expect("the data");
    let other_seed = noise::load_other_seed(&from_root("docs/results")).expect("the data");
    // `cargo xtask noise --write docs/results` measures.
    assert!(
        noise::page(&rows, &other_seed, &read("docs/results/noise.md")).expect("a page")
            == read("docs/results/noise.md")
    );
}

/// The measured figures repeat: a few windows of each cell, on any number of cores.
#[test]
fn equal_seeds_give_equal_rows() {
    let rows = || noise::rows(2, 5, (None, None), &[]).expect("rows");
    let first = rows();
    assert!(first.len() > 50 && first == rows());
}

/// A renamed cell would lose its bars.
#[test]
fn each_row_of_the_data_has_its_cell() {
    let rows = noise::load(&from_root("docs/results")).expect("the data");
    assert!(!rows.is_empty() && rows.iter().all(|row| row.cell().is_some()));
}
