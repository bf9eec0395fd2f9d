//! Texts that stand where there is room for them, in a browser.

use super::{View, assert_drawn, open, save, text};
use crate::common;
use crate::{packets, recorded};
use serde_json::{Value, json};

/// Draws a plot that a function makes, and gives its texts and those that overlap.
const OVERLAPS: &str = "async (make) => { \
    const texts = []; \
    const { fillText } = CanvasRenderingContext2D.prototype; \
    CanvasRenderingContext2D.prototype.fillText = function (text, x, y) { \
        const { width } = this.measureText(text); \
        const { e, f, b } = this.getTransform(); \
        const begin = e + x - { left: 0, start: 0, center: 0.5, right: 1, end: 1 }[this.textAlign] * width; \
        if (b === 0) texts.push({ ctx: this, text, begin, end: begin + width, y: Math.round(f + y) }); \
        fillText.call(this, text, x, y); \
    }; \
    const plot = await make(); \
    await new Promise((resolve) => setTimeout(resolve, 50)); \
    texts.length = 0; \
    plot.plot.redraw(); \
    await new Promise((resolve) => setTimeout(resolve, 50)); \
    CanvasRenderingContext2D.prototype.fillText = fillText; \
    const own = texts.filter(({ ctx }) => ctx === plot.plot.ctx); \
    const overlaps = own.flatMap((one, at) => own.slice(at + 1) \
        .filter((other) => Math.abs(other.y - one.y) < 11 && other.begin < one.end + 3 && one.begin < other.end + 3) \
        .map((other) => `${one.text} ${other.text}`)); \
    return [own.map(({ text }) => text), overlaps]; }";

/// A spectrum of a rate in hertz with so many harmonics.
const SPECTRUM: &str = "(rate, harmonics, isLog) => async () => { \
    const { Spectrum } = await import('/spectrum.js'); \
    const plot = new Spectrum(document.getElementById('spectrum').cloneNode(true), () => {}); \
    const power_db = Array.from({ length: 256 }, (_, bin) => -40 + bin % 7); \
    const lines = Array.from({ length: harmonics }, (_, at) => ({ frequency_hz: 0.01 * rate * (1 + at), power_db: -10 })); \
    plot.draw({ spectrum: { power_db, bin_hz: rate / 512, lines } }, isLog); \
    return plot; }";

