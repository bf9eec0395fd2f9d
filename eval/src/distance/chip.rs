//! What a frame of a display costs on the emulated Cortex-M4F.

use crate::bench::emulated::{Jobs, next};
use crate::moving_bump::{FLOATS, matching, step};
use crate::page::{Table, grouped};
use crate::workload::Job;
use anyhow::{Context, Result, ensure};
use ridgetone_host::output;
use std::path::Path;

/// Most instructions of a frame.
const BAR: u32 = 200_000;

/// Sides of the displays.
const SIDES: [u8; 4] = [4, 6, 8, 10];

/// Frames of each: the bump has gone from one side to the other.
const FRAMES: u32 = 80;

/// Runs the image, checks that it has this PC's forces to the last bit, and prints the costs. Fails if a frame costs too much.
pub fn run(elf: &Path) -> Result<()> {
    let mut jobs = Jobs::default();
    SIDES.iter().for_each(|side| jobs.add(Job::Pins { side: *side, frames: FRAMES }, [(); 0]));
    let mut measured = jobs.run(elf)?.into_iter();
    let mut table = Table::new(1, "pins|frames|instructions, mean|instructions, worst|multiplications, worst");
    let mut most = 0;
    for side in SIDES {
        let mut memory = vec![0.0; FLOATS];
        let mut display = matching(&mut memory, side.into())?;
        let (mut sum, mut worst, mut worst_adds) = (0u64, 0, 0);
        for frame in 0..FRAMES {
            let (instructions, multiply_adds, bits) = next!(measured, Pins { instructions, multiply_adds, bits });
            let here = step(&mut display, frame).context("no optimum")?;
            ensure!(here == (multiply_adds, bits), "{side} x {side} pins, frame {frame}: the chip has other forces");
            (sum, worst, worst_adds) = (sum + u64::from(instructions), worst.max(instructions), worst_adds.max(multiply_adds));
        }
        table.row(&[
            format!("{side} x {side}"),
            FRAMES.to_string(),
            grouped(sum / u64::from(FRAMES)),
            grouped(worst.into()),
            grouped(worst_adds.into()),
        ]);
        most = most.max(worst);
    }
    ensure!(measured.next().is_none(), "the benchmark gave more results than jobs");
    output::line(&table.end())?;
    ensure!(most <= BAR, "a frame takes {most} instructions: at most {BAR} are allowed");
    Ok(())
}
