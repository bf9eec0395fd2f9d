//! The page in a browser: three pictures of the latest update.

#[path = "../../../host/tests/common/browser.rs"]
mod browser;

use crate::common::{assert_one_line, ridgetone, run};
use browser::{Browser, Look};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

const LOOK: Look = Look {
    width: 1280,
    height: 800,
    dark: false,
};

/// Numbers that a picture speaks of.
fn numbers(browser: &mut Browser, id: &str) -> Vec<f64> {
    let label = browser.value(&format!(
        "document.querySelector('#{id} canvas').getAttribute('aria-label')"
    ));
    let label = label
        .as_str()
        .unwrap_or_else(|| panic!("{id} says nothing"))
        .to_owned();
    let (_, values) = label.split_once(": ").expect("values");
    values
        .split(", ")
        .map(|value| value.parse().expect("a number"))
        .collect()
}

/// Share of a canvas's pixels in which something is drawn.
fn drawn(browser: &mut Browser, id: &str) -> f64 {
    let share = browser.value(&format!(
        "((canvas) => {{ const {{ data }} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height); \
         return data.filter((value, at) => at % 4 === 3 && value > 0).length / (data.length / 4); }})(document.querySelector('#{id} canvas'))"
    ));
    share.as_f64().expect("a share")
}

#[test]
#[ignore = "needs the emulator and a browser; cargo xtask test installs one"]
fn the_emulated_touch_is_shown_as_three_pictures() {
    let mut child = ridgetone()
        .args(["pins", "--emulated", "--page", "127.0.0.1:0"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command runs");
    let mut url = String::new();
    BufReader::new(child.stdout.take().expect("a pipe"))
        .read_line(&mut url)
        .expect("a line");
    let mut browser = Browser::start(LOOK);
    browser.open(url.trim());
    browser.wait("document.getElementById('status')?.textContent === 'Pins active.'");
    // A finger of 1 N. Then the page is held, so that all pictures are of one state.
    browser.wait(
        "(() => { const label = document.querySelector('#forces canvas').getAttribute('aria-label') ?? ''; \
         if (Math.max(...label.split(': ')[1].split(', ').map(Number)) < 0.05) return false; \
         globalThis.requestAnimationFrame = () => 0; return true; })()",
    );
    let [sensor, forces, felt] = ["sensor", "forces", "felt"].map(|id| numbers(&mut browser, id));
    assert_eq!([sensor.len(), forces.len(), felt.len()], [16; 3]);
    assert!(
        forces.iter().all(|n| (0.0..=2.0).contains(n)) && forces.iter().any(|n| *n > 0.0),
        "{forces:?}"
    );
    for id in ["sensor", "forces", "felt"] {
        assert!(drawn(&mut browser, id) > 0.8, "{id}");
    }
    let summary = browser.value("document.getElementById('summary').textContent");
    assert!(
        summary
            .as_str()
            .is_some_and(|text| text.contains(" N total")),
        "{summary}"
    );
    assert_eq!(
        browser.value("document.getElementById('source').textContent"),
        Value::from("emulated board")
    );
    assert_eq!(browser.errors(), Vec::<String>::new());
    assert!(
        browser
            .requests()
            .iter()
            .all(|request| request.starts_with(url.trim())),
        "{:?}",
        browser.requests()
    );
    let _ = child.kill();
    let _ = child.wait();
}

#[test]
fn a_page_is_no_text() {
    for other in ["--json", "--plain"] {
        assert_one_line(
            &run(&["pins", "--emulated", "--page", "127.0.0.1:0", other]),
            2,
            &["--page"],
        );
    }
    assert_one_line(&run(&["pins", "--emulated", "--open"]), 2, &["--page"]);
    assert_one_line(
        &run(&["pins", "--emulated", "--page", "nowhere"]),
        2,
        &["127.0.0.1:8321"],
    );
    assert_one_line(&run(&["pins", "--live", "--emulated"]), 2, &["--live"]);
}
