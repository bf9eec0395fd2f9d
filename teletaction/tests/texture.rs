//! `ridgetone texture`: a texture of the default scene, 3.6 mm at 30 mm/s, and what is refused.

#[path = "../../host/tests/common/mod.rs"]
mod common;

use common::{assert_one_line, directory, file, json_lines, run, text};
use hal_mock::{Sliding, SlidingScene, write_csv};
use ridgetone_host::input::{SLOT_S, frame_rate_hz};
use std::path::Path;

/// Writes the default scene, as `ridgetone emulate --print-scene` does.
fn write_scene(path: &Path) {
    let mut scene = SlidingScene::new(Sliding::default()).expect("a scene");
    let file = std::fs::File::create(path).expect("a file");
    write_csv(&mut scene, frame_rate_hz(), SLOT_S, file).expect("written");
}

#[test]
fn a_texture_is_learned_written_and_read() {
    let folder = directory();
    let recording = folder.path().join("recording.csv");
    write_scene(&recording);
    let written = folder.path().join("mine.toml");
    let slide = ["--speed", "30+-0.03", "--from", "1.6", "--to", "3.2"];
    let learn = ["texture", "learn", text(&recording)];
    let [texture] = &json_lines(&run(&[
        &learn[..],
        &slide[..],
        &["-o", text(&written), "--json"],
    ]
    .concat()))[..] else {
        panic!("one line")
    };
    let number = |name: &str| {
        texture[name]
            .as_f64()
            .unwrap_or_else(|| panic!("{name}: {texture}"))
    };
    assert_eq!(texture["type"], "texture");
    let (period_mm, sigma_mm) = (number("period_mm"), number("period_sigma_mm"));
    assert!(
        (period_mm - 3.6).abs() < 4.0 * sigma_mm && (0.0036..0.02).contains(&sigma_mm),
        "{texture}"
    );
    assert!(number("power") > 0.0);
    let read = ridgetone_teletaction::texture::load(&written).expect("a texture");
    assert!((f64::from(read.period_mm) - period_mm).abs() < 1e-6);
    // No file is replaced.
    assert_one_line(
        &run(&[&learn[..], &slide[..], &["-o", text(&written)]].concat()),
        1,
        &["mine.toml", "--force"],
    );
}

/// The whole touch: its holds are no texture.
#[test]
fn the_slide_of_a_touch_is_learned() {
    let folder = directory();
    let recording = folder.path().join("recording.csv");
    write_scene(&recording);
    let learn = ["texture", "learn", text(&recording), "--json"];
    let texture = json_lines(&run(&[&learn[..], &["--speed", "30"]].concat())).remove(0);
    let number = |name: &str| texture[name].as_f64().expect("a number");
    let (period_mm, sigma_mm) = (number("period_mm"), number("period_sigma_mm"));
    assert!(
        (period_mm - 3.6).abs() < 4.0 * sigma_mm && sigma_mm < 0.01,
        "{texture}"
    );
}

/// Two tones that are no harmonics of one another have no period at one speed.
#[test]
fn only_good_fits_are_learned_unless_any_is_accepted() {
    let folder = directory();
    let two = (0..2000).fold("when,a\n".to_owned(), |csv, row| {
        let t_s = f64::from(row) * 1e-3;
        let sine = |hz: f64| (std::f64::consts::TAU * hz * t_s).sin();
        let noise = f64::from(row * 7919 % 1009) * 1e-4;
        let value = sine(10.0) + 0.5 * sine(17.3) + noise;
        format!("{csv}{row},{value:.6}\n")
    });
    let path = file(folder.path(), "two.csv", &two);
    let learn = |more: &[&str]| {
        let options = [
            "texture",
            "learn",
            text(&path),
            "--speed",
            "30",
            "--time-column",
            "when:ms",
        ];
        run(&[&options[..], more].concat())
    };
    assert_one_line(&learn(&[]), 1, &["two.csv", "`ambiguous`", "--accept"]);
    assert!(learn(&["--accept"]).status.success());
}

#[test]
fn what_is_no_texture_is_refused() {
    let folder = directory();
    let recording = folder.path().join("recording.csv");
    write_scene(&recording);
    let learn = |more: &[&str]| run(&[&["texture", "learn", text(&recording)], more].concat());
    assert_one_line(&learn(&[]), 2, &["--speed"]);
    assert_one_line(&learn(&["--speed", "0"]), 2, &["greater than 0"]);
    // Nothing moves before the contact.
    assert_one_line(
        &learn(&["--speed", "30", "--to", "0.4"]),
        1,
        &["no tone", "--from"],
    );
    let bad = file(folder.path(), "bad.toml", "period_mm = -1.0\n");
    assert_one_line(&run(&["texture", "law", text(&bad)]), 1, &["bad.toml"]);
}
