//! `export`: a recording of telemetry in other formats.

use super::lines::report;
use crate::export::{Format, Kind, run};
use crate::live::Counts;
use crate::usage::UsageError;
use crate::{output, stop};
use anyhow::Result;
use clap::Args;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
#[command(after_help = "\
`fit` and `replay` read the CSV of frames, `replay` to run the same touch with other settings. The other tables have
a column for each value of the JSON; what is not known is empty.

Examples:
  ridgetone export touch.rec -o estimates.csv
  ridgetone export touch.rec --table frames -o frames.csv
  ridgetone export touch.rec -o touch.mcap
  ridgetone export touch.rec --format ndjson | head")]
pub struct ExportArgs {
    /// Recording of telemetry.
    #[arg(value_name = "RECORDING")]
    file: PathBuf,
    /// Format [default: by the file's name: .csv, .ndjson, .jsonl or .mcap; csv with --table].
    #[arg(long, value_enum, value_name = "FORMAT")]
    format: Option<Format>,
    /// Rows of the CSV table [default: estimates].
    #[arg(long, value_enum, value_name = "KIND")]
    table: Option<Kind>,
    /// File to write [default: standard output].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl ExportArgs {
    pub(super) fn run(self) -> Result<()> {
        let by_name = || self.output.as_deref().and_then(Format::by_name);
        let by_table = || self.table.map(|_| Format::Csv);
        let Some(format) = self.format.or_else(by_name).or_else(by_table) else {
            return Err(
                UsageError("the file's name does not say the format: add --format".into()).into(),
            );
        };
        if self.table.is_some() && format != Format::Csv {
            return Err(UsageError(
                "--table is for --format csv: the others hold everything".into(),
            )
            .into());
        }
        stop::on_signal()?;
        let kind = self.table.unwrap_or(Kind::Estimates);
        let mut counts = Counts::default();
        let path = self.output.as_deref().unwrap_or(Path::new("-"));
        if format == Format::Mcap && path == Path::new("-") && std::io::stdout().is_terminal() {
            return Err(UsageError(
                "MCAP is not for a terminal: write it to a file with -o".into(),
            )
            .into());
        }
        output::new_file(path, |out| {
            counts = run(&self.file, format, kind, out)?;
            Ok(())
        })?;
        report(counts);
        Ok(())
    }
}
