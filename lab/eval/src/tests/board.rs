//! The boards in figures: those of the images, and the README's are the page's.

use super::pages::tables;
use super::read;
use crate::board;

/// Figures may differ by this share, or by this much: compilers differ a little.
const SHARE: f64 = 0.05;
const LEAST: f64 = 0.3;

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_figures_are_those_of_the_images() {
    let fresh = board::measure().expect("a measurement");
    let shipped = tables("boards");
    for name in ["boards", "tasks"] {
        let (fresh, shipped) = (&fresh[name], &shipped[name]);
        assert_eq!(
            (&fresh.columns, fresh.rows.len()),
            (&shipped.columns, shipped.rows.len())
        );
        let cells = shipped
            .rows
            .iter()
            .flatten()
            .zip(fresh.rows.iter().flatten());
        for (page, fresh) in cells {
            let is_close = match (page.as_f64(), fresh.as_f64()) {
                (Some(a), Some(b)) => (a - b).abs() <= LEAST.max(SHARE * b.abs()),
                _ => page == fresh,
            };
            assert!(is_close, "{page}, now {fresh}: cargo xtask board --write");
        }
    }
}

/// The README's load is that of the slower of the two boards.
#[test]
fn the_readme_has_the_pages_load() {
    let (figures, readme) = (tables("boards"), read("README.md"));
    let load = |phase: &str| {
        let name = format!("load {phase}, 5064 conversions a second, %");
        let row = figures["boards"].rows.iter().find(|row| row[0] == *name);
        let row = row.unwrap_or_else(|| panic!("no row {name}"));
        let loads = row[1..].iter().filter_map(|cell| cell.as_f64());
        loads.fold(0.0, f64::max).round()
    };
    let (rest, sliding) = (load("at rest"), load("sliding, with fits"));
    let sentence =
        format!("busy {rest} % of the time at rest and {sliding} % while the finger slides");
    assert!(readme.contains(&sentence), "README.md lacks: {sentence}");
}
