//! Runs of each family, on this PC and on the emulated chip.

use super::bit_errors::BitErrors;
use super::family::Family;
use super::judge::{Judgement, judge};
use super::plan::Plan;
use super::row::{Place, Row};
use super::{emulated, lines, task_sim};
use crate::parallel;
use anyhow::{Context, Result, ensure};
use clap::ValueEnum;
use ridgetone_host::emulator;
use ridgetone_proto::plan::Plan as Scan;
use serde::Serialize;

/// Duration of the slide in a run on the PC, seconds.
const SLIDE_S: f64 = 1.5;
/// Duration of the slide in a run on the emulated chip, seconds: longer, because its windows last a
/// second.
const EMULATED_SLIDE_S: f64 = 2.5;

/// Rows of a campaign, and the seed that reproduces them.
#[derive(Clone, Debug, Serialize)]
pub struct Campaign {
    /// Seed of the first run of each family.
    pub seed: u64,
    pub rows: Vec<Row>,
    /// Counts of telemetry frames with bit errors, if measured.
    pub bit_errors: Option<BitErrors>,
}

impl Campaign {
    /// Runs on this PC until at least `injections` injections have taken effect, equally many in
    /// each family, or all in the family `only`.
    pub fn on_pc(injections: u64, seed: u64, only: Option<Family>, scan: Scan) -> Result<Self> {
        let place = match scan {
            Scan::PAPER => Place::Pc,
            _ => Place::Plan(scan.name().unwrap_or("of one's own")),
        };
        let families: Vec<_> = families(only).collect();
        // Runs without injections are additional.
        let injecting = families
            .iter()
            .filter(|family| **family != Family::None)
            .count()
            .max(1);
        let count = (injections as usize).div_ceil(injecting);
        let mut rows = Vec::new();
        for family in families {
            let mut judgements = Vec::new();
            let mut acted = 0;
            while acted < count {
                let plans = plans(family, seed + judgements.len() as u64, count - acted, scan);
                let more =
                    parallel::map(family.title(), &plans, |plan| Ok((plan.seed, run(plan)?)))?;
                let more_acted = more
                    .iter()
                    .map(|(_, judgement)| standing_for(family, judgement.fates.len()))
                    .sum::<usize>();
                ensure!(
                    more_acted > 0,
                    "{}: in {} runs nothing acts",
                    family.title(),
                    plans.len()
                );
                acted += more_acted;
                judgements.extend(more);
            }
            rows.push(Row::of_family(family, place, &judgements));
        }
        Ok(Self {
            seed,
            rows,
            bit_errors: None,
        })
    }

    /// Adds `runs` runs of each family, or only of the family `only`, on the emulated chip.
    pub fn on_emulator(
        &mut self,
        runs: u64,
        only: Option<Family>,
        options: emulator::Options<'_>,
    ) -> Result<()> {
        for family in families(only) {
            let seeds = self.seed..self.seed + runs;
            let plans: Vec<_> = seeds
                .map(|seed| Plan::new(family, seed, EMULATED_SLIDE_S, Scan::PAPER))
                .collect();
            let made = |plan: &Plan| {
                let what = || format!("{}, seed {}", family.title(), plan.seed);
                Ok((plan.seed, emulated::run(plan, options).with_context(what)?))
            };
            let judgements = parallel::map(family.title(), &plans, made)?;
            self.rows
                .push(Row::of_family(family, Place::Emulator, &judgements));
        }
        Ok(())
    }

    /// Adds the rows of line damage and power loss, in proportion to `injections` injections into
    /// the chip.
    pub fn on_lines(&mut self, injections: u64) -> Result<()> {
        let (rows, bit_errors) = lines::rows(injections, self.seed)?;
        self.rows.extend(rows);
        self.bit_errors = Some(bit_errors);
        Ok(())
    }

    /// True if every count that must be zero is zero.
    pub fn is_clean(&self) -> bool {
        self.rows.iter().all(Row::is_clean)
    }
}

/// Plans runs with consecutive seeds from `seed` until they have at least `injections` injections.
fn plans(family: Family, mut seed: u64, injections: usize, scan: Scan) -> Vec<Plan> {
    let mut plans = Vec::new();
    let mut planned = 0;
    while planned < injections {
        let plan = Plan::new(family, seed, SLIDE_S, scan);
        planned += standing_for(family, plan.injections.len());
        plans.push(plan);
        seed += 1;
    }
    plans
}

/// Number of injections that a run counts for. A control run counts for as many as a typical run.
fn standing_for(family: Family, injections: usize) -> usize {
    if family == Family::None {
        2
    } else {
        injections
    }
}

fn families(only: Option<Family>) -> impl Iterator<Item = Family> {
    Family::value_variants()
        .iter()
        .copied()
        .filter(move |family| only.is_none_or(|only| only == *family))
}

pub fn run(plan: &Plan) -> Result<Judgement> {
    let (input, truth) = plan.open()?;
    let ran = task_sim::run(input, plan.settings(), plan.boot())?;
    Ok(judge(plan, &truth, &ran))
}
