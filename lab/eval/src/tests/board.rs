//! The page's figures of the boards are those of the images.

use super::pages::tables;
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
