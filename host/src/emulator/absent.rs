//! Where there are no named pipes, through which the emulated board has its files, there is no
//! emulated board.

use super::options::Options;
use super::outcome::{Exchange, Outcome};
use crate::input::Opened;
use anyhow::{Result, bail};

pub fn run_bytes(
    _: Opened,
    _: Options<'_>,
    _: &mut Exchange<'_>,
    _: &mut dyn FnMut(f64, f64),
) -> Result<Outcome> {
    bail!(
        "the emulated board needs Linux or macOS; on Windows use WSL, or `ridgetone replay`, which runs the same library"
    )
}
