//! Where noise is not white, where there is no tone, and where there is a tone and something else:
//! what the estimator answers, cell by cell, for docs/results/noise.md.

mod autoregressions;
mod bars;
mod bound;
mod cells;
mod kinds;
mod measure;
mod parts;
pub(crate) mod process;
mod recordings;
mod tables;
mod window;

use crate::page;
use crate::parallel;
use anyhow::Result;
pub use cells::WINDOWS_S;
use cells::{Cell, Group, cells};
pub use kinds::{Kind, kinds};
use measure::{Answers, measure};
use process::Noise;
use ridgetone_host::output;
use ridgetone_host::usage::UsageError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Windows of each cell by default.
const WINDOWS: u32 = 200;
/// The seed of the page. Constants of the estimator are chosen on others.
const SEED: u64 = 20_000;

const PAGE: &str = "noise.md";
const DATA: &str = "noise.json";
/// Of another seed than the page's, which shows how many of its figures are beyond their bars.
const DATA_OF_ANOTHER_SEED: &str = "noise-other-seed.json";

#[derive(Debug, clap::Args)]
#[command(after_help = "\
With 200 windows a cell it takes three minutes on two cores. Equal seeds give equal tables.

Examples:
  cargo xtask noise --windows 20
  cargo xtask noise --seed 1 --group sigma
  cargo xtask noise --write docs/results
  cargo xtask noise --seed 1 --write docs/results
  cargo xtask noise --render docs")]
pub struct NoiseArgs {
    /// Windows of each cell.
    #[arg(long, value_name = "N", default_value_t = WINDOWS, value_parser = clap::value_parser!(u32).range(1..))]
    windows: u32,
    /// Seed of the first window. Constants are chosen on other seeds than the page's.
    #[arg(long, value_name = "N", default_value_t = SEED)]
    seed: u64,
    /// Only this group: no_tone, something, sigma, accuracy, few_cycles or unsteady.
    #[arg(long, value_name = "NAME", conflicts_with = "write")]
    group: Option<String>,
    /// Only cells whose name contains this.
    #[arg(long, value_name = "TEXT", conflicts_with = "write")]
    cell: Option<String>,
    /// Folder with noise.md to fill in; noise.json is written beside it, with another seed than the
    /// page's noise-other-seed.json.
    #[arg(long, value_name = "FOLDER")]
    write: Option<PathBuf>,
    /// Recordings without a tone as CSV, of sixteen channels: cells with their noise are added.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    real: Vec<PathBuf>,
    /// Measure nothing: fill in noise.md of a folder from noise.json.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/results", exclusive = true)]
    render: Option<PathBuf>,
}

/// The answers of a row, a column for each of [`WINDOWS_S`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    group: Group,
    name: String,
    snr_db: Option<f64>,
    answers: Vec<Answers>,
    /// Of the opponent, to some of the windows.
    #[serde(default)]
    nls: Vec<Answers>,
}

impl Row {
    /// The name, and the signal to noise ratio where the group has several.
    fn title(&self) -> String {
        let several = matches!(self.group, Group::Sigma | Group::Accuracy);
        let snr = self
            .snr_db
            .filter(|_| several)
            .map_or(String::new(), |db| format!(", {db} dB"));
        format!("{}{snr}", self.name)
    }

    /// The cell that it is of; none if no cell has its name any more.
    pub(crate) fn cell(&self) -> Option<Cell> {
        let of = |cell: &Cell| {
            (
                cell.group,
                cell.name,
                cell.recipe.tone.map(|tone| tone.snr_db),
            )
        };
        cells(Some(Noise::Real(&[])))
            .into_iter()
            .find(|cell| of(cell) == (self.group, self.name.as_str(), self.snr_db))
    }
}

/// The answers of every cell, or of those of one group, or whose name contains a text; with noise
/// of the recordings, where there are some.
pub fn rows(
    windows: u32,
    seed: u64,
    of: (Option<&str>, Option<&str>),
    recordings: &[PathBuf],
) -> Result<Vec<Row>> {
    let (group, name) = of;
    let wanted = |cell: &Cell| {
        group.is_none_or(|wanted| wanted == cell.group.name())
            && name.is_none_or(|part| cell.name.contains(part))
    };
    let cells: Vec<_> = cells(recordings::noise(recordings)?)
        .into_iter()
        .filter(wanted)
        .collect();
    if cells.is_empty() {
        let groups = Group::ALL.map(Group::name).join(", ");
        return Err(UsageError(format!(
            "no cell; --group: one of {groups}; --cell: a part of a row's name"
        ))
        .into());
    }
    let jobs: Vec<_> = cells
        .iter()
        .flat_map(|cell| WINDOWS_S.map(|window_s| (cell.recipe, window_s, windows * cell.times)))
        .collect();
    let answers = parallel::map("cells", &jobs, |(recipe, window_s, windows)| {
        measure(recipe, *window_s, *windows, seed)
    })?;
    let answers = answers.chunks_exact(WINDOWS_S.len());
    let row = |(cell, answers): (&Cell, &[[Answers; 2]])| Row {
        group: cell.group,
        name: cell.name.to_owned(),
        snr_db: cell.recipe.tone.map(|tone| tone.snr_db),
        answers: answers.iter().map(|both| both[0]).collect(),
        nls: answers.iter().map(|both| both[1]).collect(),
    };
    Ok(cells.iter().zip(answers).map(row).collect())
}

/// The page with its tables filled in, from the rows of its seed and from those of another.
pub fn page(rows: &[Row], other_seed: &[Row], text: &str) -> Result<String> {
    page::filled(text, |name| {
        if name == tables::MISSED {
            Some(tables::missed(rows, other_seed))
        } else {
            tables::table(rows, name)
        }
    })
}

/// The rows that were measured last, from a folder; none where nothing was.
pub fn load(folder: &Path) -> Result<Vec<Row>> {
    page::load_measured(folder, DATA)
}

/// The same of another seed.
pub fn load_other_seed(folder: &Path) -> Result<Vec<Row>> {
    page::load_measured(folder, DATA_OF_ANOTHER_SEED)
}

/// Fills in the page of a folder from its data.
fn render(folder: &Path) -> Result<()> {
    page::render(folder, PAGE, |text| {
        page(&load(folder)?, &load_other_seed(folder)?, text)
    })
}

/// Does it, and gives the folder whose page it wrote.
pub fn run(args: &NoiseArgs) -> Result<Option<&Path>> {
    if let Some(folder) = &args.render {
        return render(folder).map(|()| Some(folder.as_path()));
    }
    let of = (args.group.as_deref(), args.cell.as_deref());
    let rows = rows(args.windows, args.seed, of, &args.real)?;
    if let Some(folder) = &args.write {
        // A line for each row, so that a diff shows which changed.
        let json = serde_json::to_string(&rows)?.replace("},{\"group\"", "},\n{\"group\"");
        let data = if args.seed == SEED {
            DATA
        } else {
            DATA_OF_ANOTHER_SEED
        };
        output::whole_text(&folder.join(data), &(json + "\n"))?;
        return render(folder).map(|()| Some(folder.as_path()));
    }
    let measured = |group: &Group| rows.iter().any(|row| row.group == *group);
    for name in Group::ALL
        .into_iter()
        .filter(measured)
        .flat_map(tables::names)
    {
        output::line(&format!(
            "{name}\n{}\n",
            tables::table(&rows, &name).unwrap_or_default()
        ))?;
    }
    output::line(&format!(
        "{}\n{}",
        tables::MISSED,
        tables::missed(&rows, &[])
    ))?;
    Ok(None)
}
