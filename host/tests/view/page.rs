//! The page in a browser.

#[path = "../common/browser.rs"]
mod browser;

use super::served::request;
use super::{View, packets, recorded, recorded_as};
use crate::common;
use browser::{Browser, Look};
use ridgetone_proto::telemetry::{Event, Movement, OtherTone, Packet, Status};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

const LOOK: Look = Look { width: 1280, height: 800, dark: false };

const TEXT: &str = "(id) => document.getElementById(id).textContent";

/// Share of a canvas's pixels that are not empty.
const DRAWN: &str = "(canvas) => { \
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true }); \
    copy.drawImage(canvas, 0, 0); \
    const { data } = copy.getImageData(0, 0, canvas.width, canvas.height); \
    return data.filter((value, at) => at % 4 === 3 && value > 0).length / (data.length / 4); }";

fn text(browser: &mut Browser, id: &str) -> String {
    browser.value(&format!("({TEXT})('{id}')")).as_str().expect("a text").to_owned()
}

fn save(what: &str, how: &str) -> String {
    format!("#{what} [data-save={how}]")
}

/// Chooses an option as somebody would.
fn choose(browser: &mut Browser, id: &str, option: &str) {
    browser.value(&format!(
        "(() => {{ const select = document.getElementById('{id}'); select.value = '{option}'; \
         select.dispatchEvent(new Event('change', {{ bubbles: true }})); }})()"
    ));
}

/// Whether all plots have something on them.
fn assert_drawn(browser: &mut Browser, plots: &[&str]) {
    for plot in plots {
        let share = browser.value(&format!("({DRAWN})(document.querySelector('#{plot} canvas'))"));
        assert!(share.as_f64() > Some(0.01), "{plot}: {share}");
    }
}

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn a_recording_is_shown_with_the_numbers_of_json_and_can_be_paused_and_saved() {
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(3.2));
    let arguments = ["--file", common::text(&path), "--pace", "0"];
    let view = View::start(&arguments);
    let mut browser = Browser::start(LOOK);
    browser.open(&view.url);
    browser.wait("document.getElementById('status')?.textContent.startsWith('The recording is over') === true");
    let lines = common::json_lines(&common::run(&[&["monitor", "--json"][..], &arguments].concat()));
    let estimate = lines.iter().rfind(|line| line["type"] == "estimate").expect("an estimate");
    let (expected_hz, sigma_hz) = (estimate["frequency_hz"].as_f64().unwrap(), estimate["sigma_hz"].as_f64().unwrap());
    let shown = text(&mut browser, "frequency");
    let numbers: Vec<&str> = shown.trim_end_matches(" Hz").split(" ± ").collect();
    let decimals = numbers[0].split_once('.').expect("decimals").1.len();
    assert_eq!(shown, format!("{expected_hz:.decimals$} ± {sigma_hz:.decimals$} Hz"));
    assert!(decimals >= 4, "{shown}");
    assert_eq!(text(&mut browser, "phase"), "sliding");
    browser.wait("[...document.querySelectorAll('.empty')].every((text) => text.hidden)");
    assert_drawn(&mut browser, &["strips", "history", "spectrum", "fit", "map"]);

    // The channels as CSV are a recording: the fit finds the tone in it.
    let (name, csv) = browser.saved(&save("strips", "csv"));
    assert!(name.starts_with("ridgetone-strips-") && name.ends_with(".csv"), "{name}");
    let saved = common::file(folder.path(), "strips.csv", &String::from_utf8(csv).expect("UTF-8"));
    let (from, to) = (format!("{}", estimate["t_s"].as_f64().unwrap() - 1.0), format!("{}", estimate["t_s"]));
    let fit = common::run(&["fit", common::text(&saved), "--from", &from, "--to", &to, "--json"]);
    let fitted_hz = common::json_lines(&fit)[0]["frequency_hz"].as_f64().expect("a frequency");
    assert!((fitted_hz - expected_hz).abs() < 2.0 * sigma_hz, "{fitted_hz} and {expected_hz}");
    let (_, csv) = browser.offered(&save("history", "csv"));
    let estimates = lines.iter().filter(|line| line["type"] == "estimate").count();
    let csv = String::from_utf8(csv).expect("UTF-8");
    assert_eq!(csv.lines().count(), 1 + estimates);
    assert!(csv.starts_with("t_s,window_s,span,abscissa,status,frequency,sigma,"), "{csv}");
    for (what, rows) in [("spectrum", 127), ("fit", 241), ("map", 16)] {
        let (_, csv) = browser.offered(&save(what, "csv"));
        assert_eq!(String::from_utf8(csv).expect("UTF-8").lines().count(), 1 + rows, "{what}");
    }
    for what in ["strips", "history", "spectrum", "fit", "map"] {
        let (name, png) = browser.offered(&save(what, "png"));
        assert!(
            name.ends_with(".png") && png.starts_with(b"\x89PNG\r\n\x1a\n") && png.len() > 2000,
            "{name}: {}",
            png.len()
        );
    }

    // A drag across the spectrum zooms in, and pauses.
    browser.value("scrollTo(0, 0)");
    choose(&mut browser, "spectrum-x", "linear");
    let place = browser.value(
        "(({ left, top, width, height }) => [left + 0.2 * width, top + 0.5 * height, left + 0.6 * width])(document.querySelector('#spectrum .u-over').getBoundingClientRect())",
    );
    for (kind, x) in [("mousePressed", 0), ("mouseMoved", 2), ("mouseReleased", 2)] {
        let mouse = serde_json::json!({"type": kind, "x": place[x], "y": place[1], "button": "left", "buttons": 1, "clickCount": 1});
        browser.call("Input.dispatchMouseEvent", mouse);
    }
    browser.wait("document.body.classList.contains('paused')");
    let (_, csv) = browser.offered(&save("spectrum", "csv"));
    let zoomed: Vec<f64> = String::from_utf8(csv)
        .expect("UTF-8")
        .lines()
        .skip(1)
        .map(|row| row.split(',').next().unwrap().parse().unwrap())
        .collect();
    assert!((37..65).contains(&zoomed.len()) && zoomed[0] > 15.0 && zoomed[zoomed.len() - 1] < 80.0, "{zoomed:?}");
    assert_quiet(&browser, &view);
}

