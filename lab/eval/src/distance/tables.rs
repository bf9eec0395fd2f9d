//! The tables of the page.

use super::bars::{TABLE_6, bars};
use super::gratings::{Indices, SPACING_MM, figure_17d, figure_22};
use super::layers::{Filter, RUBBER, TABLE_1, crossing, figure_12, figure_16, table_1};
use super::matching::block;
use crate::page::Table;
use anyhow::Result;
use ridgetone_display::SUBJECTS;
use ridgetone_host::pins::Design;

pub const NAMES: [&str; 10] = [
    "bars",
    "table_1",
    "figure_8",
    "figure_12",
    "figure_16",
    "figures_17_18_19",
    "figure_22",
    "table_6",
    "design",
    "experiment",
];

/// A table by its name.
pub fn table(name: &str) -> Result<Option<String>> {
    Ok(Some(match name {
        "bars" => crate::bar::table(&bars()?),
        "table_1" => noise_without_shear(),
        "figure_8" => matching()?,
        "figure_12" => layers(),
        "figure_16" => sampling(),
        "figures_17_18_19" => gratings(),
        "figure_22" => errors(),
        "table_6" => skin(),
        "design" => designs()?,
        "experiment" => experiment()?,
        _ => return Ok(None),
    }))
}

fn noise_without_shear() -> String {
    let mut table = Table::new(
        1,
        "contact|angle|paper, dB|here, dB|with a Poisson's ratio of 0.45, dB",
    );
    for (contact, degrees, paper) in TABLE_1 {
        let here = |poisson| format!("{:.2}", table_1(contact, degrees, poisson));
        table.row(&[
            contact.name().into(),
            format!("{degrees:.0}"),
            format!("{paper:.0}"),
            here(RUBBER),
            here(0.45),
        ]);
    }
    table.end()
}

fn matching() -> Result<String> {
    let figure = block()?;
    let mut table = Table::new(
        1,
        "forces|rms error of strain, %|least, N/mm|greatest, N/mm",
    );
    for way in &figure.ways {
        let (least, most) = way
            .forces
            .iter()
            .fold((f64::MAX, f64::MIN), |(l, m), f| (f.min(l), f.max(m)));
        table.row(&[
            way.name.into(),
            format!("{:.2}", 100.0 * way.error),
            format!("{least:.3}"),
            format!("{most:.3}"),
        ]);
    }
    Ok(format!(
        "{}\n\nThe map's condition is {:.1}.",
        table.end(),
        figure.condition
    ))
}

fn layers() -> String {
    let mut table = Table::new(0, "cycles/mm|with shear|without shear");
    for cycles in [0.0, 0.02, 0.039, 0.051, 0.062, 0.1, 0.15, 0.25, 0.4] {
        let (with, without) = figure_12(cycles);
        table.row(&[
            format!("{cycles:.3}"),
            format!("{with:.3}"),
            format!("{without:.3}"),
        ]);
    }
    table.end()
}

fn sampling() -> String {
    let mut table = Table::new(
        1,
        "display|with shear at 0.5, dB|without, dB|at 1|without|at 2|without|shear is of no use from",
    );
    for filter in Filter::ALL {
        let cells = [0.5, 1.0, 2.0].map(|ratio| {
            [true, false].map(|shear| format!("{:.1}", figure_16(ratio, filter, shear)))
        });
        let from = crossing(filter).map_or("never".into(), |ratio| format!("{ratio:.2}"));
        table.row(&[vec![filter.name().into()], cells.concat(), vec![from]].concat());
    }
    table.end()
}

/// What the paper's text says of a period, millimetres: strain with shear.
fn in_the_paper(period_mm: f64) -> &'static str {
    match period_mm {
        4.0 => "0.18",
        3.4 | 3.6 => "0.10 to 0.15",
        _ => "-",
    }
}

fn gratings() -> String {
    let mut table = Table::new(
        0,
        "period, mm|paper: strain|strain|strain, no shear|stress|stress, no shear|mean strain",
    );
    for period_mm in super::gratings::PERIODS_MM {
        let Indices { strain, stress } = Indices::of(period_mm);
        let (_, mean) = figure_17d(period_mm);
        let figures =
            [strain.0, strain.1, stress.0, stress.1, mean].map(|value| format!("{value:.3}"));
        table.row(
            &[
                vec![format!("{period_mm:.1}"), in_the_paper(period_mm).into()],
                figures.to_vec(),
            ]
            .concat(),
        );
    }
    table.end()
}

fn errors() -> String {
    let mut table = Table::new(0, "period of the error, mm|pins|paper, 10 %|5 %|10 %|20 %");
    for pins in [2, 3, 4, 5, 10] {
        let figures = [0.05, 0.1, 0.2].map(|error| format!("{:.3}", figure_22(pins, error)));
        let paper = if pins == 2 { "about 0.06" } else { "below 0.1" };
        let period_mm = SPACING_MM * pins as f64;
        table.row(
            &[
                vec![format!("{period_mm:.0}"), pins.to_string(), paper.into()],
                figures.to_vec(),
            ]
            .concat(),
        );
    }
    table.end()
}

fn skin() -> String {
    let mut table = Table::new(
        0,
        "subject|paper|exp(-1.8 s / creep time)|the Kelvin model after 3 s",
    );
    for (n, (subject, paper)) in SUBJECTS.iter().zip(TABLE_6).enumerate() {
        let figures = [
            paper,
            subject.retained_by_creep_time(1.8),
            subject.retained(3.0, 1.8),
        ];
        let digits = [2, 3, 3];
        let cells = figures
            .into_iter()
            .zip(digits)
            .map(|(value, digits)| format!("{value:.digits$}"));
        table.row(&[vec![(n + 1).to_string()], cells.collect()].concat());
    }
    table.end()
}

fn designs() -> Result<String> {
    let mut table = Table::new(
        0,
        "spacing, mm|layer, mm|resolution, %|index from pin to pin|worst index|at, mm|the pins themselves|not noticed up to, %",
    );
    for (spacing_mm, depth_mm) in [
        (1.0, 1.0),
        (2.0, 1.0),
        (2.0, 2.0),
        (2.0, 3.0),
        (3.0, 2.0),
        (3.0, 3.0),
        (4.0, 4.0),
    ] {
        let design = Design::new(spacing_mm, depth_mm, 10.0)?;
        let figures = [design.index, design.worst_index].map(|value| format!("{value:.3}"));
        table.row(
            &[
                vec![
                    format!("{spacing_mm:.0}"),
                    format!("{depth_mm:.0}"),
                    "10".into(),
                ],
                figures.to_vec(),
                vec![
                    format!("{:.0}", design.worst_period_mm),
                    format!("{:.4}", design.pins_index),
                ],
                vec![format!("{:.1}", design.resolution_max_percent)],
            ]
            .concat(),
        );
    }
    Ok(table.end())
}

fn experiment() -> Result<String> {
    let mut table = Table::new(
        1,
        "condition|paper: correlation|correlation|from person to person|vibration against the surface, rms of the amplitude, %|its period in looks of 50 ms, rms error, %",
    );
    for (condition, outcome) in super::experiment::outcomes()? {
        let (mean, sigma) = outcome.correlation;
        table.row(&[
            condition.name.into(),
            condition.paper.into(),
            format!("{mean:.2}"),
            format!("{sigma:.2}"),
            format!("{:.1}", outcome.surface_percent),
            format!("{:.1}", outcome.error_percent),
        ]);
    }
    Ok(table.end())
}
