//! So many runs of each family, on this PC and on the emulated chip.

use super::family::Family;
use super::judge::{Judgement, judge};
use super::plan::{Plan, SETTINGS};
use super::row::{Place, Row};
use super::{document, emulated, lines, task_sim};
use crate::bit_errors::BitErrors;
use crate::parallel;
use anyhow::{Context, Result, ensure};
use hal_mock::Truth;
use ridgetone_host::cli::FirmwareOptions;
use ridgetone_host::emulator;
use ridgetone_host::input::{Input, Opened, Source};
use ridgetone_host::output;
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Slide of a run on the PC, seconds.
const SLIDE_S: f64 = 1.5;
/// The same on the emulated chip, whose windows are of a second.
const EMULATED_SLIDE_S: f64 = 2.5;

/// `faults`
#[derive(Debug, clap::Args)]
pub struct FaultsArgs {
    /// Injections on this PC, at least.
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(1..))]
    pub injections: u64,
    /// Runs of each family on the emulated chip.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub emulated: u64,
    /// Which firmware.
    #[command(flatten)]
    pub firmware: FirmwareOptions,
    /// Seed of the first run; every run has one of its own.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Only this family.
    #[arg(long, value_enum, value_name = "NAME")]
    pub only: Option<Family>,
    /// Write faults.md to this folder: of all families, hence not with --only.
    #[arg(long, value_name = "FOLDER", conflicts_with = "only")]
    pub write: Option<PathBuf>,
    /// One JSON object instead of the table.
    #[arg(long)]
    pub json: bool,
}

/// All rows, and how they were made.
#[derive(Clone, Debug, Serialize)]
pub struct Campaign {
    /// Seed of the first run of each family.
    pub seed: u64,
    /// Rows, in the order of the table.
    pub rows: Vec<Row>,
    /// What became of frames of telemetry with flipped bits, if they were counted.
    pub bit_errors: Option<BitErrors>,
}

impl Campaign {
    /// Runs at least so many injections on this PC, as many of each family; only of one family if it is named. Those count
    /// that acted.
    ///
    /// # Errors
    /// A run that cannot be made; runs in which no injection acts.
    pub fn on_pc(injections: u64, seed: u64, only: Option<Family>) -> Result<Self> {
        let families: Vec<_> = families(only).collect();
        // Runs into which nothing is injected are besides.
        let injecting = families.iter().filter(|family| **family != Family::None).count().max(1);
        let share = (injections as usize).div_ceil(injecting);
        let mut rows = Vec::new();
        for family in families {
            let mut verdicts = Vec::new();
            let mut acted = 0;
            while acted < share {
                let plans = plans(family, seed + verdicts.len() as u64, share - acted);
                let more = parallel::map(family.title(), &plans, |plan| Ok((plan.seed, run(plan)?)))?;
                let more_acted =
                    more.iter().map(|(_, verdict)| standing_for(family, verdict.fates.len())).sum::<usize>();
                ensure!(more_acted > 0, "{}: in {} runs nothing acts", family.title(), plans.len());
                acted += more_acted;
                verdicts.extend(more);
            }
            rows.push(Row::of_family(family, Place::Pc, &verdicts));
        }
        Ok(Self { seed, rows, bit_errors: None })
    }

    /// Adds so many runs of each of these families on the emulated chip.
    ///
    /// # Errors
    /// Those of the emulator.
    pub fn on_emulator(&mut self, runs: u64, families: &[Family], options: emulator::Options<'_>) -> Result<()> {
        for family in families.iter().copied() {
            let seeds = self.seed..self.seed + runs;
            let plans: Vec<_> = seeds.map(|seed| Plan::new(family, seed, EMULATED_SLIDE_S)).collect();
            let made = |plan: &Plan| {
                let what = || format!("{}, seed {}", family.title(), plan.seed);
                Ok((plan.seed, emulated::run(plan, options).with_context(what)?))
            };
            let verdicts = parallel::map(family.title(), &plans, made)?;
            self.rows.push(Row::of_family(family, Place::Emulator, &verdicts));
        }
        Ok(())
    }

    /// Adds what comes of damage on the line and of lost power, as many as belong to so many injections into the chip.
    ///
    /// # Errors
    /// Those of [`lines::rows`].
    pub fn on_lines(&mut self, injections: u64) -> Result<()> {
        let (rows, bit_errors) = lines::rows(injections, self.seed)?;
        self.rows.extend(rows);
        self.bit_errors = Some(bit_errors);
        Ok(())
    }

    /// Whether all is zero that must be.
    pub fn is_clean(&self) -> bool {
        self.rows.iter().all(Row::is_clean)
    }
}

/// Runs of the seeds from this one on, with at least so many injections.
fn plans(family: Family, mut seed: u64, injections: usize) -> Vec<Plan> {
    let mut plans = Vec::new();
    let mut planned = 0;
    while planned < injections {
        let plan = Plan::new(family, seed, SLIDE_S);
        planned += standing_for(family, plan.injections.len());
        plans.push(plan);
        seed += 1;
    }
    plans
}

/// How many injections a run counts for: one without any stands for as many as a run with them has.
fn standing_for(family: Family, injections: usize) -> usize {
    if family == Family::None { 2 } else { injections }
}

fn families(only: Option<Family>) -> impl Iterator<Item = Family> {
    Family::ALL.into_iter().filter(move |family| only.is_none_or(|only| only == *family))
}

/// The input of a run, and its truth.
///
/// # Errors
/// A parameter of the scene out of its range: a mistake in the plan.
pub fn opened(plan: &Plan) -> Result<(Opened, Truth)> {
    let source = Source::Scene(plan.sliding.clone());
    let mut input = Input { source, seed: plan.seed, ..Input::default() }.open()?;
    input.options.injections = plan.injections.clone();
    let truth = input.truth.context("a scene without its truth")?;
    Ok((input, truth))
}

/// Makes one run on this PC.
///
/// # Errors
/// It cannot be made.
pub fn run(plan: &Plan) -> Result<Judgement> {
    let (input, truth) = opened(plan)?;
    let ran = task_sim::run(input, SETTINGS)?;
    Ok(judge(plan, &truth, &ran))
}

/// The command.
///
/// # Errors
/// Something is not zero that must be; those of the runs.
pub fn faults(args: &FaultsArgs) -> Result<()> {
    let began = Instant::now();
    let mut campaign = Campaign::on_pc(args.injections, args.seed, args.only)?;
    let injected: usize = campaign.rows.iter().map(|row| row.injected).sum();
    eprintln!("ridgetone: {injected} injections, {:.0} a second", injected as f64 / began.elapsed().as_secs_f64());
    if args.only.is_none() {
        campaign.on_lines(args.injections)?;
    }
    if args.emulated > 0 {
        let elf = args.firmware.image()?;
        let families: Vec<_> = families(args.only).collect();
        campaign.on_emulator(args.emulated, &families, args.firmware.options(&elf))?;
    }
    if let Some(folder) = &args.write {
        let document = document::document(&campaign)?;
        output::whole_file(&folder.join("faults.md"), |file| Ok(file.write_all(document.as_bytes())?))?;
    }
    output::line(&if args.json { serde_json::to_string(&campaign)? } else { document::table(&campaign) })?;
    for row in &campaign.rows {
        for complaint in &row.complaints {
            eprintln!("ridgetone: {}: {complaint}", row.fault);
        }
    }
    ensure!(campaign.is_clean(), "not everything is zero that must be: see the table");
    Ok(())
}
