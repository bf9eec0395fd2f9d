//! Runs on the page in a browser: dropped, looked at, marked, compared, with the mouse and with
//! keys.

use super::browser::Browser;
use super::{LOOK, Look, PHONE, TARGETS, View, assert_drawn, press, save, text};
use crate::common;
use crate::{packets, packets_at, recorded, recorded_as};
use serde_json::{Value, json};
use std::path::Path;
use std::thread::sleep;
use std::time::Duration;

/// Role and name of everything that a keyboard reaches, as a screen reader has them.
fn controls(browser: &mut Browser) -> Vec<(String, String)> {
    let tree = browser.call("Accessibility.getFullAXTree", json!({}));
    let focusable = |node: &&Value| {
        let properties = node["properties"].as_array();
        properties.is_some_and(|all| {
            all.iter()
                .any(|p| p["name"] == "focusable" && p["value"]["value"] == true)
        })
    };
    let text = |value: &Value| value["value"].as_str().unwrap_or_default().to_owned();
    let nodes = tree["nodes"]
        .as_array()
        .expect("a tree")
        .iter()
        .filter(|node| node["ignored"] == false);
    nodes
        .filter(focusable)
        .map(|node| (text(&node["role"]), text(&node["name"])))
        .collect()
}

/// Moves the slider of a run.
fn go(browser: &mut Browser, t_s: f64) {
    browser.value(&format!(
        "(() => {{ const time = document.getElementById('time'); time.value = {t_s}; \
         time.dispatchEvent(new Event('input', {{ bubbles: true }})); }})()"
    ));
    browser.wait(&format!(
        "Math.abs(parseFloat(document.getElementById('source').textContent.split(', ').at(-1)) - {t_s}) < 0.06"
    ));
}

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn a_file_that_is_dropped_is_scrubbed_marked_and_compared_with_keys_too() {
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(f64::INFINITY));
    let quiet = recorded_as(folder.path(), "quiet.rec", &packets(0.5));
    let slower = recorded_as(folder.path(), "slower.rec", &packets_at(20.0));
    let other = folder.path().join("other.mcap");
    assert!(
        common::run(&["export", common::text(&slower), "-o", common::text(&other)])
            .status
            .success()
    );
    let view = View::start(&["--file", common::text(&quiet), "--pace", "0"]);
    let mut browser = Browser::start(LOOK);
    browser.open(&view.url);
    browser.wait("document.querySelectorAll('#run-rows tr').length === 1");
    for (count, file) in [(2, &path), (3, &other)] {
        drop_file(&mut browser, file);
        browser.wait(&format!(
            "document.querySelectorAll('#run-rows tr').length === {count}"
        ));
    }
    let message = text(&mut browser, "runs-message");
    let rows = browser
        .value("[...document.querySelectorAll('#run-rows tr')].map((row) => row.textContent)");
    assert!(
        message.is_empty()
            && rows[1]
                .as_str()
                .is_some_and(|row| row.starts_with("touch.rec")),
        "{message} {rows}"
    );
    // A letter is refused in words.
    drop_file(
        &mut browser,
        &common::file(
            folder.path(),
            "letter.txt",
            "Dear all,\nthis is no table.\n",
        ),
    );
    browser.wait("document.getElementById('runs-message').textContent.startsWith('letter.txt')");

    // At any of its times.
    browser.value("document.querySelector('[aria-label=\"Look touch.rec\"]').click()");
    browser.wait("document.getElementById('run-name').textContent === 'touch.rec'");
    let lines = common::json_lines(&common::run(&[
        "monitor",
        "--file",
        common::text(&path),
        "--pace",
        "0",
        "--json",
    ]));
    let windows: Vec<&Value> = lines
        .iter()
        .filter(|line| line["span"] == "window")
        .collect();
    for (t_s, phase) in [
        (0.2, "no contact"),
        (
            windows[1]["t_s"].as_f64().expect("a time") + 0.02,
            "sliding",
        ),
    ] {
        go(&mut browser, t_s);
        assert_eq!(text(&mut browser, "phase"), phase, "{t_s}");
    }
    let frequency = |browser: &mut Browser| -> f64 {
        text(browser, "frequency")
            .split(' ')
            .next()
            .and_then(|hz| hz.parse().ok())
            .expect("a frequency")
    };
    let second_hz = windows[1]["frequency_hz"].as_f64().expect("a frequency");
    assert!((frequency(&mut browser) / second_hz - 1.0).abs() < 1e-5);
    assert_drawn(
        &mut browser,
        &["strips", "history", "spectrum", "fit", "map"],
    );

    // A part is marked with keys; its estimate is that of `fit`.
    let end_s = windows[1]["t_s"].as_f64().expect("a time");
    for (t_s, key) in [(end_s - 0.8, "["), (end_s - 0.1, "]")] {
        go(&mut browser, t_s);
        press(&mut browser, key);
    }
    browser.wait(
        "document.getElementById('frequency-small').textContent.includes('window of 0.70 s')",
    );
    assert!(text(&mut browser, "scrub-message").starts_with("Marked "));
    press(&mut browser, ",");
    assert!((frequency(&mut browser) / second_hz - 1.0).abs() < 0.01);

    // The space plays while the slider has the focus, too.
    browser.value("document.getElementById('time').focus()");
    press(&mut browser, " ");
    assert_eq!(text(&mut browser, "play"), "Stop");
    press(&mut browser, " ");
    assert_eq!(text(&mut browser, "play"), "Play");

    // Beside another run.
    browser.value("document.querySelector('[aria-label=\"Compare other.mcap\"]').click()");
    browser.wait(
        "document.getElementById('difference').textContent.includes('touch.rec − other.mcap: ')",
    );
    let apart = text(&mut browser, "difference");
    let apart_hz: f64 = apart
        .split("mcap: ")
        .nth(1)
        .and_then(|hz| hz.split(' ').next()?.parse().ok())
        .expect("a difference");
    // 30 and 20 mm/s over the same grating.
    assert!(
        (apart_hz - second_hz / 3.0).abs() < 0.01 * second_hz,
        "{apart}"
    );

    // These frames with other settings; without an estimate with the reason.
    for (window_s, words) in [
        ("3.9", "s, fills no window of 3.9 s"),
        ("0.5", "with the new settings"),
    ] {
        browser.value(&format!(
            "(() => {{ const window_s = document.getElementById('window_s'); window_s.value = '{window_s}'; \
             window_s.dispatchEvent(new Event('input', {{ bubbles: true }})); document.getElementById('settings-send').click(); }})()"
        ));
        browser.wait(&format!(
            "document.getElementById('settings-message').textContent.includes('{words}')"
        ));
    }
    browser.value("document.getElementById('mark-none').click()");
    browser.wait(
        "document.getElementById('frequency-small').textContent.includes('window of 0.50 s')",
    );

    // Keys zoom a plot and move it, and show all again.
    browser.value("document.querySelector('#history .plot').focus()");
    let range = |browser: &mut Browser| -> Vec<f64> {
        let (_, csv) = browser.offered(&save("strips", "csv"));
        let csv = String::from_utf8(csv).expect("UTF-8");
        csv.lines()
            .skip(1)
            .map(|row| row.split(',').next().unwrap().parse().unwrap())
            .collect()
    };
    browser.value("document.querySelector('#strips .plot').focus()");
    let all = range(&mut browser);
    press(&mut browser, "+");
    let near = range(&mut browser);
    assert!(
        (near.len() as f64 / (2.0 * 241.0) - 0.6).abs() < 0.05,
        "{} of {}",
        near.len(),
        all.len()
    );
    press(&mut browser, "ArrowLeft");
    let moved = range(&mut browser);
    assert!(
        (near[0] - moved[0] - 0.2 * 1.2).abs() < 0.05,
        "{} and {}",
        near[0],
        moved[0]
    );
    press(&mut browser, "0");
    assert!(range(&mut browser).len() > near.len());

    // Every control has a name.
    let controls = controls(&mut browser);
    let nameless: Vec<_> = controls
        .iter()
        .filter(|(role, name)| name.trim().is_empty() && role != "RootWebArea")
        .collect();
    assert!(
        nameless.is_empty() && controls.len() > 35,
        "{nameless:?} of {}",
        controls.len()
    );
    let is_there =
        |role: &str, name: &str| controls.iter().any(|(r, n)| r == role && n.contains(name));
    for (role, name) in [
        ("slider", "time"),
        ("button", "Compare other.mcap"),
        ("spinbutton", "window, s"),
        ("link", "Save touch.rec"),
        ("group", "Spectrum, plot"),
    ] {
        assert!(is_there(role, name), "{role} {name}: {controls:?}");
    }
    for look in [LOOK, Look { dark: true, ..LOOK }, PHONE] {
        browser.look(look);
        sleep(Duration::from_millis(300));
        assert_eq!(
            browser.value(include_str!("readable.js")),
            json!([]),
            "{look:?}"
        );
    }
    assert_eq!(browser.value(TARGETS), json!([]));
    browser.value("document.getElementById('live').click()");
    assert_eq!(
        text(&mut browser, "status"),
        "The recording is over. The page shows its end."
    );
    // The browser itself notes the answer to the letter.
    let refused = "Failed to load resource: the server responded with a status of 422";
    assert!(
        browser.errors().iter().all(|error| error.contains(refused)),
        "{:?}",
        browser.errors()
    );
}

