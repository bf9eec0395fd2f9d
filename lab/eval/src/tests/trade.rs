//! The trade: that it runs, and that the page is what was measured.

use super::{from_root, read};
use crate::accuracy::Accuracy;
use crate::noise;
use crate::page::load;
use crate::setting::{Length, Setting};
use crate::trade::plans::Row;
use crate::trade::results::Trade;
use crate::trade::{self, Windows};

#[test]
fn the_least_run_measures_every_choice_and_every_bar() {
    let mut trade = trade::measure(
        (
            1,
            Windows {
                accuracy: 2,
                noise: 2,
                detection: 1,
            },
        ),
        None,
    )
    .expect("a run");
    // Six windows of: four harmonics with four channel counts; three other settings in a grating,
    // one in a pure tone; nine baselines in two scenes.
    assert_eq!(trade.rows.len(), 6 * (16 + 4 + 2 * 9));
    assert!(trade.rows.iter().all(|row| row.accuracy.windows > 0));
    // Seven lines of Table 2 have a cycle in 0.2 s, all ten in the other five windows; three
    // noises.
    assert_eq!(trade.bars.cells.len(), 3 * (7 + 5 * 10));
    assert_eq!((trade.all_bars().len(), trade.chip.len()), (7, 0));
    // Of two windows in a setting, too: the fit is near the bound and the peak of a periodogram is
    // not.
    let percent = |method: &str| {
        let row = trade
            .rows
            .iter()
            .find(|row| row.method == method && row.window_s == 1.0 && row.channels == 16);
        row.and_then(|row| row.accuracy.error)
            .expect("an error")
            .rms_percent
    };
    assert!(30.0 * percent("Ridgetone") < percent("periodogram"));

    trade
        .rows
        .iter_mut()
        .for_each(|row| row.instructions = Some(168_000));
    let noise = noise::rows(2, 5, (Some("sigma"), None), &[]).expect("rows");
    let (page, svg) = (
        trade::page(&trade, &noise, &[]).expect("a page"),
        trade::chart::draw(&trade, &noise),
    );
    assert!(svg.contains("pink") && !trade::chart::draw(&trade, &[]).contains("pink"));
    assert!(page.contains("| 1001.00 | 168,000 | 11.7 |"), "{page}");
    for text in [page, svg] {
        assert!(!text.contains("NaN") && !text.contains("inf "), "{text}");
    }
}

#[test]
fn the_page_and_its_picture_are_what_their_data_give() {
    let trade: Trade = load(&from_root("docs/results/trade.json")).expect("the data");
    // `cargo xtask bench --render` fills in the page again, `cargo xtask bench --write` measures.
    let noise = noise::load(&from_root("docs/results")).expect("the data");
    let plans = trade::plans::load(&from_root("docs/results")).expect("the data");
    assert!(
        trade::page(&trade, &noise, &plans).expect("a page") == read("docs/results/trade.md"),
        "docs/results/trade.md is not what its data give"
    );
    assert!(
        trade::chart::draw(&trade, &noise) == read("docs/results/trade.svg"),
        "docs/results/trade.svg is not what its data give"
    );
    // The text says why of each bar that is not met.
    let explained = [
        "RMS error over the bound",
        "fit, ",
        "frames, contact",
        "the same on average",
    ];
    let not_met: Vec<_> = trade
        .all_bars()
        .into_iter()
        .filter(|bar| !bar.met)
        .map(|bar| bar.bar)
        .collect();
    let is_explained = |bar: &String| explained.iter().any(|start| bar.starts_with(start));
    assert!(not_met.iter().all(is_explained), "{not_met:?}");
    // The text says where the error is above its bar.
    let above = || trade.bars.cells.iter().filter(|cell| cell.is_above());
    assert!(above().all(|cell| cell.setting.snr_db == 10.0));
    let is_short =
        |setting: Setting| matches!(setting.length, Length::Seconds(window_s) if window_s <= 0.6);
    assert!(above().all(|cell| cell.setting.cycles() < 1.5 || is_short(cell.setting)));
    // The text says that fewer channels and a single harmonic cost accuracy and save instructions.
    for window_s in [0.2, 1.0] {
        let row = |harmonics, channels| {
            trade
                .ridgetone(window_s, 4, harmonics, channels)
                .expect("a row")
        };
        let (all, four, one) = (row(4, 16), row(4, 4), row(1, 16));
        assert!(
            [four, one]
                .iter()
                .all(|row| row.rms_percent() > all.rms_percent()),
            "{window_s} s"
        );
        assert!(
            [four, one]
                .iter()
                .all(|row| row.instructions < all.instructions),
            "{window_s} s"
        );
    }
}

/// What the text says of the scan plans.
#[test]
fn the_scan_plans_are_as_the_text_says() {
    let plans = trade::plans::load(&from_root("docs/results")).expect("the data");
    let row = |plan: &str, window_s: f64| {
        let found = plans
            .iter()
            .find(|row| row.plan == plan && row.window_s == window_s);
        found.unwrap_or_else(|| panic!("{plan}, {window_s} s"))
    };
    let rms_hz = |row: &Row| row.accuracy.error.expect("an error").rms_hz;
    let load = |row: &Row| row.board.expect("measured on the register model").load;
    for one in &plans {
        let Accuracy {
            windows,
            good,
            error,
            ..
        } = one.accuracy;
        assert!(windows == 1000 && 10 * good >= 9 * windows, "{one:?}");
        // The standard error of a ratio near one is 2 % of a thousand windows where the control
        // variate fails.
        assert!(
            error.is_some_and(|error| (0.94..1.1).contains(&error.ratio)),
            "{one:?}"
        );
        assert!(
            load(one) < 0.9
                && one
                    .latency_s()
                    .is_some_and(|latency_s| latency_s < one.window_s + 0.1),
            "{one:?}"
        );
    }
    // Longer windows have less error in each plan: twice the length less than half.
    for (a, b) in plans
        .iter()
        .zip(&plans[1..])
        .filter(|(a, b)| a.plan == b.plan)
    {
        let slope = (rms_hz(b) / rms_hz(a)).ln() / (b.window_s / a.window_s).ln();
        assert!((-1.8..-1.2).contains(&slope), "{a:?}, {b:?}: {slope}");
    }
    for window_s in [0.032, 0.064, 0.128] {
        // From the most channels to the fewest: more load, and no more error.
        let fast: Vec<&Row> = plans
            .iter()
            .filter(|row| row.window_s == window_s && row.plan != "paper")
            .collect();
        assert!(
            fast.len() >= 3 && fast.windows(2).all(|pair| load(pair[0]) < load(pair[1])),
            "{window_s} s"
        );
        assert!(
            fast.iter()
                .all(|row| (1.0..1.55).contains(&(rms_hz(fast[0]) / rms_hz(row)))),
            "{window_s} s"
        );
    }
    let [paper, hand] = ["paper", "hand"].map(|plan| row(plan, 0.128));
    assert!((0.8..1.1).contains(&(rms_hz(paper) / rms_hz(hand))));
    assert!(
        (0.575..0.585).contains(&(load(paper) / load(hand))),
        "{}",
        load(paper) / load(hand)
    );
    for plan in ["hand", "0x5555", "texture", "vibration"] {
        assert!(
            load(row(plan, 0.032)) > 0.99 * load(row(plan, 0.064)),
            "{plan}"
        );
    }
    let idle = |plan| 1.0 - load(row(plan, 0.032));
    assert!((0.35..0.5).contains(&(idle("single") / idle("hand"))));
}
