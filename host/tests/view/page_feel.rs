//! What a finger feels, on the page in a browser.

use super::browser::Browser;
use super::{
    LOOK, Look, PHONE, TARGETS, View, assert_drawn, assert_quiet, base64, open, save, text,
};
use crate::common;
use crate::{packets, packets_with, recorded, recorded_as};
use ridgetone_proto::settings::{Feeling, Settings};
use ridgetone_proto::telemetry::{Event, Measured, Packet};
use serde_json::{Value, json};
use std::path::PathBuf;
use std::thread::sleep;
use std::time::Duration;

/// Two microvolts are a micrometre: the tone of the default scene is above two thresholds.
const SETTINGS: Settings = Settings {
    feel: Feeling {
        volts_per_um: 2e-6,
        sigma_fraction: 0.1,
        force_ratio: 1.4,
    },
    ..Settings::DEFAULT
};

/// Name, text, and classes and left ends of what is drawn beside it, of each row.
const ROWS: &str = "[...document.querySelectorAll('#feel-bars > div')].map((row) => [...row.children].slice(0, 2) \
    .map((child) => child.textContent).concat([...row.querySelectorAll('i')].map((part) => part.className)))";

/// Width of a bar's part over that of its track.
fn width(browser: &mut Browser, row: usize) -> f64 {
    let shares = format!(
        "((track) => track.querySelector('.fill').getBoundingClientRect().width / track.getBoundingClientRect().width) \
         (document.querySelectorAll('#feel-bars > div')[{row}].querySelector('.track'))"
    );
    browser.value(&shares).as_f64().expect("a width")
}

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn what_a_finger_feels_has_bars_scales_and_a_spectrum_and_is_hidden_before() {
    let folder = common::directory();
    let plain = recorded_as(folder.path(), "plain.rec", &packets(3.2));
    let view = View::start(&["--file", common::text(&plain), "--pace", "0"]);
    let mut browser = open(&view);
    assert_eq!(
        browser.value("document.getElementById('feel').getBoundingClientRect().height"),
        0
    );
    drop((browser, view));

    let path = recorded(folder.path(), &packets_with(SETTINGS, 3.2));
    let arguments = ["--file", common::text(&path), "--pace", "0"];
    let view = View::start(&arguments);
    let mut browser = open(&view);
    let lines = common::json_lines(&common::run(
        &[&["monitor", "--json"][..], &arguments].concat(),
    ));
    let feel = lines
        .iter()
        .rfind(|line| line["type"] == "feel")
        .expect("an event");
    browser.wait("document.querySelectorAll('#feel-bars > div').length === 6");
    let rows: Vec<Vec<String>> = serde_json::from_value(browser.value(ROWS)).expect("rows");
    let value = |of: &Value, what: &str| of[what].as_f64().expect("a number");
    for (row, of) in [(0, 0), (2, 2)] {
        let found = &feel["receptors"][of];
        let shown: Vec<f64> = rows[row][1]
            .split(" ± ")
            .map(|number| number.parse().expect("a number"))
            .collect();
        let (expected, sigma) = (
            value(found, "intensity_per_hz"),
            value(found, "intensity_per_hz_sigma"),
        );
        assert!(
            (shown[0] - expected).abs() < 0.1 * sigma && (shown[1] / sigma - 1.0).abs() < 0.06,
            "{rows:?} {found}"
        );
        assert_eq!(rows[row][2..], ["fill", "spread"]);
    }
    let ratio = value(&feel["receptors"][0], "intensity_per_hz")
        / value(&feel["receptors"][2], "intensity_per_hz");
    assert!(
        (width(&mut browser, 0) / width(&mut browser, 2) / ratio - 1.0).abs() < 0.02,
        "{ratio}"
    );
    // What is absent has its reason, and nothing drawn.
    for (row, name, why) in [
        (
            1,
            "FA II",
            "FA II needs more than 1600 rows a second, here are 241.14",
        ),
        (
            3,
            "SA II",
            "SA II needs more than 800 rows a second, here are 241.14",
        ),
        (5, "rough", "needs the intensity of FA II"),
    ] {
        assert_eq!(rows[row], [name, why]);
    }
    assert_eq!(rows[4][2..], ["spread", "mark"]);
    assert!(text(&mut browser, "feel-small").ends_with(" s at 241 Hz · 16 taxels · M 1.4"));
    assert_drawn(&mut browser, &["feel"]);
    let (name, csv) = browser.offered(&save("feel", "csv"));
    let csv = String::from_utf8(csv).expect("UTF-8");
    let levels = feel["spectrum"].as_array().expect("levels").len();
    assert!(
        name.starts_with("ridgetone-feel-") && csv.lines().count() == 1 + 7 + levels,
        "{name}: {csv}"
    );
    assert!(
        csv.contains(&format!(
            "\nfa1,{},",
            feel["receptors"][0]["intensity_per_hz"]
        )) && csv.contains("\nfa2,,\n")
    );
    let (_, png) = browser.offered(&save("feel", "png"));
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n") && png.len() > 2000);

    // These frames with another conversion: a tenth of the displacement is a decade less in
    // every bin that fires.
    browser.value("document.querySelector('[aria-label=\"Look touch.rec\"]').click()");
    browser.wait("document.getElementById('settings').hidden === false");
    assert_eq!(
        browser.value("document.getElementById('feel.volts_per_um').value"),
        "0.000002"
    );
    browser.value(
        "(() => { const input = document.getElementById('feel.volts_per_um'); input.value = '0.00002'; \
         input.dispatchEvent(new Event('input', { bubbles: true })); document.getElementById('settings-send').click(); })()",
    );
    browser.wait(
        "document.getElementById('settings-message').textContent.includes('with the new settings')",
    );
    browser.wait(&format!(
        "document.querySelector('#feel-bars dd').textContent !== '{}'",
        rows[0][1]
    ));
    let less: Vec<Vec<String>> = serde_json::from_value(browser.value(ROWS)).expect("rows");
    let first = |rows: &[Vec<String>], row: usize| {
        rows[row][1]
            .split(' ')
            .next()
            .and_then(|v| v.parse::<f64>().ok())
    };
    assert!(first(&less, 2) < first(&rows, 2), "{less:?}");
    assert_quiet(&browser, &view);
}

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn what_a_fast_board_feels_can_be_read_in_light_dark_and_on_a_phone() {
    let folder = common::directory();
    let mut all = packets_with(SETTINGS, 3.2);
    let feels = |packet: &&mut Packet| matches!(packet.event, Event::Feel(_));
    if let Some(Packet {
        event: Event::Feel(feel),
        ..
    }) = all.iter_mut().rfind(feels)
    {
        (feel.rate_hz, feel.window_s) = (3200.0, 0.32);
        feel.per_hz = [0.41, 2.25, 0.9, 0.05].map(|value| {
            Some(Measured {
                value,
                sigma: 0.1 * value,
            })
        });
        (feel.soft, feel.rough) = (
            Some(Measured {
                value: 8.5,
                sigma: 0.2,
            }),
            Some(Measured {
                value: 4.3,
                sigma: 0.6,
            }),
        );
        for (band, level) in feel.levels_db.iter_mut().enumerate() {
            *level = 40 - 3 * band as i8;
        }
    }
    let path = recorded(folder.path(), &all);
    let view = View::start(&["--file", common::text(&path), "--pace", "0"]);
    let mut browser = open(&view);
    browser.wait("document.querySelectorAll('#feel-bars i').length === 12");
    // A score beyond its scale stays on it; its number says more.
    let inside = browser.value(
        "[...document.querySelectorAll('#feel-bars .track')].every((track) => [...track.children].every((part) => { \
         const [a, b] = [track, part].map((element) => element.getBoundingClientRect()); \
         return b.left >= a.left - 3 && b.right <= a.right + 3; }))",
    );
    assert_eq!(inside, true);
    let kept = std::env::var_os("RIDGETONE_PICTURES").map(PathBuf::from);
    for (name, look) in [
        ("light", LOOK),
        ("dark", Look { dark: true, ..LOOK }),
        ("tablet", Look { width: 900, ..LOOK }),
        ("phone", PHONE),
        (
            "phone-dark",
            Look {
                dark: true,
                ..PHONE
            },
        ),
    ] {
        browser.look(look);
        sleep(Duration::from_millis(700));
        let wide = browser
            .value("document.documentElement.scrollWidth")
            .as_u64();
        assert!(wide <= Some(u64::from(look.width)), "{name}: {wide:?}");
        assert_eq!(
            browser.value(include_str!("readable.js")),
            json!([]),
            "{name}"
        );
        assert_drawn(&mut browser, &["feel"]);
        if let Some(folder) = &kept {
            browser.value("document.getElementById('feel').scrollIntoView({ block: 'end' })");
            let taken = browser.call("Page.captureScreenshot", json!({"format": "png"}));
            let bytes = base64(taken["data"].as_str().expect("a picture"));
            std::fs::write(folder.join(format!("feel-{name}.png")), bytes).expect("a file");
        }
        browser.value("document.querySelector('[aria-label=\"Look touch.rec\"]').click()");
        browser.wait("document.getElementById('settings').hidden === false");
        assert_eq!(
            browser.value(include_str!("readable.js")),
            json!([]),
            "{name}, settings"
        );
        if look.width == PHONE.width {
            assert_eq!(browser.value(TARGETS), json!([]), "{name}");
        }
        browser.value("document.getElementById('live').click()");
    }
    assert_quiet(&browser, &view);
}
