//! The cursor of the plots in a browser: values, differences, and a zoom that follows.

use super::browser::Browser;
use super::{LOOK, View, choose, open, press, save};
use crate::common;
use crate::{packets, recorded};
use serde_json::json;

/// Moves the mouse to a place in a plot, as shares of its width and height, and clicks or not.
fn point(browser: &mut Browser, card: &str, share: [f64; 2], clicks: bool) {
    let [x, y] = share;
    let place = browser.value(&format!(
        "(() => {{ const over = document.querySelector('#{card} .u-over'); over.scrollIntoView({{ block: 'center' }}); \
         const {{ left, top, width, height }} = over.getBoundingClientRect(); return [left + {x} * width, top + {y} * height]; }})()"
    ));
    let kinds: &[&str] = if clicks {
        &["mouseMoved", "mousePressed", "mouseReleased"]
    } else {
        &["mouseMoved"]
    };
    for kind in kinds {
        let button = if *kind == "mouseMoved" {
            "none"
        } else {
            "left"
        };
        let mouse =
            json!({"type": kind, "x": place[0], "y": place[1], "button": button, "clickCount": 1});
        browser.call("Input.dispatchMouseEvent", mouse);
    }
}

/// The lines that a plot's cursor says.
fn said_by(browser: &mut Browser, card: &str) -> Vec<String> {
    let text = browser.value(&format!(
        "(({{ hidden, textContent }}) => (hidden ? '' : textContent))(document.querySelector('#{card} .readout'))"
    ));
    let text = text.as_str().expect("a text").replace('−', "-");
    text.lines().map(str::to_owned).collect()
}

/// The first number of a text.
fn number(text: &str) -> f64 {
    let first = text.split(' ').find_map(|word| word.parse().ok());
    first.unwrap_or_else(|| panic!("no number: {text}"))
}

fn table(browser: &mut Browser, card: &str) -> Vec<Vec<f64>> {
    let (_, csv) = browser.offered(&save(card, "csv"));
    let csv = String::from_utf8(csv).expect("UTF-8");
    let cells = |line: &str| {
        let cells = line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN));
        cells.collect()
    };
    csv.lines().skip(1).map(cells).collect()
}

