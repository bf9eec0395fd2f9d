//! Touch at a distance: a paper's numbers beside ours, for docs/results/touch-at-a-distance.md.
//!
//! Okamoto et al., "Transmission of Tactile Roughness through Master-slave Systems"; and Moy et
//! al., "Human Psychophysics for Teletaction System Design" (the author's text has the tables, the
//! captions and the prose; its curves are lost).

pub mod bars;
mod charts;
pub mod experiment;
pub mod gratings;
pub mod layers;
pub mod matching;
mod tables;

use crate::page::filled;
use anyhow::{Context, Result};
use ridgetone_host::output;
use std::fs;
use std::path::{Path, PathBuf};

const PAGE: &str = "touch-at-a-distance.md";
/// The folder of its pictures.
const PICTURES: &str = "touch-at-a-distance";

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Takes a few seconds. What is drawn is the same in every run.

Examples:
  cargo xtask distance
  cargo xtask distance --write docs/results")]
pub struct DistanceArgs {
    /// Folder with touch-at-a-distance.md to fill in; the pictures go into touch-at-a-distance/
    /// beside it.
    #[arg(long, value_name = "FOLDER")]
    write: Option<PathBuf>,
}

/// The page with its tables filled in.
pub fn page(text: &str) -> Result<String> {
    filled(text, |name| tables::table(name).ok().flatten())
}

/// The pictures by the names of their files.
pub fn pictures() -> Result<Vec<(&'static str, String)>> {
    Ok(vec![
        ("figure-8.svg", charts::matching(&matching::block()?)),
        ("figure-12.svg", charts::layers()),
        ("figure-16.svg", charts::sampling()),
        ("figure-17.svg", charts::grating()),
        ("figure-18-19.svg", charts::indices()),
        ("figure-22.svg", charts::errors()),
        ("table-6.svg", charts::skin()),
        ("figure-12-textures.svg", charts::experiment()?),
    ])
}

pub fn run(args: &DistanceArgs) -> Result<()> {
    let Some(folder) = &args.write else {
        for name in tables::NAMES {
            output::line(&format!(
                "{name}\n{}\n",
                tables::table(name)?.unwrap_or_default()
            ))?;
        }
        return Ok(());
    };
    write(folder)
}

fn write(folder: &Path) -> Result<()> {
    let of_pictures = folder.join(PICTURES);
    fs::create_dir_all(&of_pictures).with_context(|| of_pictures.display().to_string())?;
    for (name, svg) in pictures()? {
        output::whole_text(&of_pictures.join(name), &svg)?;
    }
    crate::page::render(folder, PAGE, page)
}
