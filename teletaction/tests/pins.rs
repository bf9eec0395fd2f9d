//! Tests `ridgetone pins`: matching, limits, refused options, and the emulated touch on a display.

#[path = "../../host/tests/common/mod.rs"]
mod common;
#[path = "pins/limits.rs"]
mod limits;
#[path = "pins/matching.rs"]
mod matching;

use common::{assert_one_line, json_lines, run};
use serde_json::Value;

fn numbers(object: &Value, name: &str) -> Vec<f64> {
    let values = object[name]
        .as_array()
        .unwrap_or_else(|| panic!("{name} in {object}"));
    values
        .iter()
        .map(|value| value.as_f64().expect("a number"))
        .collect()
}

#[test]
fn what_makes_no_sense_is_refused() {
    for (arguments, word) in [
        (
            &["pins", "--emulated", "--pins", "11x10"][..],
            "at most 100",
        ),
        (&["pins", "--emulated", "--slew-n-s", "0.01"], "faster slew"),
        (&["pins", "--emulated", "--depth-mm", "0.01"], "depth_mm"),
        (
            &["pins", "--emulated", "--regularisation", "11"],
            "regularisation",
        ),
    ] {
        assert_one_line(&run(arguments), 2, &[word]);
    }
}

/// The finger presses with 1 N. In the hold before the slide, the pins must press with about as
/// much, and the person must feel the sensor's strains.
#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn the_emulated_touch_is_on_the_pins() {
    let updates = json_lines(&run(&[
        "pins",
        "--emulated",
        "--once",
        "--pace",
        "0",
        "--json",
    ]));
    assert!(updates.len() > 100, "{}", updates.len());
    let mut max = 0.0f64;
    for (before, now) in updates.iter().zip(&updates[1..]) {
        let [before_n, now_n] = [before, now].map(|update| numbers(update, "forces_n"));
        assert!(now_n.iter().all(|n| (0.0..=2.0).contains(n)), "{now}");
        // 20 N/s at 20 Hz are 1 N per update.
        assert!(
            now_n
                .iter()
                .zip(&before_n)
                .all(|(now, before)| (now - before).abs() < 1.0001),
            "{now}"
        );
        max = max.max(now_n.iter().sum());
    }
    let at = |t_s: f64| {
        updates
            .iter()
            .find(|update| update["t_s"].as_f64() > Some(t_s))
            .expect("an update")
    };
    // Contact at 0.51 s, then the hold; the slide starts at 1.51 s.
    let (air, hold) = (at(0.4), at(1.4));
    assert_eq!(numbers(air, "forces_n").iter().sum::<f64>(), 0.0);
    let all_n: f64 = numbers(hold, "forces_n").iter().sum();
    assert!((0.4..1.6).contains(&all_n), "{hold}");
    let (felt, sensor) = (numbers(hold, "felt_strain"), numbers(hold, "sensor_strain"));
    let rms = |values: &mut dyn Iterator<Item = f64>| {
        (values.map(|value| value * value).sum::<f64>() / 16.0).sqrt()
    };
    let off = rms(&mut felt.iter().zip(&sensor).map(|(felt, sensor)| felt - sensor));
    assert!(
        off < 0.3 * rms(&mut sensor.iter().copied()),
        "{off}: {hold}"
    );
    // The ridges press more during the slide than the hold does.
    assert!(max > 1.5 * all_n, "{max} {all_n}");
}