/// The row of a table whose first column is nearest to a value.
fn nearest(rows: &[Vec<f64>], value: f64) -> &[f64] {
    rows.iter()
        .min_by(|a, b| (a[0] - value).abs().total_cmp(&(b[0] - value).abs()))
        .expect("rows")
}

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn the_cursor_reads_every_plot_and_two_clicks_show_a_difference() {
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(3.2));
    let view = View::start(&["--file", common::text(&path), "--pace", "0"]);
    let mut browser = open(&view);
    browser.wait("document.querySelector('#fit .empty').hidden");

    // What is read is what the table of the plot has, to the resolution of the picture.
    let frames = table(&mut browser, "strips");
    let mut read = Vec::new();
    for (share, clicks) in [([0.4, 0.3], true), ([0.6, 0.31], true)] {
        point(&mut browser, "strips", share, clicks);
        let lines = said_by(&mut browser, "strips");
        let (t_s, channel) = lines[0].split_once(" s, taxel ").expect("a time");
        let (taxel, mv) = channel.split_once(": ").expect("a value");
        let (t_s, taxel, mv) = (number(t_s), number(taxel) as usize, number(mv));
        let row = nearest(&frames, t_s);
        assert!((row[0] - t_s).abs() < 0.003, "{lines:?}");
        assert!(
            (1e3 * row[1 + taxel] - mv).abs() < 0.051,
            "{lines:?} {row:?}"
        );
        read.push([row[0], 1e3 * row[1 + taxel]]);
    }
    let lines = said_by(&mut browser, "strips");
    let apart = lines
        .iter()
        .find(|line| line.starts_with("Δ "))
        .expect("a difference");
    let (apart_s, apart_mv) = apart.split_once("), ").expect("a difference");
    let (t_s, hz) = apart_s.split_once(" s (").expect("a rate");
    assert!(
        (number(t_s) - (read[1][0] - read[0][0])).abs() < 0.003,
        "{apart} {read:?}"
    );
    assert!(
        (number(hz) * (read[1][0] - read[0][0]) - 1.0).abs() < 0.01,
        "{apart}"
    );
    assert!(
        (number(apart_mv) - (read[1][1] - read[0][1])).abs() < 0.051,
        "{apart} {read:?}"
    );
    // It stays without the mouse; a third click clears it.
    point(&mut browser, "history", [0.5, 0.5], false);
    assert_eq!(said_by(&mut browser, "strips").concat(), *apart);
    point(&mut browser, "strips", [0.5, 0.5], true);
    assert_eq!(said_by(&mut browser, "strips").len(), 1);

    // With its sigma, where it has one: the plot's middle is beside a window.
    point(&mut browser, "history", [0.99, 0.5], false);
    let lines = said_by(&mut browser, "history");
    assert!(
        lines[0].contains(" ± ") && lines[0].ends_with(" Hz"),
        "{lines:?}"
    );
    choose(&mut browser, "spectrum-x", "log");
    let bins = table(&mut browser, "spectrum");
    point(&mut browser, "spectrum", [0.5, 0.5], false);
    let lines = said_by(&mut browser, "spectrum");
    let (hz, db) = lines[0].split_once(": ").expect("a value");
    let bin = nearest(&bins, number(hz));
    assert!((bin[0] / number(hz) - 1.0).abs() < 0.02, "{lines:?}");
    assert!(
        bin[1..]
            .iter()
            .any(|value| (value - number(db)).abs() < 0.6),
        "{lines:?} {bin:?}"
    );
    point(&mut browser, "fit", [0.5, 0.9], false);
    let lines = said_by(&mut browser, "fit");
    assert!(
        lines[0].contains("residual: ") && lines[0].ends_with(" mV"),
        "{lines:?}"
    );

    // By keys alone.
    browser.value("document.querySelector('#fit .plot').focus()");
    for _ in 0..2 {
        press(&mut browser, "Enter");
        browser.call(
            "Input.dispatchKeyEvent",
            json!({"type": "keyDown", "key": "ArrowRight", "modifiers": 8}),
        );
    }
    let lines = said_by(&mut browser, "fit");
    assert!(
        lines.len() == 2 && lines[1].starts_with("Δ 0.00"),
        "{lines:?}"
    );
    press(&mut browser, "Escape");
    assert_eq!(said_by(&mut browser, "fit").len(), 1);
    assert_eq!(browser.errors(), Vec::<String>::new());
}

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn a_zoomed_plot_follows_after_resume_and_zero_shows_all() {
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(f64::INFINITY));
    let view = View::start(&["--file", common::text(&path), "--pace", "0.25"]);
    let mut browser = Browser::start(LOOK);
    browser.open(&view.url);
    let now = "parseFloat(document.getElementById('source')?.textContent.split(', ').at(-1))";
    browser.wait(&format!("{now} > 2.2"));
    browser.value("document.querySelector('#strips .plot').focus()");
    press(&mut browser, "+");
    browser.wait("document.body.classList.contains('paused')");
    let ends = |browser: &mut Browser| {
        let rows = table(browser, "strips");
        [rows[0][0], rows[rows.len() - 1][0]]
    };
    let [from_s, until_s] = ends(&mut browser);
    browser.value("document.getElementById('pause').click()");
    browser.wait(&format!("{now} > {}", until_s + 1.2));
    let [later_s, end_s] = ends(&mut browser);
    assert!(
        ((end_s - later_s) - (until_s - from_s)).abs() < 0.02 && later_s > from_s + 0.3,
        "{from_s} to {until_s}, then {later_s} to {end_s}"
    );
    press(&mut browser, "0");
    let [all_s, end_s] = ends(&mut browser);
    assert!(
        end_s - all_s > 1.5 * (until_s - from_s),
        "{all_s} to {end_s}"
    );
    assert_eq!(browser.errors(), Vec::<String>::new());
}
