//! The page in a browser.

#[path = "../common/browser.rs"]
mod browser;
#[path = "page_cursor.rs"]
mod cursor;
#[path = "page_room.rs"]
mod room;
#[path = "page_runs.rs"]
mod runs;

use super::served::request;
use super::{View, packets, recorded, recorded_as};
use crate::common;
use browser::{Browser, Look};
use ridgetone_host::feed::{Feed, FeedEvent, Following};
use ridgetone_host::recording::Recorded;
use ridgetone_host::view::answer::App;
use ridgetone_host::view::hub::Hub;
use ridgetone_host::view::runs::Runs;
use ridgetone_host::view::server::{Server, routes};
use ridgetone_proto::telemetry::{Event, Movement, OtherTone, Packet, Status};
use serde_json::{Value, json};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::sleep;
use std::time::Duration;

const LOOK: Look = Look {
    width: 1280,
    height: 800,
    dark: false,
};

const TEXT: &str = "(id) => document.getElementById(id).textContent";

/// Share of a canvas's pixels that are not empty.
const DRAWN: &str = "(canvas) => { \
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true }); \
    copy.drawImage(canvas, 0, 0); \
    const { data } = copy.getImageData(0, 0, canvas.width, canvas.height); \
    return data.filter((value, at) => at % 4 === 3 && value > 0).length / (data.length / 4); }";

fn text(browser: &mut Browser, id: &str) -> String {
    browser
        .value(&format!("({TEXT})('{id}')"))
        .as_str()
        .expect("a text")
        .to_owned()
}

/// The page of a recording that is played at once, at its end.
fn open(view: &View) -> Browser {
    open_url(&view.url)
}

fn open_url(url: &str) -> Browser {
    let mut browser = Browser::start(LOOK);
    browser.open(url);
    browser.wait("document.getElementById('status')?.textContent.startsWith('The recording is over') === true");
    browser
}

fn save(what: &str, how: &str) -> String {
    format!("#{what} [data-save={how}]")
}

