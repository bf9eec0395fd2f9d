//! The cost and the accuracy of each choice: accuracy on this PC, with the code of the chip, beside instructions counted
//! on the emulated chip.

pub mod accuracy;
mod bars;
pub mod chart;
pub mod contender;
mod grid;
pub mod results;
mod tables;

use crate::bench::report::Report;
use crate::page::{filled, load};
use anyhow::Result;
use bars::{Bars, Windows};
use results::Trade;
use ridgetone_host::output::whole_file;
use std::path::Path;

/// The page with its tables as they were filled in last.
const PAGE: &str = include_str!("../../docs/trade.md");

/// How many windows are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// For the page: minutes.
    Full,
    /// For a look: seconds.
    Quick,
    /// For a test that it runs.
    #[cfg(test)]
    Least,
}

impl Effort {
    /// Windows of each line of Table 2 for a row, and those of the bars.
    fn windows(self) -> (u32, Windows) {
        match self {
            Self::Full => (100, Windows { accuracy: 1000, noise: 4000, detection: 1000 }),
            Self::Quick => (10, Windows { accuracy: 30, noise: 200, detection: 30 }),
            #[cfg(test)]
            Self::Least => (1, Windows { accuracy: 2, noise: 2, detection: 1 }),
        }
    }
}

/// Measures accuracy here and takes the instructions from a report of the chip, if there is one.
pub fn measure(effort: Effort, chip: Option<&Report>) -> Result<Trade> {
    let (windows, of_bars) = effort.windows();
    let mut rows = grid::measure(windows)?;
    if let Some(chip) = chip {
        rows.iter_mut().for_each(|row| row.instructions = grid::instructions(row, chip));
    }
    let chip = chip.map_or_else(Vec::new, |chip| chip.bars.clone());
    Ok(Trade { windows, rows, bars: Bars::measure(of_bars)?, chip })
}

/// Writes `trade.json`, and from it `trade.md` and `trade.svg`.
pub fn write(trade: &Trade, folder: &Path) -> Result<()> {
    let json = serde_json::to_string(trade)?;
    // A line for each row and setting, so that a diff shows which changed.
    let json = json.replace("},{\"method\"", "},\n{\"method\"").replace("},{\"setting\"", "},\n{\"setting\"");
    whole_file(&folder.join("trade.json"), |file| Ok(writeln!(file, "{json}")?))?;
    render(folder)
}

/// Writes `trade.md` and `trade.svg` from `trade.json`.
pub fn render(folder: &Path) -> Result<()> {
    let trade: Trade = load(&folder.join("trade.json"))?;
    let (page, svg) = (page(&trade)?, chart::draw(&trade));
    whole_file(&folder.join("trade.md"), |file| Ok(file.write_all(page.as_bytes())?))?;
    whole_file(&folder.join("trade.svg"), |file| Ok(file.write_all(svg.as_bytes())?))
}

pub fn page(trade: &Trade) -> Result<String> {
    filled(PAGE, |name| tables::table(trade, name))
}

/// The tables for a terminal.
pub fn summary(trade: &Trade) -> String {
    ["ridgetone", "baselines", "bars"].into_iter().filter_map(|name| tables::table(trade, name)).collect::<Vec<_>>().join("\n\n")
}