/// A spectrogram of a tone of 1 mV at a rate in hertz, from a device time in seconds on, with ten
/// frames missing in its middle.
const SPECTROGRAM: &str = "(rate, share, from_s, isLog) => async () => { \
    const { Spectrogram } = await import('/spectrogram.js'); \
    const plot = new Spectrogram(document.getElementById('spectrogram').cloneNode(true), () => {}); \
    const number = Array.from({ length: 965 }, (_, at) => 3000 + at + (at > 480 ? 10 : 0)); \
    const t_s = number.map((at) => from_s + (at - 3000) / rate); \
    const channel = (taxel) => number.map((at) => 0.2 + 1e-3 * Math.cos(2 * Math.PI * share * at + taxel)); \
    const strips = { t_s, number, volts: Array.from({ length: 16 }, (_, taxel) => channel(taxel)) }; \
    plot.draw({ live: { strips }, frames_most: 965 }, isLog); \
    globalThis.drawn = { hz: plot.hz, ...plot.shown.found, db: plot.shown.found.db.map((column) => column && [...column]) }; \
    return plot; }";

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn texts_do_not_overlap_and_the_events_use_their_room() {
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(0.6));
    let view = View::start(&["--file", common::text(&path), "--pace", "0"]);
    let mut browser = open(&view);
    // From the slowest plan to the fastest one of a single channel.
    for rate_hz in [30.0, 241.14, 1458.8, 14_000.0, 23_739.0] {
        for (harmonics, is_log) in [(4, true), (16, true), (4, false), (16, false)] {
            let found = browser.value(&format!(
                "({OVERLAPS})(({SPECTRUM})({rate_hz}, {harmonics}, {is_log}))"
            ));
            assert_eq!(found[1], json!([]), "{rate_hz} Hz, {is_log}: {found}");
            let texts = found[0].as_array().expect("texts");
            let has = |text: &str| texts.iter().any(|found| found == text);
            let numbers = texts.iter().filter_map(Value::as_str);
            let numbers = numbers.filter(|text| text.parse::<f64>().is_ok_and(|hz| hz > 0.0));
            assert!(
                has("f") && numbers.count() > usize::from(is_log),
                "{rate_hz} Hz: {texts:?}"
            );
        }
    }
    // Ten updates a second of a board that has half of its time, and of one that restarts.
    let pace = browser.value(
        "(async () => { const { Pace } = await import('/model.js'); const pace = new Pace(); \
         const at = (wall_s, now_s) => pace.take(wall_s, now_s); \
         const first = at(10, 1); let slow; for (let t = 1; t < 80; t += 1) slow = at(10 + 0.1 * t, 1 + 0.05 * t); \
         return [first, slow, at(18, 0)]; })()",
    );
    assert!(pace[0].is_null() && pace[2].is_null(), "{pace}");
    assert!(
        (pace[1].as_f64().expect("a pace") - 0.5).abs() < 1e-9,
        "{pace}"
    );
    // The list ends where its box .
    let room = browser.value(
        "(() => { const [list, card] = ['lines', 'log'].map((id) => document.getElementById(id).getBoundingClientRect()); \
         return [card.bottom - list.bottom, list.height]; })()",
    );
    assert!(room[0].as_f64() < Some(20.0), "{room}");
    assert!(room[1].as_f64() >= Some(190.0), "{room}");
    assert_eq!(browser.errors(), Vec::<String>::new());
}

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn a_spectrogram_shows_a_tone_where_it_is_at_any_rate() {
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(3.2));
    let view = View::start(&["--file", common::text(&path), "--pace", "0"]);
    let mut browser = open(&view);
    browser.wait("document.querySelector('#spectrogram .empty').hidden");
    assert_drawn(&mut browser, &["spectrogram"]);
    // The slide's tone at its end, beside the fit's.
    let fitted = text(&mut browser, "frequency");
    let fitted_hz: f64 = fitted
        .split(' ')
        .next()
        .and_then(|hz| hz.parse().ok())
        .expect("a frequency");
    let (_, csv) = browser.offered(&save("spectrogram", "csv"));
    let rows: Vec<Vec<f64>> = String::from_utf8(csv)
        .expect("UTF-8")
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .map(|cell| cell.parse().expect(line))
                .collect()
        })
        .collect();
    let last_s = rows.last().expect("rows")[0];
    let found = rows
        .iter()
        .filter(|row| row[0] == last_s && row[1] > 3.0)
        .max_by(|a, b| a[2].total_cmp(&b[2]))
        .expect("a column");
    assert!((found[1] - fitted_hz).abs() < 2.0, "{found:?}: {fitted}");

    for rate_hz in [30.0, 241.14, 1458.8, 14_000.0, 23_739.0] {
        for (share, from_s, is_log) in [
            (0.083, 0.3, true),
            (0.3, 0.3, false),
            (0.083, 86_400.0, false),
            (0.21, 1234.5, true),
        ] {
            let texts = browser.value(&format!(
                "({OVERLAPS})(({SPECTROGRAM})({rate_hz}, {share}, {from_s}, {is_log}))"
            ));
            assert_eq!(texts[1], json!([]), "{rate_hz} Hz, {is_log}: {texts}");
            assert!(
                texts[0].as_array().is_some_and(|texts| texts.len() > 3),
                "{rate_hz} Hz: {texts}"
            );
            let drawn = browser.value("globalThis.drawn");
            let (bin_hz, columns) = (drawn["bin_hz"].as_f64(), drawn["hz"].as_array());
            let (bin_hz, columns) = (bin_hz.expect("a bin"), columns.expect("columns"));
            assert!((bin_hz / (rate_hz / 256.0) - 1.0).abs() < 1e-3, "{bin_hz}");
            // Windows of 256 frames that begin every 16: those with the gap in them are empty.
            let gaps = columns.iter().filter(|hz| hz.is_null()).count();
            assert!(columns.len() > 40 && (15..=16).contains(&gaps), "{gaps}");
            for hz in columns.iter().filter_map(Value::as_f64) {
                assert!((hz - share * rate_hz).abs() < 0.1 * bin_hz, "{hz}: {share}");
            }
            // Sixteen channels of 1 mV, of which a Hann window takes up to 1.42 dB between bins.
            let powers = drawn["db"].as_array().expect("columns").iter();
            for column in powers.filter_map(Value::as_array) {
                let most = column.iter().filter_map(Value::as_f64).fold(-1e3, f64::max);
                assert!(
                    (-1.5..0.05).contains(&(most - 10.0 * 8f64.log10())),
                    "{most}"
                );
            }
        }
    }
    assert_eq!(browser.errors(), Vec::<String>::new());
}
