//! The cost of what a finger feels, by scan plan.

use super::emulated::{Jobs, next};
use crate::feel_load::{bits, feels, fill};
use crate::workload::{Job, Measured};
use anyhow::{Context, Result, ensure};
use ridgetone_finger::Ring;
use ridgetone_proto::plan::{Converters, Plan};
use ridgetone_tone::Fitter;
use serde::{Deserialize, Serialize};

/// The cost of an event `feel` in one plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    pub plan: String,
    pub channels: usize,
    /// Its window, seconds.
    pub window_s: f64,
    pub instructions: u32,
    pub stack_bytes: u32,
}

pub fn write(jobs: &mut Jobs) {
    let plans = Plan::usual(Converters::ADS1258).count();
    (0..plans).for_each(|number| jobs.add(Job::Feel { plan: number as u8 }, [(); 0]));
}

pub fn read(measured: &mut dyn Iterator<Item = Measured>) -> Result<Vec<Cell>> {
    let mut cells = Vec::new();
    let (mut ring, mut fitter) = (Box::new(Ring::new()), Box::new(Fitter::new()));
    for (number, (name, plan)) in (0..).zip(Plan::usual(Converters::ADS1258)) {
        let (instructions, stack_bytes, on_chip) = next!(
            measured,
            Feel {
                instructions,
                stack_bytes,
                bits
            }
        );
        fill(&mut ring, number).context("a plan")?;
        let found = feels(&ring, number, fitter.scratch())
            .with_context(|| format!("{name}: nothing is felt"))?;
        ensure!(
            on_chip == bits(&found),
            "{name}: the chip feels something else than this PC"
        );
        let window_s = f64::from(found.window_s);
        cells.push(Cell {
            plan: name.into(),
            channels: plan.channels(),
            window_s,
            instructions,
            stack_bytes,
        });
    }
    Ok(cells)
}
