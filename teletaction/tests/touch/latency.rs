//! Measures the latency of the page's sound: the pointer moves, the page records its sound, and a
//! latency is fitted to both.

use super::browser::Browser;
use super::{drag, mouse, surface};
use std::f64::consts::TAU;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A vibration recorded by the page, and the pointer's events recorded by a separate listener.
pub struct Measured {
    /// Times on the page's clock (seconds) and positions (millimetres).
    pub pointer: Vec<(f64, f64)>,
    /// Times on the page's clock at which samples are heard (seconds), and the samples.
    pub sound: Vec<(f64, f64)>,
    pub rate_hz: f64,
    /// Maximum time from a position of the pointer until the page received the next different one,
    /// seconds.
    unknown_s: f64,
    /// Drift between the clocks of page and sound during the measurement, seconds: the larger of
    /// what the test and the page measured.
    slipped_s: f64,
    /// Time from a position until it is heard, without the wait, seconds. Computed only from
    /// clocks: the page compares its clock with the sound that it produces, the test with the sound
    /// that is heard.
    pub clocks_s: f64,
    /// Latency of only the output, as reported by the browser, seconds.
    pub output_s: f64,
}

/// Returns the difference between the page's clock and that of the audible sound, seconds: the
/// median of several readings, because the browser rounds each.
fn clocks(browser: &mut Browser) -> f64 {
    let mut offsets: Vec<f64> = serde_json::from_value(browser.value(
        "(async () => { const found = []; for (let n = 0; n < 20; n += 1) { \
         const { contextTime, performanceTime } = globalThis.ridgetone.context.getOutputTimestamp(); \
         found.push(performanceTime / 1e3 - contextTime); await new Promise((done) => setTimeout(done, 11)); } return found; })()",
    ))
    .expect("clocks");
    offsets.sort_by(f64::total_cmp);
    offsets[offsets.len() / 2]
}

/// Moves the pointer back and forth over the surface for two seconds.
fn measure(browser: &mut Browser) -> Measured {
    let (left, y, width) = surface(browser);
    browser.value(
        "(() => { if (globalThis.seen) { globalThis.seen.length = 0; return; } globalThis.seen = []; const surface = document.getElementById('surface'); \
         const keep = (event) => { const all = event.getCoalescedEvents(); for (const one of all.length ? all : [event]) \
         globalThis.seen.push([one.timeStamp / 1e3, performance.now() / 1e3, (one.clientX - surface.getBoundingClientRect().left) * 25.4 / 96]); }; \
         for (const kind of ['pointerdown', 'pointerrawupdate']) surface.addEventListener(kind, keep); })()",
    );
    // 500 CSS pixels are 132 mm, and the speed is up to 110 mm/s.
    let position = |t_s: f64| left + 0.1 * width + 500.0 * (0.5 - 0.5 * (TAU * 0.265 * t_s).cos());
    mouse(browser, "mouseMoved", position(0.0), y);
    let before = clocks(browser);
    browser.value("globalThis.ridgetone.recorded = null; globalThis.ridgetone.node.port.postMessage({ what: 'record', values: [2.2] })");
    mouse(browser, "mousePressed", position(0.0), y);
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(2) {
        drag(browser, position(begun.elapsed().as_secs_f64()), y);
        sleep(Duration::from_millis(6));
    }
    let offset = clocks(browser);
    mouse(browser, "mouseReleased", position(2.0), y);
    browser.wait("globalThis.ridgetone.recorded !== null");
    let found = browser.value(
        "({ ...globalThis.ridgetone.recorded, seen: globalThis.seen, \
         output_s: globalThis.ridgetone.context.baseLatency + (globalThis.ridgetone.context.outputLatency || 0) })",
    );
    let number = |name: &str| found[name].as_f64().expect("a number");
    let samples = found["samples"]
        .as_array()
        .expect("samples")
        .iter()
        .enumerate();
    let heard_s = |n: usize| number("from_s") + n as f64 / number("rate_hz") + offset;
    let [min_s, max_s] = [0, 1].map(|n| found["offsets_s"][n].as_f64().expect("an offset"));
    let seen: Vec<(f64, f64, f64)> =
        serde_json::from_value(found["seen"].clone()).expect("positions");
    Measured {
        pointer: seen.iter().map(|(at_s, _, x_mm)| (*at_s, *x_mm)).collect(),
        // Ignore small steps: a hand that turns reports nothing for a moment.
        unknown_s: (seen
            .windows(2)
            .filter(|pair| (pair[1].2 - pair[0].2).abs() > 0.3))
        .map(|pair| pair[1].1 - pair[0].0)
        .fold(0.0, f64::max),
        slipped_s: (offset - before).abs().max(max_s - min_s),
        clocks_s: min_s + offset,
        sound: samples
            .map(|(n, y)| (heard_s(n), y.as_f64().expect("a sample")))
            .collect(),
        rate_hz: number("rate_hz"),
        output_s: number("output_s"),
    }
}

