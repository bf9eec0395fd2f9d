//! The trade: that it runs, and that the page is what was measured.

use super::{from_root, read};
use crate::noise;
use crate::page::load;
use crate::trade::results::Trade;
use crate::trade::{self, Windows};

#[test]
fn the_least_run_measures_every_choice_and_every_bar() {
    let mut trade = trade::measure((1, Windows { accuracy: 2, noise: 2, detection: 1 }), None).expect("a run");
    // Six windows of: four harmonics with four channel counts; three other settings in a grating, one in a pure tone;
    // nine baselines in two scenes.
    assert_eq!(trade.rows.len(), 6 * (16 + 4 + 2 * 9));
    assert!(trade.rows.iter().all(|row| row.accuracy.windows > 0));
    // Seven lines of Table 2 have a cycle in 0.2 s, all ten in the other five windows; three noises.
    assert_eq!(trade.bars.cells.len(), 3 * (7 + 5 * 10));
    assert_eq!((trade.all_bars().len(), trade.chip.len()), (6, 0));
    // Of two windows in a setting, too: the fit is near the bound and the peak of a periodogram is not.
    let percent = |method: &str| {
        let row = trade.rows.iter().find(|row| row.method == method && row.window_s == 1.0 && row.channels == 16);
        row.and_then(|row| row.accuracy.error).expect("an error").rms_percent
    };
    assert!(30.0 * percent("Ridgetone") < percent("periodogram"));

    trade.rows.iter_mut().for_each(|row| row.instructions = Some(168_000));
    let noise = noise::rows(2, 5, (Some("sigma"), None), &[]).expect("rows");
    let (page, svg) = (trade::page(&trade, &noise).expect("a page"), trade::chart::draw(&trade, &noise));
    assert!(svg.contains("pink") && !trade::chart::draw(&trade, &[]).contains("pink"));
    assert!(page.contains("| 1001.00 | 168,000 | 11.7 |"), "{page}");
    for text in [page, svg] {
        assert!(!text.contains("NaN") && !text.contains("inf "), "{text}");
    }
}

#[test]
fn the_page_and_its_picture_are_what_their_data_give() {
    let trade: Trade = load(&from_root("docs/trade.json")).expect("the data");
    // `cargo xtask bench --render` fills in the page again, `cargo xtask bench --write` measures.
    let noise = noise::load(&from_root("docs")).expect("the data");
    assert!(
        trade::page(&trade, &noise).expect("a page") == read("docs/trade.md"),
        "docs/trade.md is not what its data give"
    );
    assert!(trade::chart::draw(&trade, &noise) == read("docs/trade.svg"), "docs/trade.svg is not what its data give");
    // The text says why of each bar that is not met.
    let explained = [
        "RMS error over the bound",
        "95 % intervals",
        "tones found",
        "fit, ",
        "frames, contact",
        "the same on average",
    ];
    let not_met: Vec<_> = trade.all_bars().into_iter().filter(|bar| !bar.met).map(|bar| bar.bar).collect();
    let is_explained = |bar: &String| explained.iter().any(|start| bar.starts_with(start));
    assert!(not_met.iter().all(is_explained), "{not_met:?}");
    // The text says that fewer channels and a single harmonic cost accuracy and save instructions.
    for window_s in [0.2, 1.0] {
        let row = |harmonics, channels| trade.ridgetone(window_s, 4, harmonics, channels).expect("a row");
        let (all, four, one) = (row(4, 16), row(4, 4), row(1, 16));
        assert!([four, one].iter().all(|row| row.rms_percent() > all.rms_percent()), "{window_s} s");
        assert!([four, one].iter().all(|row| row.instructions < all.instructions), "{window_s} s");
    }
}