/// The console is empty, and every request is to the server.
fn assert_quiet(browser: &Browser, view: &View) {
    assert_eq!(browser.errors(), Vec::<String>::new());
    let requests = browser.requests();
    let is_ours = |url: &&String| url.starts_with(&view.url) || url.starts_with(&format!("blob:{}", view.url));
    assert!(requests.len() >= 11 && requests.iter().all(|url| is_ours(&url)), "{requests:?}");
}

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn a_restarted_command_is_found_again_and_missing_raw_frames_and_an_unsteady_tone_are_explained() {
    let folder = common::directory();
    let mut only: Vec<_> = packets(3.2).into_iter().filter(|packet| !matches!(packet.event, Event::Raw(_))).collect();
    let is_estimate = |packet: &&mut Packet| matches!(packet.event, Event::Estimate(_));
    if let Some(Packet { event: Event::Estimate(estimate), .. }) = only.iter_mut().rfind(is_estimate) {
        estimate.status = Status::Unsteady;
        estimate.movement = Movement { wander: 0.02, wander_sigma: 0.001, ..Movement::default() };
        estimate.other_tone = Some(OtherTone { frequency: 12.5, share: 0.25 });
    }
    let numbered: Vec<_> = (0..).zip(only).map(|(sequence, packet)| Packet { sequence, ..packet }).collect();
    let path = recorded(folder.path(), &numbered);
    let arguments = ["--file", common::text(&path), "--pace", "0"];
    let view = View::start(&arguments);
    let address = view.address().to_owned();
    let mut browser = Browser::start(LOOK);
    browser.open(&view.url);
    browser.wait("document.getElementById('status')?.textContent.startsWith('The recording is over') === true");
    let why = browser.value("document.querySelector('#strips .empty').textContent");
    assert_eq!(why, "This recording holds no raw frames, from which this is drawn.");
    assert_drawn(&mut browser, &["history", "map"]);
    let shown = text(&mut browser, "frequency");
    assert!(shown.ends_with(" Hz"), "{shown}");
    let beside = text(&mut browser, "frequency-small");
    for part in
        ["unsteady", "wander 2.0 %", "other tone 12.50 Hz, 25 % of the power", "shorten the window, give the speed"]
    {
        assert!(beside.contains(part), "{part}: {beside}");
    }
    drop(view);
    browser.wait("document.getElementById('status').textContent.startsWith('The command cannot be reached')");
    let _again = View::at(&address, &arguments);
    browser.wait("document.getElementById('status').textContent.startsWith('The recording is over')");
    assert_eq!(text(&mut browser, "frequency"), shown);
}