/// Presses a key, as a keyboard does.
fn press(browser: &mut Browser, key: &str) {
    for kind in ["keyDown", "keyUp"] {
        let text = if kind == "keyDown" && key.len() == 1 {
            key
        } else {
            ""
        };
        browser.call(
            "Input.dispatchKeyEvent",
            json!({"type": kind, "key": key, "text": text}),
        );
    }
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
        let share = browser.value(&format!(
            "({DRAWN})(document.querySelector('#{plot} canvas'))"
        ));
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
    let mut browser = open(&view);
    let lines = common::json_lines(&common::run(
        &[&["monitor", "--json"][..], &arguments].concat(),
    ));
    let estimate = lines
        .iter()
        .rfind(|line| line["type"] == "estimate")
        .expect("an estimate");
    let (expected_hz, sigma_hz) = (
        estimate["frequency_hz"].as_f64().unwrap(),
        estimate["sigma_hz"].as_f64().unwrap(),
    );
    let shown = text(&mut browser, "frequency");
    let numbers: Vec<&str> = shown.trim_end_matches(" Hz").split(" ± ").collect();
    let decimals = numbers[0].split_once('.').expect("decimals").1.len();
    assert_eq!(
        shown,
        format!("{expected_hz:.decimals$} ± {sigma_hz:.decimals$} Hz")
    );
    assert!(decimals >= 4, "{shown}");
    assert_eq!(text(&mut browser, "phase"), "sliding");
    browser.wait("[...document.querySelectorAll('.empty')].every((text) => text.hidden)");
    assert_drawn(
        &mut browser,
        &["strips", "history", "spectrum", "fit", "map"],
    );

    // The channels as CSV are a recording: the fit finds the tone in it.
    let (name, csv) = browser.saved(&save("strips", "csv"));
    assert!(
        name.starts_with("ridgetone-strips-") && name.ends_with(".csv"),
        "{name}"
    );
    let saved = common::file(
        folder.path(),
        "strips.csv",
        &String::from_utf8(csv).expect("UTF-8"),
    );
    let (from, to) = (
        format!("{}", estimate["t_s"].as_f64().unwrap() - 1.0),
        format!("{}", estimate["t_s"]),
    );
    let fit = common::run(&[
        "fit",
        common::text(&saved),
        "--from",
        &from,
        "--to",
        &to,
        "--json",
    ]);
    let fitted_hz = common::json_lines(&fit)[0]["frequency_hz"]
        .as_f64()
        .expect("a frequency");
    assert!(
        (fitted_hz - expected_hz).abs() < 2.0 * sigma_hz,
        "{fitted_hz} and {expected_hz}"
    );
    let (_, csv) = browser.offered(&save("history", "csv"));
    let estimates = lines
        .iter()
        .filter(|line| line["type"] == "estimate")
        .count();
    let csv = String::from_utf8(csv).expect("UTF-8");
    assert_eq!(csv.lines().count(), 1 + estimates);
    assert!(
        csv.starts_with("t_s,window_s,span,frequency_hz,sigma_hz,"),
        "{csv}"
    );
    for (what, rows) in [("spectrum", 127), ("fit", 241), ("map", 16)] {
        let (_, csv) = browser.offered(&save(what, "csv"));
        assert_eq!(
            String::from_utf8(csv).expect("UTF-8").lines().count(),
            1 + rows,
            "{what}"
        );
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
    assert!(
        (37..65).contains(&zoomed.len()) && zoomed[0] > 15.0 && zoomed[zoomed.len() - 1] < 80.0,
        "{zoomed:?}"
    );
    assert_quiet(&browser, &view);
}

/// The console is empty, and every request is to the server.
fn assert_quiet(browser: &Browser, view: &View) {
    assert_eq!(browser.errors(), Vec::<String>::new());
    let requests = browser.requests();
    let is_ours = |url: &&String| {
        url.starts_with(&view.url) || url.starts_with(&format!("blob:{}", view.url))
    };
    assert!(
        requests.len() >= 11 && requests.iter().all(|url| is_ours(&url)),
        "{requests:?}"
    );
}

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn a_restarted_command_is_found_again_and_missing_raw_frames_and_an_unsteady_tone_are_explained() {
    let folder = common::directory();
    let mut only: Vec<_> = packets(3.2)
        .into_iter()
        .filter(|packet| !matches!(packet.event, Event::Raw(_)))
        .collect();
    let is_estimate = |packet: &&mut Packet| matches!(packet.event, Event::Estimate(_));
    if let Some(Packet {
        event: Event::Estimate(estimate),
        ..
    }) = only.iter_mut().rfind(is_estimate)
    {
        estimate.status = Status::Unsteady;
        estimate.movement = Movement {
            wander: 0.02,
            wander_sigma: 0.001,
            ..Movement::default()
        };
        estimate.other_tone = Some(OtherTone {
            frequency: 12.5,
            share: 0.25,
        });
    }
    let numbered: Vec<_> = (0..)
        .zip(only)
        .map(|(sequence, packet)| Packet { sequence, ..packet })
        .collect();
    let path = recorded(folder.path(), &numbered);
    let server = serve(&path, SocketAddr::from((Ipv4Addr::LOCALHOST, 0)));
    let address = server.address;
    let mut browser = open_url(&format!("http://{address}/"));
    let why = browser.value("document.querySelector('#strips .empty').textContent");
    assert_eq!(
        why,
        "This recording holds no raw frames, from which this is drawn."
    );
    assert_drawn(&mut browser, &["history", "map"]);
    let shown = text(&mut browser, "frequency");
    assert!(shown.ends_with(" Hz"), "{shown}");
    let beside = text(&mut browser, "frequency-small");
    for part in [
        "unsteady",
        "wander 2.0 %",
        "other tone 12.50 Hz, 25 % of the power",
        "shorten the window, or give the speed",
    ] {
        assert!(beside.contains(part), "{part}: {beside}");
    }
    drop(server);
    browser.wait(
        "document.getElementById('status').textContent.startsWith('The command cannot be reached')",
    );
    let is_gone = "document.body.classList.contains('gone') \
        && document.getElementById('latest').disabled && document.getElementById('runs').inert \
        && Number(getComputedStyle(document.querySelector('#history .plot')).opacity) < 0.5";
    assert_eq!(browser.value(is_gone), true);
    let _again = serve(&path, address);
    browser
        .wait("document.getElementById('status').textContent.startsWith('The recording is over')");
    assert_eq!(text(&mut browser, "frequency"), shown);
    assert_eq!(browser.value(is_gone), false);
}

/// The page of a recording at its end, at this address, until it is dropped.
fn serve(recording: &Path, address: SocketAddr) -> Server {
    let source = Recorded::open(recording).expect("a recording");
    let mut following = Following::new(Feed::new(source), None);
    let hub = Hub::new(following.live());
    loop {
        let event = following.next(Duration::ZERO).expect("a feed");
        hub.take(event.as_ref(), &mut following);
        if event == Some(FeedEvent::Over) {
            break;
        }
    }
    let app = App {
        hub: Arc::new(hub),
        runs: Arc::new(Runs::new(recording.parent().expect("a folder"))),
    };
    Server::start(&[address], routes(app)).expect("a server")
}

/// What is not known is not drawn: frames that are missing, and what is between good windows.
#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn gaps_and_windows_that_are_not_good_are_not_drawn_over() {
    let folder = common::directory();
    let path = recorded(folder.path(), &packets(0.6));
    let view = View::start(&["--file", common::text(&path), "--pace", "0"]);
    let mut browser = open(&view);
    let plot = |file: &str, class: &str, card: &str| {
        format!(
            "const {{ {class} }} = await import('/{file}.js'); \
             const plot = new {class}(document.getElementById('{card}').cloneNode(true), () => {{}});"
        )
    };
    let strips = browser.value(&format!(
        "(async () => {{ {} const t_s = [0, 0.004, 0.008, 1, 1.004, 1.008]; \
         plot.draw({{ live: {{ strips: {{ t_s, volts: Array.from({{ length: 16 }}, () => t_s) }} }} }}, 2); \
         return plot.data.slice(0, 2); }})()",
        plot("strips", "Strips", "strips")
    ));
    assert_eq!(strips[0].as_array().map(Vec::len), Some(7));
    let empty = |values: &Value| {
        let values = values.as_array().expect("values").iter().enumerate();
        values
            .filter(|(_, value)| value.is_null())
            .map(|(at, _)| at)
            .collect::<Vec<_>>()
    };
    assert_eq!(empty(&strips[1]), [3]);
    let history = browser.value(&format!(
        "(async () => {{ {} const points = ['good', 'good', 'ambiguous', 'good'].map((status, at) => ({{ \
         t_s: 0.25 * at, status, span: 'window', frequency: status === 'good' ? 4 : 2.9, sigma: 1 }})); \
         plot.draw({{ live: {{ history: points, now_s: 1, latest: {{}} }} }}, 30); \
         return [...plot.data.slice(1, 4), plot.axis.range]; }})()",
        plot("history", "History", "history")
    ));
    for line in [0, 1, 2] {
        assert_eq!(empty(&history[line]), [2], "{history}");
    }
    // The axis holds the band, which is a tenth of the frequency here.
    let [low, high] = [0, 1].map(|end| history[3][end].as_f64().expect("an end"));
    assert!(low < 3.6 && high > 4.4, "{history}");
    // A damaged packet is missing, too, and is one loss.
    let lost = browser.value(
        "(async () => { const { tiles } = await import('/panels.js'); \
         tiles({ remarks: [], live: { latest: {}, counts: { received: 9, missing: 3, damaged: 2 }, phase: 'idle', phase_since_s: null, touches: 0 } }); \
         return document.getElementById('lost').textContent; })()",
    );
    assert_eq!(lost, "3");
}

