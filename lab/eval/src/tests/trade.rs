//! The trade: that it runs, and that what the page's text says follows from the figures.

use super::from_root;
use crate::accuracy::Accuracy;
use crate::trade;
use crate::trade::plans;
use crate::trade::results::Row;
use serde_json::Value;

#[test]
fn the_least_run_measures_every_choice() {
    let mut trade = trade::measure(1, trade::results::Trade::default()).expect("a run");
    // Six windows of: four harmonics with four channel counts; three other settings in a grating,
    // one in a pure tone; four other methods in two scenes.
    assert_eq!(trade.rows.len(), 6 * (16 + 4 + 2 * 4));
    assert!(trade.rows.iter().all(|row| row.accuracy.windows > 0));
    // The fit is near the bound and the peak of a periodogram is not.
    let percent = |method: &str| {
        let row = trade
            .rows
            .iter()
            .find(|row| row.method == method && row.window_s == 1.0 && row.channels == 16);
        row.and_then(Row::rms_percent).expect("an error")
    };
    assert!(30.0 * percent("Ridgetone") < percent("periodogram"));
    trade
        .rows
        .iter_mut()
        .for_each(|row| row.instructions = Some(168_000));
    let svg = trade::picture(&trade);
    assert!(svg.contains("periodogram") && !svg.contains("NaN") && !svg.contains("inf"));
    // A window of 1 s and a millisecond of the fit; passes of 14,300 instructions.
    let figures = trade::figures(trade);
    let is_it = |row: &Vec<Value>| {
        row[11..] == [Value::from(1001), Value::from(168_000), Value::from(11.7)]
    };
    assert!(figures.tables["choices"].rows.iter().any(is_it));
}

/// Fewer channels and a single harmonic cost accuracy and save instructions.
#[test]
fn what_a_choice_costs_is_as_the_text_says() {
    let trade = trade::load(&from_root("docs/results")).expect("the data");
    for window_s in [0.2, 1.0] {
        let row = |harmonics, channels| {
            trade
                .ridgetone(window_s, 4, harmonics, channels)
                .expect("a row")
        };
        let (all, four, one) = (row(4, 16), row(4, 4), row(1, 16));
        for other in [four, one] {
            assert!(other.rms_percent() > all.rms_percent(), "{window_s} s");
            assert!(other.instructions < all.instructions, "{window_s} s");
        }
    }
}

/// What the text says of the scan plans.
#[test]
fn the_scan_plans_are_as_the_text_says() {
    let plans = trade::load(&from_root("docs/results"))
        .expect("the data")
        .plans;
    assert!(!plans.is_empty());
    let row = |plan: &str, window_s: f64| {
        let found = plans
            .iter()
            .find(|row| row.plan == plan && row.window_s == window_s);
        found.unwrap_or_else(|| panic!("{plan}, {window_s} s"))
    };
    let rms_hz = |row: &plans::Row| row.accuracy.error.expect("an error").rms_hz;
    let load = |row: &plans::Row| row.board.expect("measured on the register model").load;
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
            error.is_some_and(|error| (0.94..1.15).contains(&error.ratio)),
            "{one:?}"
        );
        // What the guide says.
        let most_s = match one.plan.as_str() {
            "paper" => 0.13,
            "hand" | "0x5555" | "texture" if one.window_s == 0.032 => 0.12,
            _ => 0.42,
        };
        assert!(
            one.latency_s()
                .is_some_and(|latency_s| latency_s <= one.window_s + most_s),
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
        assert!((-2.0..-1.2).contains(&slope), "{a:?}, {b:?}: {slope}");
    }
    for window_s in [0.032, 0.064, 0.128] {
        // From the most channels to the fewest: longer strides, and no more error.
        let fast: Vec<&plans::Row> = plans
            .iter()
            .filter(|row| row.window_s == window_s && row.plan != "paper")
            .collect();
        assert!(
            fast.len() >= 3
                && fast
                    .windows(2)
                    .all(|pair| pair[0].stride_s <= pair[1].stride_s),
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
    assert!(load(paper) < load(hand));
}