/// Presses a key, as a keyboard does.
fn press(browser: &mut Browser, key: &str) {
    for kind in ["keyDown", "keyUp"] {
        let text = if kind == "keyDown" && key.len() == 1 { key } else { "" };
        browser.call("Input.dispatchKeyEvent", json!({"type": kind, "key": key, "text": text}));
    }
}

/// Role and name of everything that a keyboard reaches, as a screen reader has them.
fn controls(browser: &mut Browser) -> Vec<(String, String)> {
    let tree = browser.call("Accessibility.getFullAXTree", json!({}));
    let focusable = |node: &&Value| {
        let properties = node["properties"].as_array();
        properties.is_some_and(|all| all.iter().any(|p| p["name"] == "focusable" && p["value"]["value"] == true))
    };
    let text = |value: &Value| value["value"].as_str().unwrap_or_default().to_owned();
    let nodes = tree["nodes"].as_array().expect("a tree").iter().filter(|node| node["ignored"] == false);
    nodes.filter(focusable).map(|node| (text(&node["role"]), text(&node["name"]))).collect()
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
    let table = folder.path().join("other.csv");
    assert!(common::run(&["scene", "--scene-speed", "20", "-o", common::text(&table)]).status.success());
    let view = View::start(&["--file", common::text(&quiet), "--pace", "0"]);
    let mut browser = Browser::start(LOOK);
    browser.open(&view.url);
    browser.wait("document.querySelectorAll('#run-rows tr').length === 1");
    for (count, file) in [(2, &path), (3, &table)] {
        drop_file(&mut browser, file);
        browser.wait(&format!("document.querySelectorAll('#run-rows tr').length === {count}"));
    }
    let said = text(&mut browser, "runs-said");
    let rows = browser.value("[...document.querySelectorAll('#run-rows tr')].map((row) => row.textContent)");
    assert!(said.is_empty() && rows[1].as_str().is_some_and(|row| row.starts_with("touch.rec")), "{said} {rows}");
    // A letter is refused in words.
    drop_file(&mut browser, &common::file(folder.path(), "letter.txt", "Dear all,\nthis is no table.\n"));
    browser.wait("document.getElementById('runs-said').textContent.startsWith('letter.txt')");

    // At any of its times.
    browser.value("document.querySelector('[aria-label=\"Look touch.rec\"]').click()");
    browser.wait("document.getElementById('run-name').textContent === 'touch.rec'");
    let lines = common::json_lines(&common::run(&["monitor", "--file", common::text(&path), "--pace", "0", "--json"]));
    let windows: Vec<&Value> = lines.iter().filter(|line| line["span"] == "window").collect();
    for (t_s, phase) in [(0.2, "no contact"), (windows[1]["t_s"].as_f64().expect("a time") + 0.02, "sliding")] {
        go(&mut browser, t_s);
        assert_eq!(text(&mut browser, "phase"), phase, "{t_s}");
    }
    let frequency = |browser: &mut Browser| -> f64 {
        text(browser, "frequency").split(' ').next().and_then(|hz| hz.parse().ok()).expect("a frequency")
    };
    let second_hz = windows[1]["frequency_hz"].as_f64().expect("a frequency");
    assert!((frequency(&mut browser) / second_hz - 1.0).abs() < 1e-5);
    assert_drawn(&mut browser, &["strips", "history", "spectrum", "fit", "map"]);

    // A part is marked with keys; its estimate is that of `fit`.
    let end_s = windows[1]["t_s"].as_f64().expect("a time");
    for (t_s, key) in [(end_s - 0.8, "["), (end_s - 0.1, "]")] {
        go(&mut browser, t_s);
        press(&mut browser, key);
    }
    browser.wait("document.getElementById('frequency-small').textContent.includes('window of 0.70 s')");
    assert!(text(&mut browser, "scrub-said").starts_with("Marked "));
    press(&mut browser, ",");
    assert!((frequency(&mut browser) / second_hz - 1.0).abs() < 0.01);

    // Beside another run.
    browser.value("document.querySelector('[aria-label=\"Compare other.csv\"]').click()");
    browser.wait("document.getElementById('difference').textContent.includes('touch.rec − other.csv: ')");
    let apart = text(&mut browser, "difference");
    let apart_hz: f64 =
        apart.split("csv: ").nth(1).and_then(|hz| hz.split(' ').next()?.parse().ok()).expect("a difference");
    // 30 and 20 mm/s over the same grating.
    assert!((apart_hz - second_hz / 3.0).abs() < 0.01 * second_hz, "{apart}");

    // The same frames with other settings.
    browser.value(
        "(() => { const window_s = document.getElementById('window_s'); window_s.value = '0.5'; \
         window_s.dispatchEvent(new Event('input', { bubbles: true })); document.getElementById('settings-send').click(); })()",
    );
    browser.wait("document.getElementById('settings-said').textContent.includes('with the new settings')");
    browser.value("document.getElementById('mark-none').click()");
    browser.wait("document.getElementById('frequency-small').textContent.includes('window of 0.50 s')");

    // Keys zoom a plot and move it, and show all again.
    browser.value("document.querySelector('#history .plot').focus()");
    let range = |browser: &mut Browser| -> Vec<f64> {
        let (_, csv) = browser.offered(&save("strips", "csv"));
        let csv = String::from_utf8(csv).expect("UTF-8");
        csv.lines().skip(1).map(|row| row.split(',').next().unwrap().parse().unwrap()).collect()
    };
    browser.value("document.querySelector('#strips .plot').focus()");
    let all = range(&mut browser);
    press(&mut browser, "+");
    let near = range(&mut browser);
    assert!((near.len() as f64 / (2.0 * 241.0) - 0.6).abs() < 0.05, "{} of {}", near.len(), all.len());
    press(&mut browser, "ArrowLeft");
    let moved = range(&mut browser);
    assert!((near[0] - moved[0] - 0.2 * 1.2).abs() < 0.05, "{} and {}", near[0], moved[0]);
    press(&mut browser, "0");
    assert!(range(&mut browser).len() > near.len());

    // Every control has a name.
    let controls = controls(&mut browser);
    let nameless: Vec<_> =
        controls.iter().filter(|(role, name)| name.trim().is_empty() && role != "RootWebArea").collect();
    assert!(nameless.is_empty() && controls.len() > 35, "{nameless:?} of {}", controls.len());
    let is_there = |role: &str, name: &str| controls.iter().any(|(r, n)| r == role && n.contains(name));
    for (role, name) in [
        ("slider", "time"),
        ("button", "Compare other.csv"),
        ("spinbutton", "window, s"),
        ("link", "Save touch.rec"),
        ("group", "Spectrum, plot"),
    ] {
        assert!(is_there(role, name), "{role} {name}: {controls:?}");
    }
    for look in [LOOK, Look { dark: true, ..LOOK }, PHONE] {
        browser.look(look);
        sleep(Duration::from_millis(300));
        assert_eq!(browser.value(include_str!("readable.js")), json!([]), "{look:?}");
    }
    assert_eq!(browser.value(TARGETS), json!([]));
    browser.value("document.getElementById('live').click()");
    assert_eq!(text(&mut browser, "status"), "The recording is over. The page shows its end.");
    // The browser itself notes the answer to the letter.
    let refused = "Failed to load resource: the server responded with a status of 422";
    assert!(browser.errors().iter().all(|error| error.contains(refused)), "{:?}", browser.errors());
}