/// Drops a file of this computer onto the page.
fn drop_file(browser: &mut Browser, path: &Path) {
    for kind in ["dragEnter", "dragOver", "drop"] {
        let data = json!({"items": [], "files": [common::text(path)], "dragOperationsMask": 1});
        browser.call(
            "Input.dispatchDragEvent",
            json!({"type": kind, "x": 300, "y": 300, "data": data}),
        );
    }
}

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn runs_have_notes_are_reloaded_and_do_not_go_unsaved_and_the_page_is_cleared() {
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(f64::INFINITY));
    let view = View::start(&["--file", common::text(&path), "--pace", "0.5"]);
    let mut browser = Browser::start(LOOK);
    browser.open(&view.url);
    browser.wait("document.querySelectorAll('#run-rows tr').length === 1");
    let row = |browser: &mut Browser, at: usize| {
        browser
            .value(&format!(
                "document.querySelectorAll('#run-rows tr')[{at}].textContent"
            ))
            .as_str()
            .expect("a row")
            .to_owned()
    };
    let now_s = "parseFloat(document.getElementById('source')?.textContent.split(', ').at(-1))";

    // What was received goes from the page, and what comes later stays.
    browser.wait(&format!("{now_s} > 0.8"));
    let before_s = browser.value(now_s).as_f64().expect("a time");
    browser.value("document.getElementById('clear').click()");
    browser.wait(&format!("{now_s} > {before_s} + 0.5"));
    let (_, csv) = browser.offered(&save("strips", "csv"));
    let csv = String::from_utf8(csv).expect("UTF-8");
    let first = csv.lines().nth(1).expect("a row").split(',').next();
    let first_s: f64 = first.expect("a time").parse().expect("a number");
    assert!(first_s > before_s - 0.1, "{first_s} {before_s}");

    // Another program writes the file anew.
    assert!(!row(&mut browser, 0).contains(" 0.50 s"));
    std::fs::remove_file(&path).expect("it is there");
    recorded(folder.path(), &packets(0.5));
    browser.value("document.querySelector('[aria-label=\"Reload touch.rec\"]').click()");
    browser
        .wait("document.querySelector('#run-rows tr').children[1].textContent.startsWith('0.4')");

    // Neither the page nor the run goes before it is saved.
    browser.value("document.getElementById('latest').click()");
    browser.wait("document.querySelectorAll('#run-rows tr').length === 2 && document.activeElement.id === 'time'");
    assert!(row(&mut browser, 1).contains(".rec, not saved"));
    let leaves = "(() => { const event = new Event('beforeunload', { cancelable: true }); \
                  window.dispatchEvent(event); return !event.defaultPrevented; })()";
    assert_eq!(browser.value(leaves), json!(false));
    browser.value(
        "window.confirm = (text) => { window.asked = text; return false; }; \
         document.querySelector('#run-rows tr:last-child [aria-label^=Close]').click()",
    );
    let asked = browser.value("window.asked");
    assert!(
        asked
            .as_str()
            .is_some_and(|text| text.contains("is not saved")),
        "{asked}"
    );
    assert_eq!(
        browser.value("document.querySelectorAll('#run-rows tr').length"),
        json!(2)
    );

    // A note stays at the command, and in the name of the file. Its keys are its own.
    let t_s = browser.value("document.getElementById('time').value");
    browser.value("document.querySelector('#run-rows tr:last-child input').focus()");
    for key in ["o", "a", "k", ",", "2"] {
        press(&mut browser, key);
    }
    browser.value("document.activeElement.blur()");
    assert_eq!(browser.value("document.getElementById('time').value"), t_s);
    browser.wait("(async () => (await (await fetch('/runs')).json())[1].note === 'oak,2')()");
    let (name, bytes) = browser.saved("#run-rows tr:last-child a");
    assert!(
        name.ends_with("s-oak-2.rec") && bytes.starts_with(b"ridgetone telemetry"),
        "{name}"
    );
    browser.wait(
        "!document.querySelector('#run-rows tr:last-child').textContent.includes('not saved')",
    );
    assert_eq!(browser.value(leaves), json!(true));
    assert_eq!(browser.errors(), Vec::<String>::new());
}
