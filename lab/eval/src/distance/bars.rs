//! All bars of the page in one place.

use super::gratings::{Indices, figure_17d, figure_22};
use super::layers::{Filter, RUBBER, TABLE_1, crossing, figure_12, figure_16, table_1};
use super::matching::block;
use crate::page::Bar;
use anyhow::Result;
use ridgetone_teletaction::display::SUBJECTS;
use std::f64::consts::TAU;

/// Finger 1.8 s after a ridge of 3 s (Table 6), subject by subject.
pub const TABLE_6: [f64; 6] = [0.43, 0.74, 0.62, 0.61, 0.69, 0.66];

/// Spacing over the layer's thickness at which sampling no longer counts.
const DENSE: f64 = 0.05;

/// What the paper says, by how much it may be missed, and what comes out.
pub fn bars() -> Result<Vec<Bar>> {
    let mut bars = Vec::new();
    let mut near = |bar: String, wanted: f64, most: f64, here: f64, digits: usize| {
        let met = (here - wanted).abs() <= most;
        bars.push(Bar {
            bar,
            limit: format!("{wanted} +- {most}"),
            measured: format!("{here:.digits$}"),
            met,
        });
    };
    for (contact, degrees, paper) in TABLE_1 {
        let name = format!("Table 1, {}, {degrees:.0} degrees, dB", contact.name());
        near(name, paper, 0.5, table_1(contact, degrees, RUBBER), 2);
    }
    // (0.5 + 1.5 u) exp(-u) has its maximum at u = 2 / 3, with u the wave number times the depth of
    // 2.7 mm.
    let peak = figure_12(2.0 / 3.0 / 2.7 / TAU).0;
    near(
        "Figure 12, peak with shear, by hand".into(),
        1.540,
        1e-3,
        peak,
        3,
    );
    for filter in Filter::ALL {
        let name = format!("Figure 16, limit without shear, {}, dB", filter.name());
        near(name, 15.9, 0.2, figure_16(DENSE, filter, false), 2);
    }
    near(
        "Figure 17d, mean strain at 4.0 mm".into(),
        0.22,
        0.02,
        figure_17d(4.0).1,
        3,
    );
    near(
        "Figures 17d and 18, index of strain at 4.0 mm".into(),
        0.18,
        0.02,
        Indices::of(4.0).strain.0,
        3,
    );
    for period_mm in [3.4, 3.6] {
        let name = format!("Figure 18, index of strain at {period_mm:.1} mm");
        near(name, 0.125, 0.025, Indices::of(period_mm).strain.0, 3);
    }
    near(
        "Figure 22, 10 % at 4 mm".into(),
        0.06,
        0.01,
        figure_22(2, 0.1),
        3,
    );
    for (n, (subject, paper)) in SUBJECTS.iter().zip(TABLE_6).enumerate() {
        near(
            format!("Table 6, subject {}", n + 1),
            paper,
            0.006,
            subject.retained_by_creep_time(1.8),
            3,
        );
    }
    let mut below = |bar: String, most: f64, here: f64, digits: usize| {
        let (limit, measured) = (format!("below {most}"), format!("{here:.digits$}"));
        bars.push(Bar {
            bar,
            limit,
            measured,
            met: here < most,
        });
    };
    // The paper says 1, and does not say of which filter.
    for filter in Filter::ALL {
        below(
            format!("Figure 16, shear is of no use from, {}", filter.name()),
            1.0,
            crossing(filter).unwrap_or(f64::INFINITY),
            2,
        );
    }
    for way in &block()?.ways {
        below(
            format!("Figure 8, {}, rms error, %", way.name),
            5.0,
            100.0 * way.error,
            2,
        );
    }
    for period_mm in [3.4, 4.0, 4.8] {
        let Indices { strain, stress } = Indices::of(period_mm);
        below(
            format!("Figure 18 at {period_mm:.1} mm, strain, with shear over without"),
            1.0,
            strain.0 / strain.1,
            2,
        );
        below(
            format!("Figure 19 at {period_mm:.1} mm, stress, the same"),
            1.0,
            stress.0 / stress.1,
            2,
        );
    }
    below("Figure 22, 10 % at 10 mm".into(), 0.1, figure_22(5, 0.1), 3);
    Ok(bars)
}
