//! What each choice costs and brings: accuracy on this PC, with the code of the chip, beside instructions counted on
//! the emulated chip.

mod accuracy;
mod bars;
mod chart;
mod contender;
mod document;
mod grid;
mod tables;
mod text;

pub use accuracy::{Accuracy, Answer, Error, Sample};
pub use bars::{Bars, Cell, Found, Windows};
pub use contender::{Contender, fit};
pub use document::{advice, with_advice};
pub use grid::Row;

use crate::baselines::Method;
use crate::bench::{Bar, Report};
use anyhow::{Context, Result};
use ridgetone_host::output::whole_file;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;

/// A bar, and whether it is met.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BarResult {
    /// Of what.
    pub bar: String,
    /// What is allowed.
    pub limit: String,
    /// What it is.
    pub measured: String,
    /// Whether it is met.
    pub met: bool,
}

impl From<&Bar> for BarResult {
    fn from(bar: &Bar) -> Self {
        let [limit, measured] = [bar.limit, bar.measured].map(crate::bench::grouped);
        Self { bar: bar.what.into(), limit: format!("at most {limit}"), measured, met: bar.met }
    }
}

/// How many windows are worth measuring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// For the document: minutes.
    Full,
    /// For a look: seconds.
    Quick,
    /// To see that it runs.
    Least,
}

impl Effort {
    /// Windows of each line of Table 2 for a row, and those of the bars.
    fn windows(self) -> (u32, Windows) {
        match self {
            Self::Full => (100, Windows { accuracy: 1000, noise: 4000, detection: 1000 }),
            Self::Quick => (10, Windows { accuracy: 30, noise: 200, detection: 30 }),
            Self::Least => (1, Windows { accuracy: 2, noise: 2, detection: 1 }),
        }
    }
}

/// All that was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trade {
    /// Windows of each line of Table 2 in a row.
    pub windows: u32,
    /// Every choice.
    pub rows: Vec<Row>,
    /// The bars of accuracy.
    pub bars: Bars,
    /// The bars of what is counted on the chip.
    pub chip: Vec<BarResult>,
}

impl Trade {
    /// Measures accuracy here and takes the instructions from a report of the chip, if there is one.
    ///
    /// # Errors
    /// A window that cannot be made.
    pub fn measure(effort: Effort, chip: Option<&Report>) -> Result<Self> {
        let (windows, of_bars) = effort.windows();
        let mut rows = grid::measure(windows)?;
        if let Some(chip) = chip {
            rows.iter_mut().for_each(|row| row.instructions = grid::instructions(row, chip));
        }
        let verdicts = chip.map_or_else(Vec::new, |chip| chip.bars.iter().map(BarResult::from).collect());
        Ok(Self { windows, rows, bars: Bars::measure(of_bars)?, chip: verdicts })
    }

    /// Every bar, those of accuracy first.
    pub fn verdicts(&self) -> Vec<BarResult> {
        let mut verdicts = self.bars.verdicts();
        verdicts.extend(self.chip.iter().cloned());
        verdicts
    }

    /// The row of a fit of up to `harmonics` harmonics in scenes of `carried`.
    pub fn ridgetone(&self, window_s: f64, carried: u8, harmonics: u8, channels: u8) -> Option<&Row> {
        let key = (grid::RIDGETONE, window_s, carried, harmonics, channels);
        self.rows
            .iter()
            .find(|row| (row.method.as_str(), row.window_s, row.carried, row.harmonics, row.channels) == key)
    }

    /// The rows of another method in scenes of `carried` harmonics: on all channels, and on those that the chip has room
    /// for where these are fewer.
    pub fn baseline(&self, window_s: f64, carried: u8, method: Method) -> impl Iterator<Item = &Row> {
        let key = (method.name(), window_s, carried);
        self.rows.iter().filter(move |row| (row.method.as_str(), row.window_s, row.carried) == key)
    }

    /// Writes `trade.json`, and from it `trade.md` and `trade.svg`.
    ///
    /// # Errors
    /// Those of the system; no instructions are in it.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let json = serde_json::to_string(self)?;
        // A line for each row and setting: a run's changes can be read.
        let json = json.replace("},{\"method\"", "},\n{\"method\"").replace("},{\"setting\"", "},\n{\"setting\"");
        whole_file(&folder.join("trade.json"), |file| Ok(writeln!(file, "{json}")?))?;
        Self::render(folder)
    }

    /// Writes `trade.md` and `trade.svg` from `trade.json`, and the advice into the README beside the folder, if there is
    /// one with a place for it.
    ///
    /// # Errors
    /// Those of the system; the file is not what a run writes.
    pub fn render(folder: &Path) -> Result<()> {
        let trade = Self::load(&folder.join("trade.json"))?;
        let (document, svg) = (trade.document()?, trade.svg());
        whole_file(&folder.join("trade.md"), |file| Ok(file.write_all(document.as_bytes())?))?;
        whole_file(&folder.join("trade.svg"), |file| Ok(file.write_all(svg.as_bytes())?))?;
        let path = folder.join("../README.md");
        let advice = advice(&trade)?;
        let readme = fs::read_to_string(&path).ok().and_then(|readme| with_advice(&readme, &advice));
        readme.map_or(Ok(()), |readme| whole_file(&path, |file| Ok(file.write_all(readme.as_bytes())?)))
    }

    /// Reads `trade.json`.
    ///
    /// # Errors
    /// Those of the system; the file is not what a run writes.
    pub fn load(path: &Path) -> Result<Self> {
        let text = fs::read_to_string(path).with_context(|| path.display().to_string())?;
        serde_json::from_str(&text).with_context(|| path.display().to_string())
    }

    /// The document.
    ///
    /// # Errors
    /// No instructions are in it.
    pub fn document(&self) -> Result<String> {
        document::document(self)
    }

    /// The picture.
    pub fn svg(&self) -> String {
        chart::draw(self)
    }
}
