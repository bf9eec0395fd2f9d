use super::*;
use std::collections::BTreeSet;

extern crate std;

#[test]
fn the_defaults_are_within_their_own_bounds() {
    assert_eq!(Settings::default().validate(), Ok(()));
}

fn with(settings: Settings, name: &str, number: f32) -> Settings {
    let mut settings = settings;
    let setting = TABLE.iter().find(|setting| setting.name == name).unwrap();
    let value = match setting.kind {
        Kind::Number => Value::Number(number),
        Kind::Whole => Value::Whole(number as u8),
        Kind::Switch => Value::Switch(number != 0.0),
        Kind::Mask => Value::Mask(number as u16),
        Kind::Masks => Value::Masks([0x1111, 0x2222, 0x4444, 0x8888 | number as u16]),
        Kind::Word(_) | Kind::Plan => panic!("{name} is no number"),
    };
    assert!((setting.set)(&mut settings, value), "{name}");
    settings
}

#[test]
fn the_setting_outside_its_bounds_is_named() {
    let protocol = Settings {
        slide: Slide {
            rule: SlideRule::Protocol,
            speed_mm_s: 30.0,
            ..Slide::DEFAULT
        },
        ..Settings::DEFAULT
    };
    assert_eq!(protocol.validate(), Ok(()));
    for (name, number) in [
        ("window_s", 5.0),
        ("window_s", f32::NAN),
        ("stride_s", 0.0),
        ("stride_s", 4.0),
        ("harmonics", 6.0),
        ("harmonics", 0.0),
        ("accuracy", 0.2),
        ("accuracy", f32::NAN),
        ("interferer_hz", -50.0),
        ("interferer_hz", 4.0),
        ("vref_v", 9.0),
        ("slide.delay_s", -1.0),
        ("slide.speed_mm_s", 0.0),
        ("slide.length_mm", f32::INFINITY),
        ("array.pitch_mm", 0.0),
        ("array.edge_phase_rad", 4.0),
        ("array.edge_phase_sigma_rad", f32::NAN),
        ("array.period_min_mm", 0.0),
        ("array.period_max_mm", 2.0),
        ("array.alike", 1.0),
    ] {
        let found = with(protocol, name, number).validate().unwrap_err();
        assert_eq!(found.field, name, "{number}");
    }
    // Unused settings may have any valid value.
    assert_eq!(
        with(Settings::DEFAULT, "slide.speed_mm_s", 0.0).validate(),
        Ok(())
    );
    let still = with(Settings::DEFAULT, "array.may_go_backward", 0.0);
    assert_eq!(still.validate(), Ok(()));
    let still = with(still, "array.may_go_forward", 0.0);
    assert_eq!(still.validate().unwrap_err().field, "array.may_go_forward");
}

#[test]
fn windows_are_bounded_by_the_plan() {
    for (name, plan) in Plan::NAMED {
        let settings = Settings::DEFAULT.with_plan(plan);
        assert_eq!(settings.validate(), Ok(()), "{name}");
        let longer = with(settings, "window_s", plan.window_max_s() + 0.002);
        assert_eq!(longer.validate().unwrap_err().field, "window_s", "{name}");
    }
    let settings = Settings {
        plan: Plan {
            inputs: 0,
            ..Plan::PAPER
        },
        ..Settings::DEFAULT
    };
    assert_eq!(settings.validate().unwrap_err().field, "plan.inputs");
    assert_eq!(Settings::DEFAULT.with_plan(Plan::PAPER), Settings::DEFAULT);
}

#[test]
fn names_and_ids_are_unique_and_names_fit_a_refusal() {
    let names: BTreeSet<_> = TABLE.iter().map(|setting| setting.name).collect();
    let ids: BTreeSet<_> = TABLE.iter().map(|setting| setting.id).collect();
    assert_eq!((names.len(), ids.len()), (COUNT, COUNT));
    assert!(!ids.contains(&0), "0 ends a record");
    for (setting, (name, _)) in TABLE.iter().zip(CHECKS) {
        assert_eq!(setting.name, name);
        let error = SettingsError::new(name, 0.0, Limits::new(0.0, 0.0));
        assert_eq!(error.field, name);
        assert!(setting.sentence().ends_with('.'), "{name}");
    }
}

/// Ids must never change, because boards have stored settings under them.
#[test]
fn ids_stay_with_their_settings() {
    let ids = [
        (2, "window_s"),
        (3, "stride_s"),
        (4, "harmonics"),
        (5, "accuracy"),
        (6, "interferer_hz"),
        (7, "vref_v"),
        (8, "slide.rule"),
        (9, "slide.delay_s"),
        (10, "slide.speed_mm_s"),
        (11, "slide.length_mm"),
        (12, "array.pitch_mm"),
        (13, "array.edge_phase_rad"),
        (14, "array.edge_phase_sigma_rad"),
        (15, "array.period_min_mm"),
        (16, "array.period_max_mm"),
        (17, "array.may_go_forward"),
        (18, "array.may_go_backward"),
        (19, "array.front"),
        (20, "array.alike"),
        (21, "feel.volts_per_um"),
        (22, "feel.sigma_fraction"),
        (23, "feel.force_ratio"),
        (25, "scene.curved_baseline"),
        (26, "scene.coloured_noise"),
        (27, "scene.shared_noise"),
        (28, "scene.moving_speed"),
        (29, "scene.impulses"),
        (30, "plan"),
    ];
    for (id, name) in ids {
        let setting = TABLE.iter().find(|setting| setting.id == id);
        assert!(
            setting.is_none_or(|setting| setting.name == name),
            "id {id} was {name}"
        );
    }
}

#[test]
fn each_value_is_read_back_as_it_was_written() {
    for setting in TABLE {
        let mut settings = Settings::DEFAULT;
        assert!((setting.set)(&mut settings, setting.default()));
        assert_eq!(settings, Settings::DEFAULT, "{}", setting.name);
        let other = match setting.kind {
            Kind::Switch => Value::Number(1.0),
            _ => Value::Switch(true),
        };
        assert!(!(setting.set)(&mut settings, other), "{}", setting.name);
    }
}