const PHONE: Look = Look {
    width: 390,
    height: 844,
    dark: false,
};

/// What a finger hits on a phone that is smaller than 44 px (WCAG 2.2, 2.5.5).
const TARGETS: &str = "[...document.querySelectorAll('button, select, input, a, label.button')] \
    .filter((target) => target.id !== 'file') \
    .map((target) => [target, target.getBoundingClientRect()]) \
    .filter(([target, { width, height }]) => width > 0 && (height < 44 || width < 44)) \
    .map(([target, { width, height }]) => `${target.id || target.textContent} ${width} x ${height}`)";

#[test]
#[ignore = "needs the firmware image and a browser; cargo xtask test builds and installs them"]
fn the_emulated_board_waits_while_nobody_looks_takes_settings_and_is_recorded() {
    let view = View::start(&["--emulated"]);
    let now_s = || {
        let (_, _, body) = request(
            view.address(),
            "/state.json",
            view.address(),
            Duration::from_secs(20),
        );
        serde_json::from_str::<Value>(&body).expect("JSON")["live"]["now_s"]
            .as_f64()
            .unwrap_or_default()
    };
    sleep(Duration::from_secs(2));
    assert!(now_s() < 0.5, "nobody has looked yet");
    let mut browser = Browser::start(LOOK);
    browser.open(&view.url);
    browser.wait("document.getElementById('settings')?.hidden === false");
    browser.value("document.getElementById('record').click()");
    for (id, value) in [("window_s", "0.5"), ("stride_s", "0.1"), ("harmonics", "2")] {
        browser.value(&format!(
            "(() => {{ const input = document.getElementById('{id}'); input.value = '{value}'; \
             input.dispatchEvent(new Event('input', {{ bubbles: true }})); }})()"
        ));
    }
    browser.value("document.getElementById('settings-send').click()");
    browser.wait(
        "document.getElementById('settings-message').textContent.startsWith('Applied, not stored')",
    );
    // A refusal stays until the next command, though the board's answer comes with every update.
    let change = |browser: &mut Browser, harmonics: &str| {
        browser.value(&format!(
            "(() => {{ const input = document.getElementById('harmonics'); input.value = '{harmonics}'; \
             input.dispatchEvent(new Event('input', {{ bubbles: true }})); \
             document.getElementById('settings-send').click(); }})()"
        ));
    };
    change(&mut browser, "9");
    browser
        .wait("document.getElementById('settings-message').textContent.startsWith('harmonics: ')");
    let from_s = now_s();
    while now_s() < from_s + 0.5 {
        sleep(Duration::from_millis(50));
    }
    let message = text(&mut browser, "settings-message");
    assert!(message.starts_with("harmonics: "), "{message}");
    change(&mut browser, "2");
    browser.wait(
        "document.getElementById('settings-message').textContent.startsWith('Applied, not stored')",
    );
    browser.wait(
        "document.getElementById('frequency-small').textContent.includes('window of 0.50 s')",
    );
    let words = text(&mut browser, "fit-small");
    assert!(words.contains("f ") && !words.contains("3f "), "{words}");
    browser.value("document.getElementById('record').click()");
    browser.wait("document.querySelectorAll('#run-rows tr').length === 1");
    let row = browser.value("document.querySelector('#run-rows tr').textContent");
    assert!(
        row.as_str()
            .is_some_and(|row| row.starts_with("emulated-board-") && row.contains(" Hz")),
        "{row}"
    );
    // What has passed without anybody's recording can be looked at too.
    browser.value("document.getElementById('latest').click()");
    browser.wait("document.querySelectorAll('#run-rows tr').length === 2 && !document.getElementById('scrub').hidden");
    let begins = browser
        .value("Number(document.getElementById('time').min)")
        .as_f64()
        .expect("a time");
    assert!(begins < 0.1, "{begins}");
    browser.value("document.getElementById('live').click()");
    // A new plan brings its own window and stride.
    browser.value(
        "(() => { const plan = document.getElementById('plan'); plan.value = 'hand'; \
         plan.dispatchEvent(new Event('input', { bubbles: true })); \
         document.getElementById('settings-send').click(); })()",
    );
    browser.wait("document.getElementById('settings-message').textContent.includes('1458.')");
    browser.wait("Math.abs(Number(document.getElementById('window_s').value) - 0.373) < 0.001");
    assert_quiet(&browser, &view);
    // Nobody sees the page: the board stops three seconds after somebody has asked for its state,
    // and goes on with the page.
    let see = |browser: &mut Browser, hidden: bool| {
        browser.value(&format!(
            "(() => {{ Object.defineProperty(document, 'hidden', {{ value: {hidden}, configurable: true }}); \
             document.dispatchEvent(new Event('visibilitychange')); }})()"
        ));
    };
    see(&mut browser, true);
    sleep(Duration::from_secs(1));
    let before_s = now_s();
    sleep(Duration::from_secs(6));
    let passed_s = now_s() - before_s;
    assert!((0.0..4.5).contains(&passed_s), "{passed_s} s");
    see(&mut browser, false);
    let later_s = before_s + passed_s + 4.0;
    browser.wait(&format!(
        "parseFloat(document.getElementById('source').textContent.split(', ').at(-1)) > {later_s}"
    ));
}