const PHONE: Look = Look { width: 390, height: 844, dark: false };

/// What a finger hits on a phone that is smaller than 44 px (WCAG 2.2, 2.5.5).
const TARGETS: &str = "[...document.querySelectorAll('button, select, input, a, label.button')] \
    .filter((target) => target.id !== 'file') \
    .map((target) => [target, target.getBoundingClientRect()]) \
    .filter(([target, { width, height }]) => width > 0 && (height < 44 || width < 44)) \
    .map(([target, { width, height }]) => `${target.id || target.textContent} ${width} x ${height}`)";

/// Drops a file of this computer onto the page.
fn drop_file(browser: &mut Browser, path: &Path) {
    for kind in ["dragEnter", "dragOver", "drop"] {
        let data = json!({"items": [], "files": [common::text(path)], "dragOperationsMask": 1});
        browser.call("Input.dispatchDragEvent", json!({"type": kind, "x": 300, "y": 300, "data": data}));
    }
}

#[test]
#[ignore = "needs the firmware image and a browser; cargo xtask test builds and installs them"]
fn the_emulated_board_waits_while_nobody_looks_takes_settings_and_is_recorded() {
    let view = View::start(&["--emulated"]);
    let now_s = || {
        let (_, _, body) = request(view.address(), "/state.json", view.address(), Duration::from_secs(20));
        serde_json::from_str::<Value>(&body).expect("JSON")["live"]["now_s"].as_f64().unwrap_or_default()
    };
    sleep(Duration::from_secs(2));
    assert!(now_s() < 0.5, "nobody has looked yet");
    let mut browser = Browser::start(LOOK);
    browser.open(&view.url);
    browser.wait("document.getElementById('settings')?.hidden === false");
    browser.value("document.getElementById('record').click()");
    for (id, value) in [("window_s", "0.5"), ("hop_s", "0.1"), ("harmonics", "2")] {
        browser.value(&format!(
            "(() => {{ const input = document.getElementById('{id}'); input.value = '{value}'; \
             input.dispatchEvent(new Event('input', {{ bubbles: true }})); }})()"
        ));
    }
    browser.value("document.getElementById('settings-send').click()");
    browser.wait("document.getElementById('settings-said').textContent.startsWith('In force')");
    browser.wait("document.getElementById('frequency-small').textContent.includes('window of 0.50 s')");
    let words = text(&mut browser, "fit-small");
    assert!(words.contains("f ") && !words.contains("3f "), "{words}");
    browser.value("document.getElementById('record').click()");
    browser.wait("document.querySelectorAll('#run-rows tr').length === 1");
    let row = browser.value("document.querySelector('#run-rows tr').textContent");
    assert!(row.as_str().is_some_and(|row| row.starts_with("emulated-board-") && row.contains(" Hz")), "{row}");
    assert_quiet(&browser, &view);
    // The page is left: the board stops three seconds after somebody has asked for its state.
    browser.open("about:blank");
    sleep(Duration::from_secs(1));
    let before_s = now_s();
    sleep(Duration::from_secs(6));
    let passed_s = now_s() - before_s;
    assert!((0.0..4.5).contains(&passed_s), "{passed_s} s");
}

