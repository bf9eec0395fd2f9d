//! What a frame of a display costs on the emulated Cortex-M4F.

use crate::bench::emulated::{Jobs, next};
use crate::moving_bump::{FLOATS, Load, matching, settings, settings_in, step, summary};
use crate::page::{Table, grouped};
use crate::workload::Job;
use anyhow::{Context, Result, ensure};
use ridgetone::pins::{Driver, MULTIPLY_ADDS_MAX, PIVOTS_MAX};
use ridgetone_display::Square;
use ridgetone_host::output;
use std::path::Path;

/// Most instructions of a frame.
const BAR: u32 = 200_000;

/// Sides of the displays.
const SIDES: [u8; 4] = [4, 6, 8, 10];

/// Frames of each: the bump has gone from one side to the other.
const FRAMES: u32 = 80;

/// Runs the image, checks that it has this PC's forces to the last bit, and prints the costs. Fails
/// if a frame costs too much.
pub fn run(elf: &Path) -> Result<()> {
    let mut jobs = Jobs::default();
    SIDES.iter().for_each(|side| {
        jobs.add(
            Job::Pins {
                side: *side,
                frames: FRAMES,
            },
            [(); 0],
        )
    });
    for side in SIDES {
        Load::ALL.iter().for_each(|load| {
            jobs.add(
                Job::Update {
                    side,
                    load: *load,
                    frames: FRAMES,
                },
                [(); 0],
            )
        });
    }
    let mut measured = jobs.run(elf)?.into_iter();
    let columns = "pins|frames|instructions, mean|instructions, worst";
    let mut table = Table::new(1, &format!("{columns}|multiplications, worst"));
    let mut most = 0;
    for side in SIDES {
        let mut memory = vec![0.0; FLOATS];
        let mut display = matching(&mut memory, side.into())?;
        let (mut costs, mut worst_adds) = (Costs::default(), 0);
        for frame in 0..FRAMES {
            let (instructions, multiply_adds, bits) = next!(
                measured,
                Pins {
                    instructions,
                    multiply_adds,
                    bits
                }
            );
            let here = step(&mut display, frame).context("no optimum")?;
            ensure!(
                here == (multiply_adds, bits),
                "{side} x {side} pins, frame {frame}: the chip has other forces"
            );
            costs.add(instructions);
            worst_adds = worst_adds.max(multiply_adds);
        }
        let [side, frames, mean, worst] = costs.row(side);
        table.row(&[side, frames, mean, worst, grouped(worst_adds.into())]);
        most = most.max(costs.worst);
    }
    // The firmware's, with all that an update takes: strains, response, forces, limits.
    let mut updates = Table::new(
        2,
        &format!(
            "{}|optimal, %",
            columns.replace("frames", "load|updates of the firmware")
        ),
    );
    let mut bounds = Table::new(
        1,
        "pins|the greatest cost that an update's limits leave, instructions",
    );
    for side in SIDES {
        let mut works = Vec::new();
        for load in Load::ALL {
            let (settings, mut driver, mut memory) =
                (settings(side), Driver::new(), vec![0.0; FLOATS]);
            let (mut costs, mut optimal) = (Costs::default(), 0);
            for frame in 0..FRAMES {
                let (instructions, multiply_adds, bits) = next!(
                    measured,
                    Pins {
                        instructions,
                        multiply_adds,
                        bits
                    }
                );
                let (due, settings) = (load.due(frame), settings_in(&settings, load, frame));
                let solution = driver
                    .clone()
                    .solve(&due, &mut memory, &settings)
                    .map(|solution| Work {
                        pivots: solution.pivots.into(),
                        multiply_adds: solution.multiply_adds.into(),
                        instructions: instructions.into(),
                    });
                works.push(solution.context("no forces")?);
                let here = driver.update(&due, &mut memory, &settings);
                let is_same = summary(&here) == (multiply_adds, bits);
                ensure!(
                    is_same,
                    "{side} x {side} pins, {load:?}, update {frame}: the chip has other levels"
                );
                costs.add(instructions);
                optimal += u32::from(here.is_optimal);
            }
            let [side, frames, mean, worst] = costs.row(side);
            let optimal = format!("{:.0}", 100.0 * f64::from(optimal) / f64::from(FRAMES));
            updates.row(&[
                side,
                format!("{load:?}").to_lowercase(),
                frames,
                mean,
                worst,
                optimal,
            ]);
            most = most.max(costs.worst);
        }
        let bound = bound(side, &works).context("every update solves as many systems")?;
        bounds.row(&[format!("{side} x {side}"), grouped(bound.into())]);
        most = most.max(bound);
    }
    ensure!(
        measured.next().is_none(),
        "the benchmark gave more results than jobs"
    );
    output::line(&table.end())?;
    output::line(&updates.end())?;
    output::line(&bounds.end())?;
    ensure!(
        most <= BAR,
        "a frame takes {most} instructions: at most {BAR} are allowed"
    );
    Ok(())
}

/// What an update did.
#[derive(Clone, Copy, Debug)]
struct Work {
    pivots: f64,
    multiply_adds: f64,
    instructions: f64,
}

/// Instructions of an update that solves as many systems, with as many multiplications, as
/// [`Driver`] lets it; images may not bring it about. Loops are of fixed lengths, so that the cost
/// should be a constant, one for each system, and one for each multiplication. They are computed
/// from the updates that differ most. None if none differ.
fn bound(side: u8, works: &[Work]) -> Option<u32> {
    let between = |works: &[Work], of: fn(&Work) -> f64, cost: &dyn Fn(&Work) -> f64| {
        let least = works.iter().min_by(|a, b| of(a).total_cmp(&of(b)))?;
        let most = works.iter().max_by(|a, b| of(a).total_cmp(&of(b)))?;
        (of(most) > of(least)).then(|| (cost(most) - cost(least)) / (of(most) - of(least)))
    };
    // Of updates that solve as many systems: the most frequent number of them.
    let alike = |pivots: f64| {
        works
            .iter()
            .copied()
            .filter(move |work| work.pivots == pivots)
    };
    let frequent = works
        .iter()
        .map(|work| work.pivots)
        .max_by_key(|pivots| alike(*pivots).count())?;
    let alike: Vec<Work> = alike(frequent).collect();
    let a_multiplication = between(&alike, |work| work.multiply_adds, &|work| work.instructions)?;
    let rest = |work: &Work| work.instructions - a_multiplication * work.multiply_adds;
    let a_system = between(works, |work| work.pivots, &rest)?;
    let [_, greatest] = Square::multiply_adds(side.into());
    let multiply_adds = f64::from((MULTIPLY_ADDS_MAX + greatest).min(PIVOTS_MAX * greatest));
    let systems = f64::from(PIVOTS_MAX);
    let bound = |work: &Work| {
        rest(work) + a_system * (systems - work.pivots) + a_multiplication * multiply_adds
    };
    works
        .iter()
        .map(bound)
        .max_by(f64::total_cmp)
        .map(|bound| bound.ceil() as u32)
}

/// Instructions of frames.
#[derive(Default)]
struct Costs {
    sum: u64,
    worst: u32,
}

impl Costs {
    fn add(&mut self, instructions: u32) {
        (self.sum, self.worst) = (
            self.sum + u64::from(instructions),
            self.worst.max(instructions),
        );
    }

    fn row(&self, side: u8) -> [String; 4] {
        let mean = grouped(self.sum / u64::from(FRAMES));
        [
            format!("{side} x {side}"),
            FRAMES.to_string(),
            mean,
            grouped(self.worst.into()),
        ]
    }
}
