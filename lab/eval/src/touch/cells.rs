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

/// What differs in a cell from [`EASY_SLIDE`].
type Change = fn(&mut Recipe);

fn no_slide(recipe: &mut Recipe) {
    recipe.slide_s = None;
    recipe.hold_before_s = (2.0, 8.0);
}

const CONTACTS: [(&str, Change); 9] = [
    ("spike's square 10 to 12 times the hold's", |r| {
        r.spike = Some((10.0, 12.0))
    }),
    ("spike's square 12 to 40 times the hold's", |r| {
        r.spike = Some((12.0, 40.0))
    }),
    ("the same, no slide", |r| {
        (r.spike, r.slide_s) = (Some((12.0, 40.0)), None)
    }),
    ("holds of 0.05 s, then a slide", |r| {
        r.slide_s = Some((0.4, 2.0));
        r.hold_before_s = (0.05, 0.05);
    }),
    ("holds of 0.05 s, no slide", |r| {
        r.slide_s = None;
        (r.hold_before_s, r.hold_after_s) = ((0.025, 0.025), (0.025, 0.025));
    }),
    ("holds of 0.1 to 0.3 s, no slide", |r| {
        r.slide_s = None;
        (r.hold_before_s, r.hold_after_s) = ((0.05, 0.15), (0.05, 0.15));
    }),
    ("starting under load", |r| {
        (r.loaded, r.hold_before_s) = (true, (1.5, 3.0))
    }),
    ("half the load, 2 to 10 Hz, 20 dB", |r| {
        (r.load, r.tone_hz) = (0.5, (2.0, 10.0))
    }),
    ("half the load, 2 to 10 Hz, 10 dB", |r| {
        (r.load, r.tone_hz, r.snr_db) = (0.5, (2.0, 10.0), 10.0);
    }),
];

/// Disturbances, and whether there is a cell without a slide too.
const DISTURBANCES: [(&str, Change, bool); 10] = [
    ("drift of 100 mV/s", |r| r.drift_v_s = 0.1, true),
    ("drift of 10 mV/s", |r| r.drift_v_s = 0.01, false),
    ("drift of 1 mV/s", |r| r.drift_v_s = 1e-3, false),
    ("hum as strong as the tone", |r| r.hum = Some(false), true),
    ("the same with --mains 50", |r| r.hum = Some(true), true),
    ("presses by 10 % at 1 to 3 Hz", |r| r.press = 0.1, true),
    ("pink noise", |r| r.pink = true, true),
    (
        "pink noise, 10 dB",
        |r| (r.pink, r.snr_db) = (true, 10.0),
        true,
    ),
    (
        "tone 10 dB below the creep",
        |r| r.creep = 10f64.sqrt(),
        true,
    ),
    ("physical finger", |r| r.physical = true, false),
];

pub fn cells() -> Vec<Cell> {
    let mut cells = Vec::new();
    let mut add = |group, name: String, change: &dyn Fn(&mut Recipe)| {
        let mut recipe = EASY_SLIDE;
        change(&mut recipe);
        cells.push(Cell {
            group,
            name,
            recipe,
        });
    };
    let bands = [
        (1.0, 2.0),
        (2.0, 5.0),
        (5.0, 20.0),
        (20.0, 50.0),
        (50.0, 70.0),
        (70.0, 100.0),
    ];
    for snr_db in [20.0, 10.0, 0.0] {
        for (least, most) in bands {
            let name = format!("{least} to {most} Hz, {snr_db} dB");
            add("tones", name, &|r| {
                (r.tone_hz, r.snr_db) = ((least, most), snr_db)
            });
        }
    }
    for (least, most) in [(0.4, 0.5), (0.5, 1.0), (1.0, 2.0), (2.0, 4.0), (7.9, 8.0)] {
        add("lengths", format!("{least} to {most} s"), &|r| {
            r.slide_s = Some((least, most))
        });
    }
    add("lengths", "7.9 to 8 s, 10 dB".into(), &|r| {
        (r.slide_s, r.snr_db) = (Some((7.9, 8.0)), 10.0)
    });
    for ramp_s in [0.1, 0.2, 0.4, 0.8] {
        let slide_s = Some((2.0 * ramp_s + 0.2, 8.0));
        let name = format!("ramps of {ramp_s} s");
        add("lengths", name, &|r| {
            (r.slide_s, r.ramp_s) = (slide_s, (ramp_s, ramp_s))
        });
    }
    for snr_db in [20.0, 10.0] {
        for hz in [60.0, 70.0, 100.0] {
            let change = |r: &mut Recipe| {
                (r.tone_hz, r.snr_db, r.idle_s) = ((hz, hz), snr_db, (0.3, 4.9));
            };
            add("early", format!("{hz} Hz, {snr_db} dB"), &change);
        }
    }
    for (name, change) in CONTACTS {
        add("contact", name.into(), &change);
    }
    let short = Some((0.4, 2.0));
    for (least, most) in [(0.05, 0.1), (0.1, 0.2), (0.2, 0.5), (0.5, 1.0)] {
        let name = format!("{least} to {most} s after the slide");
        add("lift", name, &|r| {
            (r.slide_s, r.hold_after_s) = (short, (least, most))
        });
    }
    let faint = |r: &mut Recipe| (r.slide_s, r.hold_after_s, r.snr_db) = (short, (0.05, 1.0), 10.0);
    add("lift", "0.05 to 1 s, 10 dB".into(), &faint);
    let sliding = |r: &mut Recipe| (r.slide_s, r.hold_after_s) = (short, (1e-3, 1e-3));
    add("lift", "while it slides".into(), &sliding);
    for (name, change, is_still_too) in DISTURBANCES {
        add("disturbances", name.into(), &change);
        if is_still_too {
            let still = |r: &mut Recipe| {
                change(r);
                no_slide(r);
            };
            add("disturbances", format!("{name}, no slide"), &still);
        }
    }
    add("disturbances", "white noise, no slide".into(), &no_slide);
    cells
}
