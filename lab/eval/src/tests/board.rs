//! The boards in figures: the page is that of the images, and the README's figures are the page's.

use super::read;
use crate::board;

/// Figures may differ by this share, or by this much: compilers differ a little.
const SHARE: f64 = 0.05;
const LEAST: f64 = 0.3;

/// Whether two words are the same, or figures that are close.
fn is_close(page: &str, fresh: &str) -> bool {
    let number = |word: &str| word.replace(',', "").parse::<f64>().ok();
    match (number(page), number(fresh)) {
        (Some(a), Some(b)) => (a - b).abs() <= LEAST.max(SHARE * b.abs()),
        _ => page == fresh,
    }
}

#[test]
fn figures_are_close_or_they_are_not() {
    for (a, b, close) in [
        ("13.5", "13.7", true),
        ("13.5", "14.3", false),
        ("0", "0", true),
        ("0", "1", false),
        ("25330", "25,000", true),
        ("drdy", "line", false),
    ] {
        assert_eq!(is_close(a, b), close, "{a} {b}");
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_page_is_that_of_the_images() {
    let page = read("docs/results/board.md");
    let fresh = board::page(&board::measure().expect("a measurement"), &page).expect("a page");
    let differs = |(page, fresh): &(&str, &str)| {
        let (page, fresh): (Vec<&str>, Vec<&str>) =
            (page.split(' ').collect(), fresh.split(' ').collect());
        page.len() != fresh.len()
            || !page
                .iter()
                .zip(fresh)
                .all(|(page, fresh)| is_close(page, fresh))
    };
    let changed: Vec<_> = page.lines().zip(fresh.lines()).filter(differs).collect();
    let is_as_long = page.lines().count() == fresh.lines().count();
    assert!(
        is_as_long && changed.is_empty(),
        "cargo xtask board --write: {changed:#?}"
    );
}

/// The README's load is that of the slower of the two boards.
#[test]
fn the_readme_has_the_pages_load() {
    let (page, readme) = (read("docs/results/board.md"), read("README.md"));
    let load = |phase: &str| {
        let row = page.lines().find_map(|line| {
            line.strip_prefix(&format!("| {phase}, 5064 conversions a second | "))
        });
        let row = row.unwrap_or_else(|| panic!("no row {phase}"));
        row.trim_end_matches(" |")
            .split(" | ")
            .map(|cell| cell.parse::<f64>().expect("a figure"))
            .fold(0.0, f64::max)
    };
    let (rest, sliding) = (load("at rest").round(), load("sliding, with fits").round());
    let sentence =
        format!("busy {rest} % of the time at rest and {sliding} % while the finger slides");
    assert!(readme.contains(&sentence), "README.md lacks: {sentence}");
}
