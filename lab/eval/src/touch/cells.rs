//! The cells: what is in their traces.

use super::trace::{Range, Recipe};

/// A row of the table.
#[derive(Clone, Debug)]
pub struct Cell {
    pub group: &'static str,
    pub name: String,
    pub recipe: Recipe,
}

/// Groups, in the order of the page.
pub const GROUPS: [&str; 6] = [
    "tones",
    "lengths",
    "early",
    "contact",
    "lift",
    "disturbances",
];

const ALL_HZ: Range = (1.0, 100.0);
const ALL_S: Range = (0.4, 8.0);

/// A slide that nothing makes hard.
const EASY_SLIDE: Recipe = Recipe {
    tone_hz: ALL_HZ,
    snr_db: 20.0,
    slide_s: Some(ALL_S),
    ramp_s: (0.005, 0.02),
    idle_s: (0.5, 5.0),
    hold_before_s: (0.5, 2.0),
    hold_after_s: (0.5, 2.0),
    pink: false,
    spike: None,
    creep: 0.0,
    drift_v_s: 0.0,
    hum: None,
    load: 1.0,
    press: 0.0,
    loaded: false,
    physical: false,
};

pub fn cells() -> Vec<Cell> {
    let mut cells = Vec::new();
    let mut add = |group, name: String, recipe| {
        cells.push(Cell {
            group,
            name,
            recipe,
        })
    };
    for snr_db in [20.0, 10.0, 0.0] {
        for (least, most) in [
            (1.0, 2.0),
            (2.0, 5.0),
            (5.0, 20.0),
            (20.0, 50.0),
            (50.0, 70.0),
            (70.0, 100.0),
        ] {
            let name = format!("{least} to {most} Hz, {snr_db} dB");
            add(
                "tones",
                name,
                Recipe {
                    tone_hz: (least, most),
                    snr_db,
                    ..EASY_SLIDE
                },
            );
        }
    }
    for (least, most) in [(0.4, 0.5), (0.5, 1.0), (1.0, 2.0), (2.0, 4.0), (7.9, 8.0)] {
        add(
            "lengths",
            format!("{least} to {most} s"),
            Recipe {
                slide_s: Some((least, most)),
                ..EASY_SLIDE
            },
        );
    }
    add(
        "lengths",
        "7.9 to 8 s, 10 dB".into(),
        Recipe {
            slide_s: Some((7.9, 8.0)),
            snr_db: 10.0,
            ..EASY_SLIDE
        },
    );
    for ramp_s in [0.1, 0.2, 0.4, 0.8] {
        let slide_s = Some((2.0 * ramp_s + 0.2, 8.0));
        add(
            "lengths",
            format!("ramps of {ramp_s} s"),
            Recipe {
                slide_s,
                ramp_s: (ramp_s, ramp_s),
                ..EASY_SLIDE
            },
        );
    }
    for snr_db in [20.0, 10.0] {
        for hz in [60.0, 70.0, 100.0] {
            let recipe = Recipe {
                tone_hz: (hz, hz),
                snr_db,
                idle_s: (0.3, 4.9),
                ..EASY_SLIDE
            };
            add("early", format!("{hz} Hz, {snr_db} dB"), recipe);
        }
    }
    add(
        "contact",
        "spike's square 10 to 12 times the hold's".into(),
        Recipe {
            spike: Some((10.0, 12.0)),
            ..EASY_SLIDE
        },
    );
    add(
        "contact",
        "spike's square 12 to 40 times the hold's".into(),
        Recipe {
            spike: Some((12.0, 40.0)),
            ..EASY_SLIDE
        },
    );
    let still = Recipe {
        slide_s: None,
        ..EASY_SLIDE
    };
    add(
        "contact",
        "the same, no slide".into(),
        Recipe {
            spike: Some((12.0, 40.0)),
            ..still
        },
    );
    let short = Recipe {
        slide_s: Some((0.4, 2.0)),
        ..EASY_SLIDE
    };
    add(
        "contact",
        "holds of 0.05 s, then a slide".into(),
        Recipe {
            hold_before_s: (0.05, 0.05),
            ..short
        },
    );
    let tap = Recipe {
        hold_before_s: (0.025, 0.025),
        hold_after_s: (0.025, 0.025),
        ..still
    };
    add("contact", "holds of 0.05 s, no slide".into(), tap);
    let tap = Recipe {
        hold_before_s: (0.05, 0.15),
        hold_after_s: (0.05, 0.15),
        ..still
    };
    add("contact", "holds of 0.1 to 0.3 s, no slide".into(), tap);
    add(
        "contact",
        "starting under load".into(),
        Recipe {
            loaded: true,
            hold_before_s: (1.5, 3.0),
            ..EASY_SLIDE
        },
    );
    for snr_db in [20.0, 10.0] {
        let gentle = Recipe {
            load: 0.5,
            tone_hz: (2.0, 10.0),
            snr_db,
            ..EASY_SLIDE
        };
        add(
            "contact",
            format!("half the load, 2 to 10 Hz, {snr_db} dB"),
            gentle,
        );
    }
    for (least, most) in [(0.05, 0.1), (0.1, 0.2), (0.2, 0.5), (0.5, 1.0)] {
        let recipe = Recipe {
            hold_after_s: (least, most),
            ..short
        };
        add(
            "lift",
            format!("{least} to {most} s after the slide"),
            recipe,
        );
    }
    add(
        "lift",
        "0.05 to 1 s, 10 dB".into(),
        Recipe {
            hold_after_s: (0.05, 1.0),
            snr_db: 10.0,
            ..short
        },
    );
    add(
        "lift",
        "while it slides".into(),
        Recipe {
            hold_after_s: (1e-3, 1e-3),
            ..short
        },
    );
    let creep = 10f64.sqrt();
    for (name, change) in [
        (
            "drift of 100 mV/s",
            Recipe {
                drift_v_s: 0.1,
                ..EASY_SLIDE
            },
        ),
        (
            "drift of 10 mV/s",
            Recipe {
                drift_v_s: 0.01,
                ..EASY_SLIDE
            },
        ),
        (
            "drift of 1 mV/s",
            Recipe {
                drift_v_s: 1e-3,
                ..EASY_SLIDE
            },
        ),
        (
            "hum as strong as the tone",
            Recipe {
                hum: Some(false),
                ..EASY_SLIDE
            },
        ),
        (
            "the same with --mains 50",
            Recipe {
                hum: Some(true),
                ..EASY_SLIDE
            },
        ),
        (
            "presses by 10 % at 1 to 3 Hz",
            Recipe {
                press: 0.1,
                ..EASY_SLIDE
            },
        ),
        (
            "pink noise",
            Recipe {
                pink: true,
                ..EASY_SLIDE
            },
        ),
        (
            "pink noise, 10 dB",
            Recipe {
                pink: true,
                snr_db: 10.0,
                ..EASY_SLIDE
            },
        ),
        (
            "tone 10 dB below the creep",
            Recipe {
                creep,
                ..EASY_SLIDE
            },
        ),
        (
            "physical finger",
            Recipe {
                physical: true,
                ..EASY_SLIDE
            },
        ),
    ] {
        add("disturbances", name.into(), change);
        if change.physical || change.drift_v_s == 0.01 || change.drift_v_s == 1e-3 {
            continue;
        }
        add(
            "disturbances",
            format!("{name}, no slide"),
            Recipe {
                slide_s: None,
                hold_before_s: (2.0, 8.0),
                ..change
            },
        );
    }
    add(
        "disturbances",
        "white noise, no slide".into(),
        Recipe {
            hold_before_s: (2.0, 8.0),
            ..still
        },
    );
    cells
}
