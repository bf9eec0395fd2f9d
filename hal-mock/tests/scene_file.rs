//! Tests the shipped scene files, the shortest one, and the errors for invalid ones.

use hal_mock::{Sliding, SlidingScene, TABLE_2, load_scene, parse_scene};
use std::path::PathBuf;

/// Frame rate of the project's scan, hertz.
const FRAME_RATE_HZ: f64 = 241.14;

fn shipped(name: &str) -> Sliding {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(name);
    load_scene(path, FRAME_RATE_HZ).unwrap_or_else(|error| panic!("{error}"))
}

fn error(text: &str) -> String {
    let error = parse_scene("a.toml", text, FRAME_RATE_HZ)
        .unwrap_err()
        .to_string();
    assert!(!error.contains('\n'), "{error}");
    error
}

#[test]
fn the_papers_combinations_are_table_2() {
    for ((speed_mm_s, period_mm), number) in TABLE_2.into_iter().zip(1..) {
        let scene = shipped(&format!("c{number}.toml"));
        assert_eq!(
            scene,
            Sliding {
                speed_mm_s,
                period_mm,
                reverse: true,
                ..Sliding::physical()
            }
        );
        let truth = SlidingScene::new(scene).unwrap().truth();
        assert!((truth.frequency_hz - speed_mm_s / period_mm).abs() < 1e-9);
    }
}

#[test]
fn the_example_has_every_key_at_its_default() {
    let example = shipped("every_key.toml");
    assert_eq!(
        Sliding {
            snr_db: None,
            ..example
        },
        Sliding::physical()
    );
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenes/every_key.toml");
    let text = std::fs::read_to_string(path).unwrap();
    // The error for an unknown key lists every key, and the example must have all of them.
    for table in [
        "",
        "[stimulator]\n",
        "[hand]\n",
        "[finger]\n",
        "[converter]\n",
    ] {
        let message = error(&format!("{table}no_such_key = 1"));
        let (_, keys) = message.split_once("expected").expect("a list");
        for key in keys.split('`').skip(1).step_by(2) {
            assert!(
                text.contains(&format!("{key} =")) || text.contains(&format!("[{key}]")),
                "{key}"
            );
        }
    }
}

#[test]
fn a_hand_needs_no_speed() {
    let hand = shipped("hand.toml");
    let truth = SlidingScene::new(hand).unwrap().truth();
    assert!((truth.slide_end_s - truth.slide_start_s - 5.0 / 1.07).abs() < 1e-9);
}

#[test]
fn an_empty_file_is_a_scene() {
    assert_eq!(
        parse_scene("a.toml", "", FRAME_RATE_HZ).unwrap(),
        Sliding::physical()
    );
}

#[test]
fn errors_name_key_and_line() {
    let unknown = error("# mine\nspeed_mm_s = 15\nperiode_mm = 3");
    assert!(
        unknown.starts_with("a.toml: line 3: unknown field `periode_mm`, expected one of "),
        "{unknown}"
    );
    let unknown = error("[finger]\ndepth = 3");
    assert!(
        unknown.starts_with("a.toml: line 2: unknown field `depth`")
            && unknown.contains("`depth_mm`"),
        "{unknown}"
    );
    assert!(error("overtones = [1]").contains("unknown field `overtones`"));

    let kind = error("period_mm = 3\n\n[finger]\ndepth_mm = \"thick\"");
    assert!(
        kind.starts_with("a.toml: line 4: depth_mm: invalid type: string \"thick\""),
        "{kind}"
    );
    assert!(error("period_mm = ").starts_with("a.toml: line 1: "));
    let twice = error("reverse = true\nreverse = true");
    assert!(
        twice.starts_with("a.toml: line 2: reverse: duplicate key"),
        "{twice}"
    );

    assert_eq!(
        error("speed_mm_s = -3"),
        "a.toml: line 1: speed_mm_s = -3: must be finite and greater than 0"
    );
    assert!(error("period_mm = nan").contains("period_mm = NaN"));
    let ridge = error("\nridge_mm = 4");
    assert_eq!(
        ridge,
        "a.toml: line 2: ridge_mm = 4: must be finite and less than 3.6 = period_mm"
    );
    // If the invalid value is a default, the error names the line of the key that limits it.
    let ridge = error("\nperiod_mm = 0.5");
    assert_eq!(
        ridge,
        "a.toml: line 2: ridge_mm = 0.6: must be finite and less than 0.5 = period_mm"
    );
    let contact = error("[finger]\ncontact_mm = 1");
    assert!(
        contact.starts_with("a.toml: line 2: period_mm = 3.6: ")
            && contact.contains("= contact_mm + "),
        "{contact}"
    );
    assert!(error("period_mm = 12").contains("contact_mm + ridge_mm"));
    assert!(error("[finger]\ndepth_mm = 0").starts_with("a.toml: line 2: depth_mm = 0: "));
    assert!(error("[finger]\nrelaxation_s = 4").contains("from 0 to 3.0000 = creep_s"));
    assert!(error("[stimulator]\nripple_percent = 100").contains("from 0 to 99"));
    assert!(error("[stimulator]\nonset_jitter_s = 2").contains("hold_before_s"));
    assert!(error("[stimulator]\nramp_s = 3").contains("slide_mm / speed_mm_s"));
    assert!(error("[converter]\nclock_error_ppm = 1e5").contains("clock_error_ppm = 100000"));
    assert!(
        error("speed_mm_s = 3\n[hand]")
            .starts_with("a.toml: line 1: speed_mm_s does not go with [hand]")
    );
}

#[test]
fn a_grating_finer_than_the_scan_can_follow() {
    let fine = error("speed_mm_s = 48\nperiod_mm = 0.3\nridge_mm = 0.1");
    assert_eq!(
        fine,
        "a.toml: line 2: period_mm = 0.3: makes 160.0 Hz, and 241.14 frames a second follow less than half their \
         rate: choose more than 0.398 mm, or a lower speed"
    );
    assert!(
        parse_scene(
            "a.toml",
            "speed_mm_s = 48\nperiod_mm = 0.4\nridge_mm = 0.1",
            FRAME_RATE_HZ
        )
        .is_ok()
    );
    assert!(error("period_mm = 1.5\n[hand]").contains("makes 131.3 Hz"));
    assert!(
        error("reverse = true\nspeed_mm_s = 1000")
            .starts_with("a.toml: line 2: period_mm = 3.6: makes 277.8 Hz")
    );
}

#[test]
fn a_missing_file_is_named() {
    let error = load_scene("no/such.toml", FRAME_RATE_HZ)
        .unwrap_err()
        .to_string();
    assert!(error.starts_with("no/such.toml: "), "{error}");
}
