//! The commands: arguments in, output out.

use crate::board::{self, BoardArgs};
use crate::faults::{self, FaultsArgs};
use crate::page::{self, Figures, Tables};
use crate::real::{self, RealArgs};
use crate::reproduce;
use crate::reproduce::results::Reproduction;
use crate::reproduce::taken::Place;
use crate::touch::{self, TouchArgs};
use anyhow::Result;
use clap::{Args, Parser, Subcommand};
use ridgetone_host::cli::firmware::FirmwareOptions;
use ridgetone_host::emulator::Options;
use ridgetone_host::usage::UsageError;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Proves Ridgetone: the paper's experiment, touches, recordings, injected faults.
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
    /// Measure start, load, interrupts and jitter of the boards' images on the register model.
    Board(BoardArgs),
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

/// Makes the tables and pictures of a folder again; what is not measured there is left out.
fn make_pages(folder: &Path) -> Result<()> {
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
        Command::Board(args) => board::run(&args),
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
