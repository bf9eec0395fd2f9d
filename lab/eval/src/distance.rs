//! Touch at a distance: a paper's numbers beside ours, for docs/results/distance.md.
//!
//! Okamoto et al., "Transmission of Tactile Roughness through Master-slave Systems"; and Moy et
//! al., "Human Psychophysics for Teletaction System Design" (the author's text has the tables, the
//! captions and the prose; its curves are lost).

pub mod bars;
pub mod experiment;
pub mod gratings;
pub mod layers;
pub mod matching;
pub mod tables;

use crate::page::{self, Figures};
use anyhow::Result;
use ridgetone_host::output::whole_text;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Takes a few seconds. What is drawn is the same in every run.

Examples:
  cargo xtask distance
  cargo xtask distance --write")]
pub struct DistanceArgs {
    /// Write distance.json and its picture into a folder, and fill in distance.md there.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/results")]
    write: Option<PathBuf>,
}

pub fn run(args: &DistanceArgs) -> Result<()> {
    let tables = tables::tables()?;
    let Some(folder) = &args.write else {
        return page::print(&tables);
    };
    page::write(
        folder,
        "distance",
        &Figures {
            tables,
            detail: page::None {},
        },
    )?;
    whole_text(&folder.join("distance.svg"), &tables::picture())
}