#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn one_wild_estimate_and_one_spike_stretch_no_axis() {
    let folder = common::directory();
    let plain = packets(3.2);
    let mut wild = plain.clone();
    let mut estimates = wild
        .iter_mut()
        .filter(|packet| matches!(packet.event, Event::Estimate(_)));
    if let Some(Packet {
        event: Event::Estimate(estimate),
        ..
    }) = estimates.nth(1)
    {
        (estimate.frequency, estimate.status) = (90.0, Status::Ambiguous);
    }
    let mut frames = wild
        .iter_mut()
        .filter(|packet| matches!(packet.event, Event::Raw(_)));
    if let Some(Packet {
        event: Event::Raw(raw),
        ..
    }) = frames.nth(700)
    {
        raw.codes = [7_000_000; 16];
    }
    let mut axes_shown = Vec::new();
    for (name, packets) in [("plain.rec", &plain), ("wild.rec", &wild)] {
        let path = recorded_as(folder.path(), name, packets);
        let view = View::start(&["--file", common::text(&path), "--pace", "0"]);
        let mut browser = open(&view);
        browser.wait("document.querySelector('#fit .empty').hidden");
        let axes = "['strips', 'history'].map((id) => document.querySelector(`#${id} .plot`).getAttribute('aria-description'))";
        axes_shown.push((browser.value(axes), text(&mut browser, "history-small")));
        assert_drawn(&mut browser, &["strips", "history", "spectrum", "fit"]);
        assert_eq!(browser.errors(), Vec::<String>::new());
    }
    assert_eq!(
        axes_shown[0].0[0], axes_shown[1].0[0],
        "the rows of the channels"
    );
    assert!(
        axes_shown[0].1.is_empty() && axes_shown[1].1 == "1 beyond the axis",
        "{axes_shown:?}"
    );
    let ends = |axes_shown: &Value| -> Vec<f64> {
        axes_shown
            .as_str()
            .expect("a range")
            .split(' ')
            .filter_map(|word| word.parse().ok())
            .collect()
    };
    let (plain, wild) = (ends(&axes_shown[0].0[1]), ends(&axes_shown[1].0[1]));
    assert!(
        wild[1] - wild[0] < 3.0 * (plain[1] - plain[0]),
        "{plain:?} and {wild:?}"
    );
}

