//! The commands: arguments in, output out.

use crate::faults::{self, FaultsArgs};
use crate::noise::{self, NoiseArgs};
use crate::page::{self, Figures, Tables};
use crate::trade;
use crate::trade::results::Trade;
use anyhow::Result;
use clap::{Args, Parser, Subcommand};
use ridgetone_host::output;
use ridgetone_host::usage::UsageError;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Proves Ridgetone: the cost and accuracy of each choice, the paper's experiment, injected faults.
#[derive(Debug, Parser)]
#[command(name = "ridgetone-eval", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Measure the accuracy of each choice, and of the scan plans and converters.
    Bench(BenchArgs),
    /// Fit windows whose noise is not white, that hold no tone, or a tone and something else.
    Noise(NoiseArgs),
    /// Make the tables and pictures of all pages again from the figures as they are.
    Pages {
        /// Their folder.
        #[arg(default_value = "docs/results")]
        folder: PathBuf,
        /// Fill in the tables of this page alone.
        #[arg(long, value_name = "NAME")]
        topic: Option<String>,
    },
    /// Inject faults into the chip, its bus and its lines, and count the consequences.
    Faults(FaultsArgs),
}

#[derive(Debug, Args)]
struct BenchArgs {
    /// Fewer windows, for a look.
    #[arg(long)]
    quick: bool,
    /// Write trade.json, scene.json and their pages into a folder, with the instructions that are
    /// there. `cargo xtask counts` counts them anew.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/results", conflicts_with = "quick")]
    write: Option<PathBuf>,
    /// Measure the scan plans instead: accuracy here, load and latency on the register model.
    /// Writes them into trade.json and trade.md in a folder. Takes three minutes.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/results", exclusive = true)]
    plans: Option<PathBuf>,
    /// Measure the STM32's own converter beside the ADS1258 instead. Writes them into trade.json and
    /// trade.md in a folder. Takes two minutes.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/results", exclusive = true)]
    converters: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

fn run_bench(args: &BenchArgs) -> Result<()> {
    if let Some(folder) = &args.plans {
        let plans = trade::plans::measure(trade::plans::WINDOWS, true)?;
        return trade::write(
            Trade {
                plans,
                ..trade::load(folder)?
            },
            folder,
        );
    }
    if let Some(folder) = &args.converters {
        let converters = trade::converters::measure(trade::converters::WINDOWS)?;
        return trade::write(
            Trade {
                converters,
                ..trade::load(folder)?
            },
            folder,
        );
    }
    let effort = if args.quick {
        trade::QUICK
    } else {
        trade::FULL
    };
    let Some(folder) = &args.write else {
        let trade = trade::measure(effort, Trade::default())?;
        if args.json {
            return output::line(&serde_json::to_string(&trade)?);
        }
        return page::print(&trade::figures(trade).tables);
    };
    let scenes = trade::scenes::measure(trade::scenes::load(folder)?)?;
    trade::scenes::write(scenes, folder)?;
    trade::write(trade::measure(effort, trade::load(folder)?)?, folder)
}

/// Makes the tables and pictures of a folder again; what is not measured there is left out.
fn make_pages(folder: &Path) -> Result<()> {
    trade::write(trade::load(folder)?, folder)?;
    noise::write(noise::load(folder)?, folder)?;
    fill(folder, "faults", faults::table::with_bars)
}

/// Fills in a page from its figures.
fn fill(folder: &Path, topic: &str, with_bars: fn(Tables) -> Tables) -> Result<()> {
    let Figures { tables, detail } = page::load::<page::None>(folder, topic)?;
    let tables = with_bars(tables);
    page::write(folder, topic, &Figures { tables, detail })
}

/// Runs the command of the process.
pub fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Bench(args) => run_bench(&args),
        Command::Noise(args) => noise::run(&args),
        Command::Pages {
            folder,
            topic: None,
        } => make_pages(&folder),
        Command::Pages {
            folder,
            topic: Some(topic),
        } => fill(&folder, &topic, |tables| tables),
        Command::Faults(args) => faults::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("ridgetone-eval: {error:#}");
            ExitCode::from(if error.is::<UsageError>() { 2 } else { 1 })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_that_make_no_sense_are_refused() {
        for (arguments, word) in [
            (&["--injections", "0"][..], "1.."),
            (&["--only", "edges"], "edges_lost"),
            (&["--only", "reset", "--write", "."], "--write"),
        ] {
            let refused = Cli::try_parse_from([&["ridgetone-eval", "faults"], arguments].concat());
            let error = refused.expect_err("refused");
            assert!(
                error.exit_code() == 2 && error.to_string().contains(word),
                "{arguments:?}: {error}"
            );
        }
    }
}
