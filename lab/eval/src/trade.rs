//! The cost and the accuracy of each choice: accuracy on this PC, with the code of the chip, beside
//! instructions counted on the emulated chip.

mod bars;
pub mod chart;
pub mod contender;
mod grid;
mod noise_chart;
pub mod plans;
pub mod results;
mod tables;

pub use bars::Windows;

use crate::bench::report::Report;
use crate::noise;
use crate::page::{filled, load};
use anyhow::Result;
use bars::Bars;
use results::Trade;
use ridgetone_host::output::whole_text;
use std::path::Path;

/// The page with its tables as they were filled in last.
const PAGE: &str = include_str!("../../../docs/results/trade.md");

/// Windows of each line of Table 2 for a row, and those of the bars.
pub type Effort = (u32, Windows);
/// For the page: minutes.
pub const FULL: Effort = (
    100,
    Windows {
        accuracy: 1000,
        noise: 4000,
        detection: 1000,
    },
);
/// For a look: seconds.
pub const QUICK: Effort = (
    10,
    Windows {
        accuracy: 30,
        noise: 200,
        detection: 30,
    },
);

/// Measures accuracy here and takes the instructions from a report of the chip, if there is one.
pub fn measure((windows, of_bars): Effort, chip: Option<&Report>) -> Result<Trade> {
    let mut rows = grid::measure(windows)?;
    if let Some(chip) = chip {
        rows.iter_mut()
            .for_each(|row| row.instructions = grid::instructions(row, chip));
    }
    let (chip, feels) = chip.map_or_else(Default::default, |chip| {
        (chip.bars.clone(), chip.feels.clone())
    });
    Ok(Trade {
        windows,
        rows,
        bars: Bars::measure(of_bars)?,
        feels,
        chip,
    })
}

/// Writes `trade.json`, and from it `trade.md` and `trade.svg`.
pub fn write(trade: &Trade, folder: &Path) -> Result<()> {
    let json = serde_json::to_string(trade)?;
    // A line for each row and setting, so that a diff shows which changed.
    let json = json
        .replace("},{\"method\"", "},\n{\"method\"")
        .replace("},{\"setting\"", "},\n{\"setting\"");
    whole_text(&folder.join("trade.json"), &(json + "\n"))?;
    render(folder)
}

/// Writes `trade.md` and `trade.svg` from `trade.json`.
pub fn render(folder: &Path) -> Result<()> {
    let trade: Trade = load(&folder.join("trade.json"))?;
    let noise = noise::load(folder)?;
    whole_text(
        &folder.join("trade.md"),
        &page(&trade, &noise, &plans::load(folder)?)?,
    )?;
    whole_text(&folder.join("trade.svg"), &chart::draw(&trade, &noise))
}

/// The page; its tables of noise and of scan plans are those of the rows that were measured last,
/// by runs of their own.
pub fn page(trade: &Trade, noise: &[noise::Row], plans: &[plans::Row]) -> Result<String> {
    filled(PAGE, |name| match name {
        "noise" => Some(tables::noise(noise)),
        "plans" => Some(plans::table(plans)),
        _ => tables::table(trade, name),
    })
}

/// The tables for a terminal.
pub fn summary(trade: &Trade, noise: &[noise::Row]) -> String {
    let tables = ["ridgetone", "baselines", "bars"]
        .into_iter()
        .filter_map(|name| tables::table(trade, name));
    tables
        .chain([tables::noise(noise)])
        .collect::<Vec<_>>()
        .join("\n\n")
}
