//! Options on how to read a table.

use super::parse::positive;
use crate::tables::{TableForm, TimeColumn};
use clap::Args;

/// Error if these options are used without a file.
pub const OF_A_FILE: &str =
    "--rate, --time-column and --flatten say how to read a table: name its file";

#[derive(Args, Clone, Debug, PartialEq)]
pub struct TableOptions {
    /// Rows per second of a table, whatever the stamps say [default: from the stamps].
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub rate: Option<f64>,
    /// Time column of a table, with its unit (s, ms, us, ns, min, h, d) unless its name states the
    /// unit; `none` for no time column [default: time_s, or a column whose name says that it is the
    /// time].
    #[arg(long, value_name = "NAME[:UNIT]", value_parser = TimeColumn::parse)]
    pub time_column: Option<TimeColumn>,
    /// Rows of a table hold consecutive samples of one series: read them one after the other.
    #[arg(long)]
    pub flatten: bool,
}

impl TableOptions {
    /// True if one of these options was supplied.
    pub fn is_given(&self) -> bool {
        self.rate.is_some() || self.time_column.is_some() || self.flatten
    }

    pub fn form(&self) -> TableForm {
        TableForm {
            is_flat: self.flatten,
            ..TableForm::timed(self.time_column.clone())
        }
    }
}