/// Repeats the measurement until other programs disturb neither the pointer's positions nor the
/// sound.
pub fn measure_undisturbed(browser: &mut Browser, wait_s: f64) -> Measured {
    for _ in 0..10 {
        let measured = measure(browser);
        // The first wait suits a pointer at 60 Hz. Rare late positions are allowed with this wait,
        // because no requirement applies to its figures.
        let is_known = wait_s < 0.05 || measured.unknown_s < 0.8 * wait_s;
        // The sound has up to 79 cycles a second, so a latency in the middle of such a drift is off
        // by 0.02 cycles at either end.
        if is_known && measured.slipped_s < 0.000_5 {
            return measured;
        }
        println!(
            "disturbed: a position was unknown for {:.0} ms, the clocks slipped {:.1} ms; again",
            1e3 * measured.unknown_s,
            1e3 * measured.slipped_s
        );
    }
    panic!("this computer is too busy to measure on");
}

fn position_mm(pointer: &[(f64, f64)], t_s: f64) -> f64 {
    let n = pointer
        .partition_point(|(at_s, _)| *at_s <= t_s)
        .clamp(1, pointer.len() - 1);
    let ((from_s, from_mm), (to_s, to_mm)) = (pointer[n - 1], pointer[n]);
    from_mm + (to_mm - from_mm) * ((t_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0)
}

/// Phase errors in cycles, one for each 20 ms segment in which the hand moves faster than 40 mm/s,
/// assuming that the sound lags by `latency_s`.
fn phase_errors(measured: &Measured, period_mm: f64, latency_s: f64) -> Vec<f64> {
    let first_s = measured.pointer[0].0;
    let stretches = measured
        .sound
        .chunks_exact((0.02 * measured.rate_hz) as usize)
        .filter_map(|stretch| {
            let [from_s, to_s] = [
                stretch[0].0 - latency_s,
                stretch[stretch.len() - 1].0 - latency_s,
            ];
            // The vibration fades in within 20 ms.
            if from_s < first_s + 0.1 || to_s > first_s + 1.95 {
                return None;
            }
            let speed = (position_mm(&measured.pointer, to_s)
                - position_mm(&measured.pointer, from_s))
            .abs()
                / 0.02;
            if speed < 40.0 {
                return None;
            }
            let (mut ss, mut sc, mut cc, mut ys, mut yc) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for (t_s, y) in stretch {
                let (s, c) =
                    (TAU * position_mm(&measured.pointer, t_s - latency_s) / period_mm).sin_cos();
                (ss, sc, cc, ys, yc) = (ss + s * s, sc + s * c, cc + c * c, ys + y * s, yc + y * c);
            }
            let det = ss * cc - sc * sc;
            Some(((yc * ss - ys * sc) / det).atan2((ys * cc - yc * sc) / det) / TAU)
        });
    stretches.collect()
}

/// Minimises the mean squared phase error over latencies from 0 to 0.4 s. Returns the latency, the
/// RMS error and the maximum error.
pub fn best(measured: &Measured, period_mm: f64) -> (f64, f64, f64) {
    let rms = |errors: &[f64]| {
        (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt()
    };
    let try_each = |first: f64, step: f64, count: u32| {
        let tried = (0..count)
            .map(|n| first + step * f64::from(n))
            .map(|latency_s| {
                let errors = phase_errors(measured, period_mm, latency_s);
                assert!(errors.len() > 20, "{}", errors.len());
                (
                    latency_s,
                    rms(&errors),
                    errors.iter().fold(0.0f64, |worst, e| worst.max(e.abs())),
                )
            });
        tried.min_by(|a, b| a.1.total_cmp(&b.1)).expect("a latency")
    };
    // A cycle lasts at least 12 ms, so these steps find the minimum.
    let (coarse_s, ..) = try_each(0.0, 0.002, 200);
    try_each((coarse_s - 0.003).max(0.0), 0.000_25, 24)
}
