//! Touches against their truth: contact, slide and release in traces with known times, cell by
//! cell, for docs/results/touch.md.

mod cells;
mod measure;
mod tables;
mod trace;

use crate::{page, parallel};
use anyhow::Result;
use cells::{GROUPS, cells};
use measure::{Found, measure};
use ridgetone_host::output;
use ridgetone_host::usage::UsageError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Traces of each cell by default.
const TRACES: u32 = 200;
/// The seed of the page. Constants of the detector are chosen on others.
const SEED: u64 = 30_000;

const PAGE: &str = "touch.md";
const DATA: &str = "touch.json";

#[derive(Debug, clap::Args)]
#[command(after_help = "\
With 200 traces a cell it takes some minutes on two cores. Equal seeds give equal tables.

Examples:
  cargo xtask touch --traces 20
  cargo xtask touch --seed 1 --group tones
  cargo xtask touch --write docs/results
  cargo xtask touch --render docs")]
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
    /// Folder with touch.md to fill in; touch.json is written beside it.
    #[arg(long, value_name = "FOLDER")]
    write: Option<PathBuf>,
    /// With --write: these are the figures that later ones are compared with.
    #[arg(long, requires = "write")]
    before: bool,
    /// Measure nothing: fill in touch.md of a folder from touch.json.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/results", exclusive = true)]
    render: Option<PathBuf>,
}

/// A row of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    group: String,
    name: String,
    found: Found,
}

/// What the page shows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Data {
    before: Vec<Row>,
    now: Vec<Row>,
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

/// The page with its tables filled in: those of before are called `before_GROUP`.
pub fn page(data: &Data, text: &str) -> Result<String> {
    page::filled(text, |name| match name.strip_prefix("before_") {
        Some(group) => tables::table(&data.before, group),
        None => tables::table(&data.now, name),
    })
}

/// What was measured last, from a folder; nothing where nothing was.
pub fn load(folder: &Path) -> Result<Data> {
    page::load_measured(folder, DATA)
}

/// Fills in the page of a folder from its data.
fn render(folder: &Path) -> Result<()> {
    page::render(folder, PAGE, |text| page(&load(folder)?, text))
}

pub fn run(args: &TouchArgs) -> Result<()> {
    if let Some(folder) = &args.render {
        return render(folder);
    }
    let rows = rows(args.traces, args.seed, args.group.as_deref())?;
    if let Some(folder) = &args.write {
        let mut data = load(folder)?;
        *(if args.before {
            &mut data.before
        } else {
            &mut data.now
        }) = rows;
        // A line for each row, so that a diff shows which changed.
        let json = serde_json::to_string(&data)?.replace("{\"group\"", "\n{\"group\"");
        output::whole_text(&folder.join(DATA), &(json + "\n"))?;
        return if folder.join(PAGE).is_file() {
            render(folder)
        } else {
            Ok(())
        };
    }
    for (name, table) in GROUPS
        .iter()
        .filter_map(|name| Some((name, tables::table(&rows, name)?)))
    {
        output::line(&format!("{name}\n{table}\n"))?;
    }
    Ok(())
}