/// The picture of the page that the documents show, in the folder that `cargo xtask pictures` names.
#[test]
#[ignore = "needs the firmware image and a browser; cargo xtask test builds and installs them"]
fn the_picture_of_the_page_shows_the_period_of_the_first_scene() {
    let view = View::start(&["--emulated"]);
    let mut browser = Browser::start(Look { width: 1280, height: 960, dark: false });
    browser.call("Emulation.setScrollbarsHidden", json!({"hidden": true}));
    browser.open(&view.url);
    browser.wait("/, 5\\.[34] s$/.test(document.querySelector('#source')?.textContent)");
    let period = text(&mut browser, "period");
    let (mm, sigma_mm) = period.trim_end_matches(" mm").split_once(" ± ").unwrap_or_else(|| panic!("{period}"));
    let apart_mm = (mm.parse::<f64>().expect("mm") - 3.6).abs();
    assert!(apart_mm < 2.0 * sigma_mm.parse::<f64>().expect("mm"), "{period}");
    assert_drawn(&mut browser, &["strips", "history", "spectrum", "fit", "map"]);
    let taken = browser.call("Page.captureScreenshot", json!({"format": "png"}));
    let kept = std::env::var_os("RIDGETONE_PICTURES");
    let folder = common::directory();
    let path = kept.map_or_else(|| folder.path().to_owned(), PathBuf::from).join("view.png");
    std::fs::write(&path, base64(taken["data"].as_str().expect("a picture"))).expect("a file");
    assert!(std::fs::read(&path).expect("a file").starts_with(b"\x89PNG"));
}

