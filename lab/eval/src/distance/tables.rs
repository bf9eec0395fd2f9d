//! The figures of the page, as tables.

use super::bars::{TABLE_6, bars};
use super::experiment::{PERIODS_MM as TEXTURES_MM, outcomes};
use super::gratings::{Indices, PERIODS_MM, SPACING_MM, figure_17d, figure_22};
use super::layers::{Filter, RUBBER, TABLE_1, crossing, figure_12, figure_16, table_1};
use super::matching::block;
use crate::page::{self, Table, Tables, fixed};
use anyhow::Result;
use ridgetone_host::chart::{Curve, Look, Panel, Scale, chart};
use ridgetone_teletaction::display::SUBJECTS;
use ridgetone_teletaction::pins::Design;
use serde_json::Value;

pub fn tables() -> Result<Tables> {
    let tables = [
        ("bars", page::bars(&bars()?)),
        ("table_1", noise_without_shear()),
        ("figure_8", matching()?),
        ("figure_12", layers()),
        ("figure_16", sampling()),
        ("figures_17_18_19", gratings()),
        ("figure_22", errors()),
        ("table_6", skin()),
        ("design", designs()?),
        ("experiment", experiment()?),
    ];
    Ok(tables
        .into_iter()
        .map(|(name, table)| (name.to_owned(), table))
        .collect())
}

fn noise_without_shear() -> Table {
    let mut table =
        Table::new("contact|angle|paper, dB|here, dB|with a Poisson's ratio of 0.45, dB");
    for (contact, degrees, paper) in TABLE_1 {
        let here = |poisson| fixed(table_1(contact, degrees, poisson), 2);
        table.row([
            contact.name().into(),
            fixed(degrees, 0),
            paper.into(),
            here(RUBBER),
            here(0.45),
        ]);
    }
    table
}

fn matching() -> Result<Table> {
    let figure = block()?;
    let mut table =
        Table::new("forces|rms error of strain, %|least, N/mm|greatest, N/mm|condition of the map");
    for way in &figure.ways {
        let (least, most) = way
            .forces
            .iter()
            .fold((f64::MAX, f64::MIN), |(l, m), f| (f.min(l), f.max(m)));
        table.row([
            way.name.into(),
            fixed(100.0 * way.error, 2),
            fixed(least, 3),
            fixed(most, 3),
            fixed(figure.condition, 1),
        ]);
    }
    Ok(table)
}

fn layers() -> Table {
    let mut table = Table::new("cycles/mm|with shear|without shear");
    for cycles in [0.0, 0.02, 0.039, 0.051, 0.062, 0.1, 0.15, 0.25, 0.4] {
        let (with, without) = figure_12(cycles);
        table.row([fixed(cycles, 3), fixed(with, 3), fixed(without, 3)]);
    }
    table
}

fn sampling() -> Table {
    let mut table = Table::new(
        "display|with shear at 0.5, dB|without, dB|at 1|without|at 2|without|shear is of no use from",
    );
    for filter in Filter::ALL {
        let ratios = [0.5, 1.0, 2.0].into_iter();
        let figures =
            ratios.flat_map(|ratio| [true, false].map(|shear| figure_16(ratio, filter, shear)));
        let from = [fixed(crossing(filter), 2)];
        let cells = figures.map(|decibels| fixed(decibels, 1)).chain(from);
        table.row([Value::from(filter.name())].into_iter().chain(cells));
    }
    table
}

/// What the paper's text says of the strain with shear under a period, millimetres.
fn in_the_paper(period_mm: f64) -> Value {
    match period_mm {
        4.0 => "0.18".into(),
        3.4 | 3.6 => "0.10 to 0.15".into(),
        _ => Value::Null,
    }
}

fn gratings() -> Table {
    let mut table = Table::new(
        "period, mm|paper: strain|strain|strain, no shear|stress|stress, no shear|mean strain",
    );
    for period_mm in PERIODS_MM {
        let Indices { strain, stress } = Indices::of(period_mm);
        let figures = [
            strain.0,
            strain.1,
            stress.0,
            stress.1,
            figure_17d(period_mm).1,
        ];
        let names = [period_mm.into(), in_the_paper(period_mm)];
        table.row(
            names
                .into_iter()
                .chain(figures.map(|value| fixed(value, 3))),
        );
    }
    table
}

