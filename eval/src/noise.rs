//! Where noise is not white, where there is no tone, and where there is a tone and something else: what the estimator
//! answers, cell by cell, for docs/noise.md.

mod cells;
mod measure;
mod process;
mod window;

use crate::page::{self, Table};
use crate::parallel;
use anyhow::{Context, Result};
use cells::{Cell, Group, WINDOWS_S, cells};
use measure::{Answers, measure, percent};
use ridgetone_host::output;
use ridgetone_host::usage::UsageError;
use serde::{Deserialize, Serialize};
use std::fs;
#[cfg(test)]
use std::path::Path;
use std::path::PathBuf;

/// Windows of each cell by default.
const WINDOWS: u32 = 200;
/// The seed of the page. Constants of the estimator are chosen on others.
const SEED: u64 = 20_000;

const PAGE: &str = "noise.md";
const DATA: &str = "noise.json";

#[derive(Debug, clap::Args)]
#[command(after_help = "\
With 200 windows a cell it takes some minutes. Equal seeds give equal tables.

Examples:
  cargo xtask noise --windows 20
  cargo xtask noise --seed 1 --group sigma
  cargo xtask noise --write docs")]
pub struct NoiseArgs {
    /// Windows of each cell.
    #[arg(long, value_name = "N", default_value_t = WINDOWS, value_parser = clap::value_parser!(u32).range(1..))]
    windows: u32,
    /// Seed of the first window. Constants are chosen on other seeds than the page's.
    #[arg(long, value_name = "N", default_value_t = SEED)]
    seed: u64,
    /// Only this group: no_tone, something, sigma, few_cycles or unsteady.
    #[arg(long, value_name = "NAME", conflicts_with = "write")]
    group: Option<String>,
    /// Folder with noise.md to fill in; noise.json is written beside it.
    #[arg(long, value_name = "FOLDER")]
    write: Option<PathBuf>,
}

/// The answers of a row, a column for each of [`WINDOWS_S`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    group: Group,
    name: String,
    snr_db: Option<f64>,
    answers: Vec<Answers>,
}

fn name(group: Group) -> String {
    serde_json::to_value(group).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

/// What a cell of the table says of its answers.
fn text(group: Group, answers: &Answers) -> String {
    let good = percent(answers.good, answers.windows);
    match group {
        Group::NoTone => format!("{good:.1}"),
        Group::Something | Group::FewCycles => {
            format!("{good:.0} / {:.1}", percent(answers.wrong, answers.good))
        }
        Group::Sigma => {
            let covered = percent(answers.covered, answers.good);
            format!("{covered:.1} / {}", page::figure(answers.error_in_sigmas(), 2))
        }
        Group::Unsteady => {
            let covered = percent(answers.covered, answers.good);
            format!("{good:.0} / {covered:.0} / {:.0}", percent(answers.covered_weighted, answers.good))
        }
    }
}

/// The table of a group.
fn table(group: Group, rows: &[Row]) -> String {
    let mut table = Table::new(1, &format!("|{}", WINDOWS_S.map(|s| format!("{s} s")).join("|")));
    for row in rows.iter().filter(|row| row.group == group) {
        let snr = row.snr_db.filter(|_| group == Group::Sigma).map_or(String::new(), |db| format!(", {db} dB"));
        let cells = row.answers.iter().map(|answers| text(group, answers));
        table.row(&[vec![format!("{}{snr}", row.name)], cells.collect()].concat());
    }
    table.end()
}

/// The answers of every cell, or of those of one group.
pub fn rows(windows: u32, seed: u64, group: Option<&str>) -> Result<Vec<Row>> {
    let wanted = |cell: &Cell| group.is_none_or(|wanted| wanted == name(cell.group));
    let cells: Vec<_> = cells().into_iter().filter(wanted).collect();
    if cells.is_empty() {
        return Err(UsageError(format!("--group: one of {}", Group::ALL.map(name).join(", "))).into());
    }
    let jobs: Vec<_> = cells.iter().flat_map(|cell| WINDOWS_S.map(|window_s| (cell.recipe, window_s))).collect();
    let answers = parallel::map("cells", &jobs, |(recipe, window_s)| measure(recipe, *window_s, windows, seed))?;
    let answers = answers.chunks_exact(WINDOWS_S.len());
    let row = |(cell, answers): (&Cell, &[Answers])| Row {
        group: cell.group,
        name: cell.name.to_owned(),
        snr_db: cell.recipe.tone.map(|tone| tone.snr_db),
        answers: answers.to_vec(),
    };
    Ok(cells.iter().zip(answers).map(row).collect())
}

/// The page with its tables filled in.
pub fn page(rows: &[Row], text: &str) -> Result<String> {
    let group = |wanted: &str| Group::ALL.into_iter().find(|group| name(*group) == wanted);
    page::filled(text, |name| Some(table(group(name)?, rows)))
}

/// The rows that were measured last, from a folder.
#[cfg(test)]
pub fn load(folder: &Path) -> Result<Vec<Row>> {
    page::load(&folder.join(DATA))
}

pub fn run(args: &NoiseArgs) -> Result<()> {
    let rows = rows(args.windows, args.seed, args.group.as_deref())?;
    let Some(folder) = &args.write else {
        let measured = |group: &Group| rows.iter().any(|row| row.group == *group);
        for group in Group::ALL.into_iter().filter(measured) {
            output::line(&format!("{}\n{}\n", name(group), table(group, &rows)))?;
        }
        return Ok(());
    };
    let (path, data) = (folder.join(PAGE), folder.join(DATA));
    let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    fs::write(&path, page(&rows, &text)?).with_context(|| path.display().to_string())?;
    fs::write(&data, serde_json::to_string(&rows)? + "\n").with_context(|| data.display().to_string())?;
    output::line(&path.display().to_string())
}
