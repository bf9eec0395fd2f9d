//! Tests the page in a browser: its WebAssembly against the crate, the path from the pointer to the
//! sound, and new textures.

mod browser;
mod latency;

use crate::common::{directory, file, ridgetone, text};
use browser::{Browser, Look};
use latency::{best, measure_undisturbed};
use ridgetone_teletaction::stimulus::{
    Actuator, AmplitudeLaw, Delay, Harmonic, Texture, Vibration,
};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::Duration;

const LOOK: Look = Look {
    width: 1280,
    height: 800,
    dark: false,
};

struct Touch {
    child: Child,
    url: String,
}

impl Touch {
    fn start(arguments: &[&str]) -> Self {
        let mut command = ridgetone();
        command.arg("touch").args(arguments);
        let mut child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the command runs");
        let mut url = String::new();
        BufReader::new(child.stdout.take().expect("a pipe"))
            .read_line(&mut url)
            .expect("a line");
        Self {
            child,
            url: url.trim().to_owned(),
        }
    }
}

impl Drop for Touch {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn open(arguments: &[&str]) -> (Touch, Browser) {
    let touch = Touch::start(arguments);
    let mut browser = Browser::start(LOOK);
    browser.open(&touch.url);
    browser.wait("/ mm$/.test(document.getElementById('period')?.textContent ?? '')");
    (touch, browser)
}

fn mouse(browser: &mut Browser, kind: &str, x: f64, y: f64) {
    let buttons = i32::from(kind != "mouseReleased");
    let mouse = json!({"type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1});
    browser.call("Input.dispatchMouseEvent", mouse);
}

/// Moves the pointer without waiting for the page, as a hand does.
fn drag(browser: &mut Browser, x: f64, y: f64) {
    let mouse = json!({"type": "mouseMoved", "x": x, "y": y, "button": "left", "buttons": 1});
    browser.tell("Input.dispatchMouseEvent", mouse);
}

/// Clicks as a person does, because browsers require this for sound.
fn click(browser: &mut Browser, id: &str) {
    let position = browser.value(&format!(
        "(({{ left, top, width, height }}) => [left + width / 2, top + height / 2])(document.getElementById('{id}').getBoundingClientRect())"
    ));
    let [x, y] = [0, 1].map(|n| position[n].as_f64().expect("a position"));
    for kind in ["mousePressed", "mouseReleased"] {
        mouse(browser, kind, x, y);
    }
}

/// Turns the sound on, and waits until it plays.
fn sound_on(browser: &mut Browser) {
    click(browser, "sound");
    browser.wait("globalThis.ridgetone?.context.state === 'running' && globalThis.ridgetone.context.currentTime > 0.2");
}

/// Left end, middle and width of the surface, CSS pixels.
fn surface(browser: &mut Browser) -> (f64, f64, f64) {
    let found = browser.value(
        "(({ left, top, width, height }) => [left, top + height / 2, width])(document.getElementById('surface').getBoundingClientRect())",
    );
    let [left, middle, width] = [0, 1, 2].map(|n| found[n].as_f64().expect("a number"));
    (left, middle, width)
}

/// The browser's samples must equal the crate's on this computer bit for bit, also through jumps,
/// delays and refusals.
#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn the_web_assembly_is_the_crate_bit_for_bit() {
    let folder = directory();
    let (_touch, mut browser) = open(&[text(&file(folder.path(), "t.toml", "period_mm = 1.4\n"))]);
    let mut native = Vibration::<1024>::new(
        Actuator::PIEZO,
        AmplitudeLaw {
            power_max: 1.0,
            ..AmplitudeLaw::OKAMOTO
        },
        48_000.0,
    )
    .expect("a vibration");
    let (mut calls, mut expected) = (Vec::new(), Vec::new());
    let exact = |values: &[f32]| values.iter().map(|v| f64::from(*v)).collect::<Vec<f64>>();
    for step in 0..400u32 {
        let t_s = 0.0037 * f64::from(step);
        match step {
            150 => {
                native.lift();
                calls.push(json!(["lift", []]));
            }
            10 | 90 | 210 => {
                let period_mm = 0.7 + 0.01 * step as f32;
                let overtones = [(0.3, 0.1), (0.0, 0.0), (0.2, -0.4)];
                let texture = Texture {
                    power: 0.4,
                    overtones: overtones.map(|(amplitude, phase_cycles)| Harmonic {
                        amplitude,
                        phase_cycles,
                    }),
                    ..Texture::new(period_mm)
                };
                native.set_texture(&texture).expect("a texture");
                let values = [period_mm, 0.4, 0.3, 0.1, 0.0, 0.0, 0.2, -0.4];
                calls.push(json!(["texture", exact(&values)]));
            }
            50 | 300 => {
                let sigma_s = if step == 300 { 0.04 } else { 0.0 };
                let delay = Delay::new(0.12, sigma_s, 1).expect("a delay");
                native.set_delay(delay, 0.02).expect("a delay");
                calls.push(json!(["delay", exact(&[0.12, sigma_s, 0.02])]));
            }
            170 | 260 => {
                let carrier_hz = (step == 170).then_some(187.0);
                native.set_carrier(carrier_hz).expect("a carrier");
                calls.push(json!(["carrier", [carrier_hz.unwrap_or(0.0)]]));
            }
            // Refused calls must not change anything.
            59 => calls.push(json!(["carrier", [20]])),
            60 => calls.push(json!(["texture", [-3, 1, 0, 0, 0, 0, 0, 0]])),
            61 => calls.push(json!(["texture", [null, 1, 0, 0, 0, 0, 0, 0]])),
            _ => {}
        }
        let position_mm = 40.0 * (2.3 * t_s).sin() + if step > 250 { 1000.0 } else { 0.0 };
        native.down(t_s, position_mm);
        calls.push(json!(["down", [t_s, position_mm]]));
        let first = u64::from(step) * 178;
        calls.push(json!(["samples", [first]]));
        expected.extend((first..first + 178).map(|n| native.next(n as f64 / 48_000.0).to_bits()));
    }
    let found = browser.value(&format!(
        "(async () => {{ \
            const module = await WebAssembly.compile(await (await fetch('/stimulus.wasm')).arrayBuffer()); \
            const core = new WebAssembly.Instance(module).exports; \
            core.begin(150, 310, 220000, Math.fround(0.02), 48000); \
            const found = []; \
            for (const [what, values] of {}) {{ \
                if (what !== 'samples') core[what](...values.map((value) => value ?? NaN)); \
                else for (let n = values[0]; n < values[0] + 178; n += 1) found.push(core.sample(n / 48000)); \
            }} \
            return [...new Uint32Array(Float32Array.from(found).buffer)]; }})()",
        json!(calls)
    ));
    let found: Vec<u32> = serde_json::from_value(found).expect("bits");
    assert_eq!((found.len(), expected.len()), (71_200, 71_200));
    let differ = found.iter().zip(&expected).filter(|(a, b)| a != b);
    assert_eq!(differ.count(), 0, "of {} samples", found.len());
    let loudest = expected
        .iter()
        .map(|bits| f32::from_bits(*bits).abs())
        .fold(0.0, f32::max);
    assert!(loudest > 0.3, "{loudest}");
    assert_eq!(browser.errors(), Vec::<String>::new());
}

/// The sound must be the texture at the position of the pointer, delayed by the wait, the output,
/// the browser's own time and an additional delay.
#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn from_the_pointer_to_the_sound() {
    let folder = directory();
    let (touch, mut browser) = open(&[text(&file(folder.path(), "t.toml", "period_mm = 1.4\n"))]);
    sound_on(&mut browser);
    let mut latencies = Vec::new();
    for (delay_ms, wait_ms) in [(0.0, 20.0), (0.0, 100.0), (120.0, 100.0)] {
        browser.value(&format!(
            "(() => {{ const select = document.getElementById('condition'); select.value = '{delay_ms},0'; \
             document.getElementById('wait_ms').value = '{wait_ms}'; \
             select.dispatchEvent(new Event('change')); globalThis.ridgetone.recorded = null; }})()"
        ));
        let measured = measure_undisturbed(&mut browser, wait_ms / 1e3);
        let loudest = measured
            .sound
            .iter()
            .map(|(_, y)| y.abs())
            .fold(0.0, f64::max);
        assert!((0.3..0.5).contains(&loudest), "{loudest}");
        let slew = f64::from(Actuator::PIEZO.slew_v_s) / 75.0 / measured.rate_hz;
        let steps = measured
            .sound
            .windows(2)
            .map(|pair| (pair[1].1 - pair[0].1).abs());
        let max = steps.fold(0.0, f64::max);
        assert!(max <= slew + 1e-5, "{max} of {slew}");
        let (latency_s, rms, worst) = best(&measured, 1.4);
        println!(
            "delay {delay_ms} ms: {} positions of the pointer; pointer to sample {:.1} ms, of which {wait_ms:.1} ms are the wait and {:.1} ms \
             lie between the clocks (the output is {:.1} ms, as the browser says); phase error {rms:.4} cycles rms, {worst:.4} at most in 20 ms",
            measured.pointer.len(),
            1e3 * latency_s,
            1e3 * measured.clocks_s,
            1e3 * measured.output_s,
        );
        latencies.push((
            latency_s - (delay_ms + wait_ms) / 1e3,
            rms,
            measured.clocks_s,
        ));
    }
    // If the next position is always known, the sound must be the texture under the pointer with
    // the stated latency. Other programs disturb the browser's output, so its clocks shift against
    // each other between measurements.
    for (rest_s, rms, clocks_s) in &latencies[1..] {
        assert!(*rms < 0.02 && (0.0..0.1).contains(rest_s), "{latencies:?}");
        assert!((rest_s - clocks_s).abs() < 0.005, "{latencies:?}");
    }
    assert_eq!(browser.errors(), Vec::<String>::new());
    assert!(
        browser
            .requests()
            .iter()
            .all(|url| url.starts_with(&touch.url)),
        "{:?}",
        browser.requests()
    );
}

fn text_of(browser: &mut Browser, id: &str) -> String {
    browser
        .value(&format!("document.getElementById('{id}').textContent"))
        .as_str()
        .expect("a text")
        .to_owned()
}

/// A user's texture must be felt at once. An impossible one must be refused with an explanation,
/// and the previous one kept.
#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn textures_change_and_impossible_ones_do_not() {
    let folder = directory();
    let (touch, mut browser) = open(&[text(&file(folder.path(), "t.toml", "period_mm = 1.4\n"))]);
    let post = |browser: &mut Browser, body: &str| -> Value {
        browser.value(&format!(
            "(async () => {{ const answer = await fetch('/texture', {{ method: 'POST', body: '{body}' }}); return [answer.status, await answer.text()]; }})()"
        ))
    };
    assert_eq!(
        post(&mut browser, r#"{"period_mm": 0.9}"#),
        json!([200, ""])
    );
    browser.wait("document.getElementById('period').textContent === '0.9 mm'");
    for (body, word) in [
        (r#"{"period_mm": -1}"#, "choose a value from 0.05 to 100"),
        (r#"{"period_mm": 1e99}"#, "period_mm"),
        (r#"{"period_mm": null}"#, "no texture"),
        ("nonsense", "no texture"),
    ] {
        let answer = post(&mut browser, body);
        assert!(
            answer[0] == 422 && answer[1].as_str().expect("a text").contains(word),
            "{body}: {answer}"
        );
    }
    browser.value("document.getElementById('period_mm').value = '1.7'");
    browser.value("document.querySelector('#own button').click()");
    browser.wait("document.getElementById('period').textContent === '1.7 mm'");
    // The page reports the command's end, and the vibration fades.
    drop(touch);
    browser.wait(
        "document.getElementById('status').textContent.startsWith('The command cannot be reached')",
    );
}

/// Holding an arrow key must move the hand at a steady speed, and the carrier must be heard
/// meanwhile.
#[test]
#[ignore = "needs a browser; cargo xtask test installs one"]
fn arrow_keys_move_the_hand_and_a_carrier_is_heard() {
    let folder = directory();
    let texture = file(folder.path(), "t.toml", "period_mm = 1.4\n");
    let (_touch, mut browser) = open(&[text(&texture), "--carrier-hz", "180"]);
    let chosen = browser.value("document.getElementById('carrier_hz').value");
    assert_eq!(chosen, "180");
    assert!(text_of(&mut browser, "hint").contains("Sound on"));
    sound_on(&mut browser);
    // Use a wait that suits a busy computer.
    browser.value("(() => { const wait = document.getElementById('wait_ms'); wait.value = '100'; wait.dispatchEvent(new Event('change')); })()");
    browser.value("document.getElementById('surface').focus()");
    let key = |browser: &mut Browser, kind: &str, key: &str| {
        browser.call("Input.dispatchKeyEvent", json!({"type": kind, "key": key}));
    };
    key(&mut browser, "keyDown", "ArrowDown");
    key(&mut browser, "keyDown", "ArrowRight");
    browser.wait("document.getElementById('speed').textContent === '20 mm/s'");
    assert!(text_of(&mut browser, "hint").contains("20 mm/s"));
    sleep(Duration::from_millis(500));
    browser.value("globalThis.ridgetone.node.port.postMessage({ what: 'record', values: [1] })");
    browser.wait("globalThis.ridgetone.recorded !== null");
    let samples = browser.value("[...globalThis.ridgetone.recorded.samples]");
    let samples: Vec<f64> = serde_json::from_value(samples).expect("samples");
    let loudest = samples.iter().fold(0.0f64, |max, y| max.max(y.abs()));
    assert!(loudest > 0.2, "{loudest}");
    // A stalled browser takes the hand for resting and fades the tone, so use the median cycle.
    let rate_hz = browser.value("globalThis.ridgetone.recorded.rate_hz");
    let rises: Vec<usize> = (1..samples.len())
        .filter(|n| samples[n - 1] < 0.0 && samples[*n] >= 0.0)
        .collect();
    let mut cycles: Vec<usize> = rises.windows(2).map(|pair| pair[1] - pair[0]).collect();
    cycles.sort_unstable();
    assert!(cycles.len() > 20, "{} cycles", cycles.len());
    let usual_s = cycles[cycles.len() / 2] as f64 / rate_hz.as_f64().expect("a rate");
    assert!((usual_s * 180.0 - 1.0).abs() < 0.02, "{usual_s} s");
    key(&mut browser, "keyUp", "ArrowRight");
    browser.wait("document.getElementById('speed').textContent === '0 mm/s'");
    assert_eq!(browser.errors(), Vec::<String>::new());
}

/// The finger's texture must arrive during a slide of the emulated board.
#[test]
#[ignore = "needs the emulator and a browser; cargo xtask test installs one"]
fn the_emulated_fingers_texture_is_on_the_page() {
    let (_touch, mut browser) = open(&["--emulated"]);
    let period = text_of(&mut browser, "period");
    let period_mm = period.split_once(" ± ").expect("a period with its sigma").0;
    let period_mm: f64 = period_mm.parse().expect("a number");
    assert!((period_mm - 3.6).abs() < 0.1, "{period}");
    assert_eq!(text_of(&mut browser, "source"), "emulated board");
    assert_eq!(
        text_of(&mut browser, "status"),
        "The texture under the finger."
    );
}
