//! `ports`: the serial ports of this computer.

use crate::note;
use crate::output;
use crate::port::{Listed, Ports, System, list_error};
use anyhow::Result;
use clap::Args;

#[derive(Debug, Args)]
#[command(after_help = "\
Example:
  ridgetone ports")]
pub struct PortsArgs {
    /// One JSON object per line instead of text.
    #[arg(long)]
    json: bool,
}

impl PortsArgs {
    pub(super) fn run(self) -> Result<()> {
        let found = System.list().map_err(list_error)?;
        if found.is_empty() {
            note!("there is no serial port");
        }
        for port in found.into_iter().map(Listed::from) {
            output::line(&if self.json {
                serde_json::to_string(&port)?
            } else {
                port.to_string()
            })?;
        }
        Ok(())
    }
}
