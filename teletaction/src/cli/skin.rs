//! `skin`: the relaxation of a person's skin.

use crate::display::Kelvin;
use crate::skin::{Estimated, Relaxation, fit};
use anyhow::Result;
use clap::{Args, Subcommand};
use ridgetone_host::cli::parse::{number, positive};
use ridgetone_host::digits::plus_minus;
use ridgetone_host::output;
use ridgetone_host::samples::Samples;
use ridgetone_host::table_fit::Selection;
use std::path::PathBuf;

#[derive(Debug, Subcommand)]
#[command(after_help = "\
Example:
  ridgetone skin fit FORCE.csv --from 2.5")]
pub enum SkinCommand {
    /// Fit how the force of a finger relaxes under a deformation that stays.
    Fit(FitArgs),
}

#[derive(Debug, Args)]
#[command(after_help = "\
Press a flat plate onto the finger pad by a fixed depth, hold it, and record the force. The force is A + B exp(-c t); of A, B and c
follow the two relaxation times, which `pins --subject` takes.

Examples:
  ridgetone skin fit force.csv --from 2.5
  ridgetone skin fit force.csv --column force_n --rate 1000 --json")]
pub struct FitArgs {
    /// Recording of the force: CSV with a header.
    #[arg(value_name = "FORCE.csv")]
    file: PathBuf,
    /// Column of the force [default: the only one].
    #[arg(long, value_name = "NAME")]
    column: Option<String>,
    /// Rows per second [default: from the column time_s].
    #[arg(long, value_name = "HZ", value_parser = positive)]
    rate: Option<f64>,
    /// Time of the step, seconds [default: the first row].
    #[arg(long, value_name = "S", value_parser = number, allow_negative_numbers = true)]
    from: Option<f64>,
    /// Last time to use, seconds: the paper uses 15 s after the step.
    #[arg(long, value_name = "S", value_parser = number, allow_negative_numbers = true)]
    to: Option<f64>,
    /// One JSON object on one line instead of text.
    #[arg(long)]
    json: bool,
}

impl SkinCommand {
    pub(super) fn run(self) -> Result<()> {
        let Self::Fit(args) = self;
        let recording = Samples::file(&args.file)?;
        let selection = Selection {
            rate_hz: args.rate,
            from_s: args.from,
            to_s: args.to,
            columns: args.column.into_iter().collect(),
            ..Selection::default()
        };
        let found = fit(&recording, &selection)?;
        output::line(&if args.json {
            serde_json::to_string(&found)?
        } else {
            text(&found)?
        })
    }
}

/// The columns of the paper's Table 5, and the option that they make.
fn text(found: &Relaxation) -> Result<String> {
    let shown = |of: Estimated| plus_minus(of.value, of.sigma);
    // Refused here rather than by the display.
    let skin = Kelvin::new(found.relaxation_s.value, found.creep_s.value)?;
    Ok(format!(
        "A   {}\nB   {}\nc   {} /s\n\
         relaxation time for constant strain  {} s\n\
         relaxation time for constant stress  {} s\n\
         residual {:.2e} rms of {} rows, in the recording's unit\n\
         for a display: ridgetone pins --subject {:.3},{:.3}",
        shown(found.a),
        shown(found.b),
        shown(found.c_per_s),
        shown(found.relaxation_s),
        shown(found.creep_s),
        found.residual,
        found.rows,
        skin.relaxation_s(),
        skin.creep_s(),
    ))
}