/// The picture of the page that the documents show, in the folder that `cargo xtask pictures`
/// names.
#[test]
#[ignore = "needs the firmware image and a browser; cargo xtask test builds and installs them"]
fn the_picture_of_the_page_shows_the_period_of_the_first_scene() {
    let view = View::start(&["--emulated"]);
    let mut browser = Browser::start(Look {
        width: 1280,
        height: 978,
        dark: false,
    });
    browser.call("Emulation.setScrollbarsHidden", json!({"hidden": true}));
    browser.open(&view.url);
    browser.wait("/, 5\\.[34] s$/.test(document.querySelector('#source')?.textContent)");
    let period = text(&mut browser, "period");
    let (mm, sigma_mm) = period
        .trim_end_matches(" mm")
        .split_once(" ± ")
        .unwrap_or_else(|| panic!("{period}"));
    let apart_mm = (mm.parse::<f64>().expect("mm") - 3.6).abs();
    assert!(
        apart_mm < 2.0 * sigma_mm.parse::<f64>().expect("mm"),
        "{period}"
    );
    assert_drawn(
        &mut browser,
        &["strips", "history", "spectrum", "fit", "map"],
    );
    let taken = browser.call("Page.captureScreenshot", json!({"format": "png"}));
    let kept = std::env::var_os("RIDGETONE_PICTURES");
    let folder = common::directory();
    let path = kept
        .map_or_else(|| folder.path().to_owned(), PathBuf::from)
        .join("view.png");
    std::fs::write(&path, base64(taken["data"].as_str().expect("a picture"))).expect("a file");
    assert!(
        std::fs::read(&path)
            .expect("a file")
            .starts_with(b"\x89PNG")
    );
}

