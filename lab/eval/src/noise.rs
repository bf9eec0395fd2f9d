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
mod window;

use crate::page::{self, Figures, Tables};
use crate::parallel;
use anyhow::{Context, Result};
use cells::{Cell, Group, WINDOWS_S, cells};
pub use measure::Answers;
use measure::measure;
use process::Noise;
use ridgetone_host::output::whole_text;
use ridgetone_host::usage::UsageError;
use ridgetone_tone::Scene;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Windows of each cell by default.
const WINDOWS: u32 = 200;
/// The seed of the page. Constants of the estimator are chosen on others.
const SEED: u64 = 20_000;

const TOPIC: &str = "noise";

#[derive(Debug, clap::Args)]
#[command(after_help = "\
With 200 windows a cell it takes three minutes on two cores. Equal seeds give equal tables.

Examples:
  cargo xtask noise --windows 20
  cargo xtask noise --seed 1 --group sigma
  cargo xtask noise --write")]
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
    /// Write noise.json and its picture into a folder, and fill in noise.md there.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/results")]
    write: Option<PathBuf>,
    /// Recordings without a tone as CSV, of sixteen channels: cells with their noise are added.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    real: Vec<PathBuf>,
}

/// The answers of a row, a column for each of [`WINDOWS_S`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    group: Group,
    name: String,
    snr_db: Option<f64>,
    answers: Vec<Answers>,
    /// The opponent's answers, to some of the windows.
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

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rows {
    rows: Vec<Row>,
}

/// Which cells: all, those of a group, or those whose name contains a text.
#[derive(Clone, Copy, Default)]
pub struct Selection<'a> {
    pub group: Option<&'a str>,
    pub name: Option<&'a str>,
}

/// The answers of the selected cells; with noise of the recordings, where there are some.
pub fn rows(
    windows: u32,
    seed: u64,
    selection: Selection<'_>,
    recordings: &[PathBuf],
) -> Result<Vec<Row>> {
    let Selection { group, name } = selection;
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
        measure(recipe, *window_s, *windows, seed, &Scene::DEFAULT)
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

/// The answers to windows of 1 s of the cell of this name, with a tone at 20 dB, in a scene.
pub fn beside(name: &str, windows: u32, seed: u64, scene: &Scene) -> Result<[Answers; 2]> {
    let cells = cells(None);
    let cell = cells.iter().find(|cell| {
        let tone = cell.recipe.tone;
        cell.name == name && tone.is_some_and(|tone| tone.snr_db == 20.0)
    });
    let cell = cell.with_context(|| format!("no cell {name}"))?;
    measure(&cell.recipe, 1.0, windows, seed, scene)
}

/// The figures of these rows.
pub fn figures(rows: Vec<Row>) -> Figures<Rows> {
    let tables = Tables::from([
        ("bars".into(), bars::table(&rows)),
        ("kinds".into(), kinds::table(&rows)),
    ]);
    Figures {
        tables,
        detail: Rows { rows },
    }
}

/// Writes the figures, the page and its picture.
pub fn write(rows: Vec<Row>, folder: &Path) -> Result<()> {
    let figures = figures(rows);
    page::write(folder, TOPIC, &figures)?;
    whole_text(
        &folder.join("noise.svg"),
        &kinds::picture(&figures.detail.rows),
    )
}

/// The picture of the page.
#[cfg(test)]
pub fn picture(detail: &Rows) -> String {
    kinds::picture(&detail.rows)
}

/// What was measured last in a folder.
pub fn load(folder: &Path) -> Result<Vec<Row>> {
    page::load::<Rows>(folder, TOPIC).map(|figures| figures.detail.rows)
}

pub fn run(args: &NoiseArgs) -> Result<()> {
    let selection = Selection {
        group: args.group.as_deref(),
        name: args.cell.as_deref(),
    };
    let rows = rows(args.windows, args.seed, selection, &args.real)?;
    match &args.write {
        Some(folder) => write(rows, folder),
        None => page::print(&figures(rows).tables),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::from_root;

    /// The measured figures repeat: a few windows of each cell, on any number of cores.
    #[test]
    fn equal_seeds_give_equal_rows() {
        let rows = || rows(2, 5, Selection::default(), &[]).expect("rows");
        let first = rows();
        assert!(first.len() > 50 && first == rows());
    }

    /// A renamed cell would lose its bars.
    #[test]
    fn each_row_of_the_data_has_its_cell() {
        let rows = load(&from_root("docs/results")).expect("the data");
        assert!(!rows.is_empty() && rows.iter().all(|row| row.cell().is_some()));
    }
}
