//! The commands: arguments in, output out.

use crate::board::{self, BoardArgs};
use crate::faults::{self, FaultsArgs};
use crate::noise::{self, NoiseArgs};
use crate::page::{self, Figures, Tables};
use crate::real::{self, RealArgs};
use crate::reproduce;
use crate::reproduce::results::Reproduction;
use crate::reproduce::taken::Place;
use crate::touch::{self, TouchArgs};
use crate::trade;
use crate::trade::results::Trade;
use anyhow::Result;
use clap::{Args, Parser, Subcommand};
use ridgetone_host::cli::firmware::FirmwareOptions;
use ridgetone_host::emulator::Options;
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
    /// Repeat the paper's experiment on the physical finger, figure for figure beside its own.
    Reproduce(ReproduceArgs),
    /// Measure the accuracy of each choice, and of the scan plans and converters.
    Bench(BenchArgs),
    /// Measure start, load, interrupts and jitter of the boards' images on the register model.
    Board(BoardArgs),
    /// Fit windows whose noise is not white, that hold no tone, or a tone and something else.
    Noise(NoiseArgs),
    /// Fit recordings of real touch whose frequency is known, and some without a grating.
    Real(RealArgs),
    /// Look for contacts, slides and releases in traces with known times.
    Touch(TouchArgs),
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
#[command(after_help = "\
Takes a minute or two, with --emulated some minutes. Writes papers-runs.json, papers-runs.md and its pictures.

Examples:
  cargo xtask reproduce --out paper
  cargo xtask reproduce --emulated --out paper
  cargo xtask reproduce --wavelengths")]
struct ReproduceArgs {
    /// Run the firmware image on an emulated board instead of its library on this PC; both give the
    /// same numbers.
    #[arg(long)]
    emulated: bool,
    #[command(flatten)]
    firmware: FirmwareOptions,
    /// Runs of each of the ten combinations, 1 to 4 as in the paper.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=4))]
    runs: u32,
    /// Folder to write to.
    #[arg(long, value_name = "FOLDER", default_value = "docs/results")]
    out: PathBuf,
    /// Measure the other paper's wavelengths and powers (Okamoto et al.) instead.
    #[arg(long, conflicts_with_all = ["emulated", "runs"])]
    wavelengths: bool,
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
    touch::write(touch::load(folder)?, folder)?;
    let papers = page::load::<Reproduction>(folder, reproduce::TOPIC)?;
    reproduce::write(papers.detail, folder)?;
    reproduce::okamoto::write_picture(folder)?;
    fill(folder, "boards", board::with_bars)?;
    fill(folder, "faults", faults::table::with_bars)?;
    fill(folder, "papers", |tables| tables)
}

/// Fills in a page from its figures.
fn fill(folder: &Path, topic: &str, with_bars: fn(Tables) -> Tables) -> Result<()> {
    let Figures { tables, detail } = page::load::<page::None>(folder, topic)?;
    let tables = with_bars(tables);
    page::write(folder, topic, &Figures { tables, detail })
}

fn run_reproduce(args: &ReproduceArgs) -> Result<()> {
    if args.wavelengths {
        return reproduce::okamoto::write(&args.out);
    }
    if args.firmware.elf.is_some() && !args.emulated {
        return Err(UsageError(
            "--elf names a firmware image, which only runs with --emulated".into(),
        )
        .into());
    }
    let firmware = args.emulated.then(|| args.firmware.image()).transpose()?;
    let options = firmware.as_ref().map(Options::new);
    let place = options.as_ref().map_or(Place::Pc, Place::Emulator);
    reproduce::write(reproduce::measure(args.runs, place)?, &args.out)
}

/// Runs the command of the process.
pub fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Reproduce(args) => run_reproduce(&args),
        Command::Bench(args) => run_bench(&args),
        Command::Board(args) => board::run(&args),
        Command::Noise(args) => noise::run(&args),
        Command::Real(args) => real::run(&args),
        Command::Pages {
            folder,
            topic: None,
        } => make_pages(&folder),
        Command::Pages {
            folder,
            topic: Some(topic),
        } => fill(&folder, &topic, |tables| tables),
        Command::Touch(args) => touch::run(&args),
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

    #[test]
    fn a_reproduction_that_makes_no_sense_is_refused() {
        let args = |arguments: &[&str]| {
            Cli::try_parse_from([&["ridgetone-eval", "reproduce"], arguments].concat())
        };
        let runs = args(&["--runs", "5"]).expect_err("refused").to_string();
        assert!(runs.contains("--runs") && runs.contains("1..=4"), "{runs}");
        let refused = |arguments: &[&str]| match args(arguments).expect("arguments").command {
            Command::Reproduce(args) => run_reproduce(&args).expect_err("refused"),
            command => panic!("{command:?}"),
        };
        let elf = refused(&["--elf", "image.elf"]);
        assert!(
            elf.is::<UsageError>() && elf.to_string().contains("--emulated"),
            "{elf}"
        );
    }
}