/// The bytes of a text in base 64 (RFC 4648, section 4).
fn base64(text: &str) -> Vec<u8> {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digit = |byte: &u8| {
        DIGITS
            .iter()
            .position(|digit| digit == byte)
            .map(|digit| digit as u32)
    };
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
    assert_drawn(
        &mut browser,
        &["strips", "history", "spectrum", "fit", "map"],
    );
    let looks = [
        ("light", LOOK),
        ("dark", Look { dark: true, ..LOOK }),
        ("phone", PHONE),
        (
            "phone-dark",
            Look {
                dark: true,
                ..PHONE
            },
        ),
    ];
    for (name, look) in looks {
        browser.look(look);
        sleep(Duration::from_millis(700));
        let wide = browser
            .value("document.documentElement.scrollWidth")
            .as_u64();
        assert!(wide <= Some(u64::from(look.width)), "{name}: {wide:?}");
        let found = browser.value(include_str!("readable.js"));
        assert_eq!(found, json!([]), "{name}");
        if look.width == PHONE.width {
            assert_eq!(browser.value(TARGETS), json!([]), "{name}");
        }
        assert_drawn(&mut browser, &["strips", "history", "map"]);
    }
    browser.look(LOOK);
    let pixels = |browser: &mut Browser| {
        browser.value("document.querySelector('#strips canvas').toDataURL()")
    };
    let before = pixels(&mut browser);
    sleep(Duration::from_millis(500));
    let after = pixels(&mut browser);
    assert_ne!(before, after, "it is live");
    browser.value("document.getElementById('pause').click()");
    sleep(Duration::from_millis(300));
    let (still, received) = (pixels(&mut browser), text(&mut browser, "lost-small"));
    sleep(Duration::from_millis(700));
    assert_eq!(
        (pixels(&mut browser), text(&mut browser, "lost-small")),
        (still.clone(), received),
        "it is paused"
    );
    browser.value("document.getElementById('pause').click()");
    sleep(Duration::from_millis(500));
    assert_ne!(pixels(&mut browser), still, "it goes on");
    assert_quiet(&browser, &view);
}
