//! Touches against their truth: contact, slide and release in traces with known times, cell by
//! cell, for docs/results/touch.md.

mod cells;
mod measure;
mod trace;

use crate::page::{self, Bar, Figures, Table, Tables, fixed, percent};
use crate::parallel;
use anyhow::Result;
use cells::{GROUPS, cells};
use measure::{Found, measure};
use ridgetone_host::usage::UsageError;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Traces of each cell by default.
const TRACES: u32 = 200;
/// The seed of the page. Constants of the detector are chosen on others.
const SEED: u64 = 30_000;

const TOPIC: &str = "touch";

#[derive(Debug, clap::Args)]
#[command(after_help = "\
With 200 traces a cell it takes some minutes on two cores. Equal seeds give equal tables.

Examples:
  cargo xtask touch --traces 20
  cargo xtask touch --seed 1 --group tones
  cargo xtask touch --write")]
pub struct TouchArgs {
    /// Traces of each cell.
    #[arg(long, value_name = "N", default_value_t = TRACES, value_parser = clap::value_parser!(u32).range(1..))]
    traces: u32,
    /// Seed of the first trace. Constants are chosen on other seeds than the page's.
    #[arg(long, value_name = "N", default_value_t = SEED)]
    seed: u64,
    /// Only this group: tones, lengths, early, contact, lift or disturbances.
    #[arg(long, value_name = "NAME", conflicts_with = "write")]
    group: Option<String>,
    /// Write touch.json into a folder, and fill in touch.md there.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/results")]
    write: Option<PathBuf>,
}

/// What was found in the traces of a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    group: String,
    name: String,
    found: Found,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rows {
    rows: Vec<Row>,
}

/// What is found in every cell, or in those of one group.
pub fn rows(traces: u32, seed: u64, group: Option<&str>) -> Result<Vec<Row>> {
    let cells: Vec<_> = cells()
        .into_iter()
        .filter(|cell| group.is_none_or(|wanted| wanted == cell.group))
        .collect();
    if cells.is_empty() {
        return Err(UsageError(format!("--group: one of {}", GROUPS.join(", "))).into());
    }
    parallel::map("cells", &cells, |cell| {
        let found = measure(&cell.recipe, traces, seed)?;
        Ok(Row {
            group: cell.group.to_owned(),
            name: cell.name.clone(),
            found,
        })
    })
}

/// What must hold in every cell.
#[derive(Clone, Copy)]
struct Limit {
    what: &'static str,
    limit: f64,
    is_least: bool,
}

/// Shares that every cell should reach: slides found, slides with both ends within 20 ms, and at
/// most so many traces with a false slide; percent.
const BARS: [Limit; 3] = [
    Limit {
        what: "slide found",
        limit: 99.0,
        is_least: true,
    },
    Limit {
        what: "both ends within 20 ms",
        limit: 95.0,
        is_least: true,
    },
    Limit {
        what: "false slides",
        limit: 1.0,
        is_least: false,
    },
];

impl Row {
    /// The figures of [`BARS`].
    fn judged(&self) -> [Option<f64>; 3] {
        let share =
            |count: u32, of: u32| (of > 0).then(|| 100.0 * f64::from(count) / f64::from(of));
        let Found {
            slides,
            slides_found,
            near,
            slides_false,
            traces,
            ..
        } = self.found;
        [
            share(slides_found, slides),
            share(near, slides),
            share(slides_false, traces),
        ]
    }
}