/// The bytes of a text in base 64 (RFC 4648, section 4).
fn base64(text: &str) -> Vec<u8> {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digit = |byte: &u8| DIGITS.iter().position(|digit| digit == byte).map(|digit| digit as u32);
    let digits: Vec<u32> = text.as_bytes().iter().filter_map(digit).collect();
    let bytes = |four: &[u32]| {
        let bits = four.iter().fold(0, |bits, digit| bits << 6 | digit) << (6 * (4 - four.len()));
        bits.to_be_bytes()[1..four.len()].to_vec()
    };
    digits.chunks(4).flat_map(bytes).collect()
}

#[test]
#[ignore = "needs the firmware image and a browser; cargo xtask test builds and installs them"]
fn the_emulated_board_is_live_in_light_dark_and_on_a_phone() {
    let view = View::start(&["--emulated"]);
    let mut browser = Browser::start(LOOK);
    browser.open(&view.url);
    browser.wait(
        "document.getElementById('phase')?.textContent === 'sliding' && document.getElementById('frequency').textContent.includes('Hz')",
    );
    assert_drawn(&mut browser, &["strips", "history", "spectrum", "fit", "map"]);
    let looks = [
        ("light", LOOK),
        ("dark", Look { dark: true, ..LOOK }),
        ("phone", PHONE),
        ("phone-dark", Look { dark: true, ..PHONE }),
    ];
    for (name, look) in looks {
        browser.look(look);
        sleep(Duration::from_millis(700));
        let wide = browser.value("document.documentElement.scrollWidth").as_u64();
        assert!(wide <= Some(u64::from(look.width)), "{name}: {wide:?}");
        let found = browser.value(include_str!("readable.js"));
        assert_eq!(found, json!([]), "{name}");
        if look.width == PHONE.width {
            assert_eq!(browser.value(TARGETS), json!([]), "{name}");
        }
        assert_drawn(&mut browser, &["strips", "history", "map"]);
    }
    browser.look(LOOK);
    let pixels = |browser: &mut Browser| browser.value("document.querySelector('#strips canvas').toDataURL()");
    let before = pixels(&mut browser);
    sleep(Duration::from_millis(500));
    let after = pixels(&mut browser);
    assert_ne!(before, after, "it is live");
    browser.value("document.getElementById('pause').click()");
    sleep(Duration::from_millis(300));
    let (still, received) = (pixels(&mut browser), text(&mut browser, "lost-small"));
    sleep(Duration::from_millis(700));
    assert_eq!((pixels(&mut browser), text(&mut browser, "lost-small")), (still.clone(), received), "it is paused");
    browser.value("document.getElementById('pause').click()");
    sleep(Duration::from_millis(500));
    assert_ne!(pixels(&mut browser), still, "it goes on");
    assert_quiet(&browser, &view);
}