fn errors() -> Table {
    let mut table = Table::new("period of the error, mm|pins|paper, 10 %|5 %|10 %|20 %");
    for pins in [2, 3, 4, 5, 10] {
        let paper = if pins == 2 { "about 0.06" } else { "below 0.1" };
        let figures = [0.05, 0.1, 0.2].map(|error| fixed(figure_22(pins, error), 3));
        let names = [
            fixed(SPACING_MM * pins as f64, 0),
            pins.into(),
            paper.into(),
        ];
        table.row(names.into_iter().chain(figures));
    }
    table
}

fn skin() -> Table {
    let mut table = Table::new("subject|paper|exp(-1.8 s / creep time)|the Kelvin model after 3 s");
    for (n, (subject, paper)) in SUBJECTS.iter().zip(TABLE_6).enumerate() {
        let by_creep = fixed(subject.retained_by_creep_time(1.8), 3);
        table.row([
            (n + 1).into(),
            paper.into(),
            by_creep,
            fixed(subject.retained(3.0, 1.8), 3),
        ]);
    }
    table
}

fn designs() -> Result<Table> {
    let mut table = Table::new(
        "spacing, mm|layer, mm|resolution, %|index from pin to pin|worst index|at, mm|the pins themselves|\
         not noticed up to, %",
    );
    let pairs = [
        (1.0, 1.0),
        (2.0, 1.0),
        (2.0, 2.0),
        (2.0, 3.0),
        (3.0, 2.0),
        (3.0, 3.0),
        (4.0, 4.0),
    ];
    for (spacing_mm, depth_mm) in pairs {
        let design = Design::new(spacing_mm, depth_mm, 10.0)?;
        table.row([
            fixed(spacing_mm, 0),
            fixed(depth_mm, 0),
            10.into(),
            fixed(design.index, 3),
            fixed(design.worst_index, 3),
            fixed(design.worst_period_mm, 0),
            fixed(design.pins_index, 4),
            fixed(design.resolution_max_percent, 1),
        ]);
    }
    Ok(table)
}

fn experiment() -> Result<Table> {
    let answers = TEXTURES_MM
        .map(|mm| format!("mean answer to {mm} mm, mm"))
        .join("|");
    let mut table = Table::new(&format!(
        "condition|paper: correlation|correlation|from person to person|\
         vibration against the surface, rms of the amplitude, %|its period in looks of 50 ms, rms error, %|{answers}"
    ));
    for (condition, outcome) in outcomes()? {
        let (mean, sigma) = outcome.correlation;
        let figures = [
            fixed(mean, 2),
            fixed(sigma, 2),
            fixed(outcome.surface_percent, 1),
            fixed(outcome.error_percent, 1),
        ];
        let answers = outcome.answers_mm.map(|mm| fixed(mm, 2));
        let names = [Value::from(condition.name), condition.paper.into()];
        table.row(names.into_iter().chain(figures).chain(answers));
    }
    Ok(table)
}

/// Figure 16: signal over noise by the spacing of samples, with and without shear.
pub fn picture() -> String {
    let curve = |number: usize, filter: Filter, with_shear: bool| Curve {
        name: format!(
            "{}{}",
            filter.name(),
            if with_shear { ", with shear" } else { "" }
        ),
        look: Look::Marked(number + if with_shear { 4 } else { 0 }),
        points: (1..=12)
            .map(|n| 0.2 * f64::from(n))
            .map(|ratio| (ratio, figure_16(ratio, filter, with_shear)))
            .collect(),
    };
    let filters = [Filter::Linear, Filter::Hold, Filter::HalfPins];
    let all = filters.into_iter().enumerate();
    let panel = Panel {
        title: "Signal over noise of a line load, dB, by the spacing of samples".into(),
        x: Scale {
            label: "spacing over the thickness of a layer".into(),
            ..Scale::default()
        },
        y: Scale {
            label: "dB".into(),
            range: Some((0.0, 60.0)),
            ..Scale::default()
        },
        curves: all
            .flat_map(|(n, filter)| [true, false].map(|shear| curve(n, filter, shear)))
            .collect(),
    };
    chart("Signal over noise by the spacing of samples", &[panel])
}
