//! Texts that stand where there is room for them, in a browser.

use super::{View, open};
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
    // The list ends where its box does.
    let room = browser.value(
        "(() => { const [list, card] = ['lines', 'log'].map((id) => document.getElementById(id).getBoundingClientRect()); \
         return [card.bottom - list.bottom, list.height]; })()",
    );
    assert!(room[0].as_f64() < Some(20.0), "{room}");
    assert!(room[1].as_f64() >= Some(190.0), "{room}");
    assert_eq!(browser.errors(), Vec::<String>::new());
}
