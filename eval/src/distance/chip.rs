//! What a frame of a display costs on the emulated Cortex-M4F.

use crate::bench::emulated::{Jobs, next};
use crate::moving_bump::{FLOATS, matching, settings, step, update};
use crate::page::{Table, grouped};
use crate::workload::Job;
use anyhow::{Context, Result, ensure};
use ridgetone::pins::Driver;
use ridgetone_host::output;
use std::path::Path;

/// Most instructions of a frame.
const BAR: u32 = 200_000;

/// Sides of the displays.
const SIDES: [u8; 4] = [4, 6, 8, 10];

/// Largest display whose every update of the firmware is within the bar.
const UPDATE_SIDE_MOST: u8 = 6;

/// Frames of each: the bump has gone from one side to the other.
const FRAMES: u32 = 80;

/// Runs the image, checks that it has this PC's forces to the last bit, and prints the costs. Fails if a frame costs too much.
pub fn run(elf: &Path) -> Result<()> {
    let mut jobs = Jobs::default();
    SIDES.iter().for_each(|side| jobs.add(Job::Pins { side: *side, frames: FRAMES }, [(); 0]));
    SIDES.iter().for_each(|side| jobs.add(Job::Update { side: *side, frames: FRAMES }, [(); 0]));
    let mut measured = jobs.run(elf)?.into_iter();
    let columns = "pins|frames|instructions, mean|instructions, worst";
    let mut table = Table::new(1, &format!("{columns}|multiplications, worst"));
    let mut most = 0;
    for side in SIDES {
        let mut memory = vec![0.0; FLOATS];
        let mut display = matching(&mut memory, side.into())?;
        let (mut costs, mut worst_adds) = (Costs::default(), 0);
        for frame in 0..FRAMES {
            let (instructions, multiply_adds, bits) = next!(measured, Pins { instructions, multiply_adds, bits });
            let here = step(&mut display, frame).context("no optimum")?;
            ensure!(here == (multiply_adds, bits), "{side} x {side} pins, frame {frame}: the chip has other forces");
            costs.add(instructions);
            worst_adds = worst_adds.max(multiply_adds);
        }
        let [side, frames, mean, worst] = costs.row(side);
        table.row(&[side, frames, mean, worst, grouped(worst_adds.into())]);
        most = most.max(costs.worst);
    }
    // The firmware's, with all that an update takes: strains, response, forces, limits.
    let mut updates = Table::new(1, &columns.replace("frames", "updates of the firmware"));
    for side in SIDES {
        let (settings, mut driver, mut memory) = (settings(side), Driver::new(), vec![0.0; FLOATS]);
        let mut costs = Costs::default();
        for frame in 0..FRAMES {
            let (instructions, multiply_adds, bits) = next!(measured, Pins { instructions, multiply_adds, bits });
            let here = update(&mut driver, &mut memory, &settings, frame);
            ensure!(here == (multiply_adds, bits), "{side} x {side} pins, update {frame}: the chip has other levels");
            costs.add(instructions);
        }
        updates.row(&costs.row(side));
        // More pins take more in their worst update: docs/touch-at-a-distance.md reports that the bar is not met there.
        if side <= UPDATE_SIDE_MOST {
            most = most.max(costs.worst);
        }
    }
    ensure!(measured.next().is_none(), "the benchmark gave more results than jobs");
    output::line(&table.end())?;
    output::line(&updates.end())?;
    ensure!(most <= BAR, "a frame takes {most} instructions: at most {BAR} are allowed");
    Ok(())
}

/// Instructions of frames.
#[derive(Default)]
struct Costs {
    sum: u64,
    worst: u32,
}

impl Costs {
    fn add(&mut self, instructions: u32) {
        (self.sum, self.worst) = (self.sum + u64::from(instructions), self.worst.max(instructions));
    }

    fn row(&self, side: u8) -> [String; 4] {
        let mean = grouped(self.sum / u64::from(FRAMES));
        [format!("{side} x {side}"), FRAMES.to_string(), mean, grouped(self.worst.into())]
    }
}