/// The tables of the page: what must hold, and every cell.
fn tables(rows: &[Row]) -> Tables {
    let bars: Vec<Bar> = BARS
        .iter()
        .enumerate()
        .map(|(n, bar)| judge(rows, n, *bar))
        .collect();
    let mut cells = Table::new(
        "group|cell|slide found, %|false slides, %|start, ms|end, ms|both near, %|both near what shows, %|\
         contact found, %|false contacts, %|contact, ms|release found, %|release, ms|good at rest, %|\
         start, 5 %, ms|start, 95 %, ms|end, 5 %, ms|end, 95 %, ms",
    );
    for Row { group, name, found } in rows {
        let ms = |errors: Option<[f64; 3]>, which: usize| fixed(errors.map(|all| all[which]), 0);
        cells.row([
            Value::from(group.as_str()),
            Value::from(name.as_str()),
            percent(found.slides_found, found.slides),
            percent(found.slides_false, found.traces),
            ms(found.start_ms, 1),
            ms(found.end_ms, 1),
            percent(found.near, found.slides),
            percent(found.near_visible, found.slides),
            percent(found.contacts_found, found.contacts),
            percent(found.contacts_false, found.traces),
            ms(found.contact_ms, 1),
            percent(found.releases_found, found.traces),
            ms(found.release_ms, 1),
            percent(found.still_good, found.traces),
            ms(found.start_ms, 0),
            ms(found.start_ms, 2),
            ms(found.end_ms, 0),
            ms(found.end_ms, 2),
        ]);
    }
    Tables::from([
        ("bars".into(), page::bars(&bars)),
        ("groups".into(), groups(rows)),
        ("cells".into(), cells),
    ])
}

/// The worst cell of each group.
fn groups(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "group|cells|slide found, at least %|false slides, at most %|both near what shows, at least %|\
         contact found, at least %|release found, at least %",
    );
    for group in GROUPS {
        let own: Vec<&Found> = rows
            .iter()
            .filter(|row| row.group == group)
            .map(|row| &row.found)
            .collect();
        let share =
            |count: u32, of: u32| (of > 0).then(|| 100.0 * f64::from(count) / f64::from(of));
        let least = |figure: &dyn Fn(&Found) -> Option<f64>| {
            fixed(
                own.iter()
                    .filter_map(|found| figure(found))
                    .reduce(f64::min),
                1,
            )
        };
        let most = own
            .iter()
            .filter_map(|found| share(found.slides_false, found.traces));
        table.row([
            Value::from(group),
            own.len().into(),
            least(&|found| share(found.slides_found, found.slides)),
            fixed(most.reduce(f64::max), 1),
            least(&|found| share(found.near_visible, found.slides)),
            least(&|found| share(found.contacts_found, found.contacts)),
            least(&|found| share(found.releases_found, found.traces)),
        ]);
    }
    table
}

/// A bar over all cells, with those beyond it by name.
fn judge(rows: &[Row], number: usize, bar: Limit) -> Bar {
    let Limit {
        what,
        limit,
        is_least,
    } = bar;
    let figures = rows
        .iter()
        .filter_map(|row| Some((row, row.judged()[number]?)));
    let is_beyond = |(_, share): &(&Row, f64)| {
        if is_least {
            *share < limit
        } else {
            *share > limit
        }
    };
    let beyond: Vec<String> = figures
        .filter(is_beyond)
        .map(|(row, share)| format!("{}: {share:.1}", row.name))
        .collect();
    Bar {
        bar: format!("{what}, %"),
        limit: format!("{} {limit}", if is_least { "at least" } else { "at most" }),
        met: beyond.is_empty(),
        measured: if beyond.is_empty() {
            "all cells".into()
        } else {
            beyond.join("; ")
        },
    }
}

/// The figures of these rows.
pub fn figures(rows: Vec<Row>) -> Figures<Rows> {
    Figures {
        tables: tables(&rows),
        detail: Rows { rows },
    }
}

/// What was measured last in a folder.
pub fn load(folder: &Path) -> Result<Vec<Row>> {
    page::load::<Rows>(folder, TOPIC).map(|figures| figures.detail.rows)
}

/// Writes the figures and the page.
pub fn write(rows: Vec<Row>, folder: &Path) -> Result<()> {
    page::write(folder, TOPIC, &figures(rows))
}

pub fn run(args: &TouchArgs) -> Result<()> {
    let rows = rows(args.traces, args.seed, args.group.as_deref())?;
    match &args.write {
        Some(folder) => write(rows, folder),
        None => page::print(&figures(rows).tables),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The measured figures repeat: a few traces of each cell of a group, on any number of cores.
    #[test]
    fn equal_seeds_give_equal_rows() {
        let rows = || rows(2, 5, Some("lift")).expect("rows");
        let first = rows();
        assert!(first.len() > 5 && first == rows());
    }
}
