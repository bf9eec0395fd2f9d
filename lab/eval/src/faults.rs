//! Injects thousands of faults into the chip, its bus and its lines, and counts their consequences.
//!
//! | what | where |
//! |---|---|
//! | a family of faults, and the reports that it must cause | [`family`] |
//! | one run: a touch and its injections | [`plan`] |
//! | the firmware's tasks, simulated on this PC | [`task_sim`] |
//! | the image on the emulated chip | [`emulated`] |
//! | the judgement of each fault of a run | [`judge`] |
//! | the line in both directions | [`bit_errors`], [`line_noise`], [`lines`] |
//! | power lost while settings are stored | [`power_cuts`] |
//! | many runs of each family | [`campaign`] |
//!
//! The judgement compares telemetry with the state of the simulated chip.

pub mod bit_errors;
pub mod campaign;
pub mod counts;
mod emulated;
pub mod family;
pub mod judge;
pub mod line_noise;
pub mod lines;
mod plan;
pub mod power_cuts;
pub mod row;
mod scan_order;
pub mod table;
mod task_sim;

use crate::page::{self, Tables};
use anyhow::{Context, Result, ensure};
use campaign::Campaign;
use family::Family;
use ridgetone_host::cli::firmware::FirmwareOptions;
use ridgetone_host::emulator::Options;
use ridgetone_host::output;
use ridgetone_proto::plan::Plan;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Debug, clap::Args)]
pub struct FaultsArgs {
    /// Minimum number of injections on this PC.
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(1..))]
    injections: u64,
    /// Runs of each family on the emulated chip.
    #[arg(long, value_name = "N", default_value_t = 0)]
    emulated: u64,
    #[command(flatten)]
    firmware: FirmwareOptions,
    /// Seed of the first run; each run has a different seed.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Run this family only.
    #[arg(long, value_enum, value_name = "NAME")]
    only: Option<Family>,
    /// Make runs on the PC only, with these scan plans: paper, hand, texture, vibration or single.
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        conflicts_with = "emulated"
    )]
    plan: Vec<String>,
    /// Write faults.json into a folder, and fill in faults.md there: needs all families, so not
    /// with --only. With --plan, write the tables of these plans only.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs/results", conflicts_with = "only")]
    write: Option<PathBuf>,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &FaultsArgs) -> Result<()> {
    let find =
        |name: &String| Plan::named(name).with_context(|| format!("no plan is called {name}"));
    let scans = args.plan.iter().map(find).collect::<Result<Vec<_>>>()?;
    let is_clean = if scans.is_empty() {
        let mut campaign = on_pc(args, Plan::PAPER)?;
        if args.only.is_none() {
            campaign.on_lines(args.injections)?;
        }
        if args.emulated > 0 {
            let firmware = args.firmware.image()?;
            campaign.on_emulator(args.emulated, args.only, Options::new(&firmware))?;
        }
        conclude(args, &campaign, None)?
    } else {
        let mut is_clean = true;
        for (name, scan) in args.plan.iter().zip(scans) {
            let campaign = on_pc(args, scan)?;
            is_clean &= conclude(args, &campaign, Some(name))?;
        }
        is_clean
    };
    ensure!(
        is_clean,
        "not everything is zero that must be: see the rows that failed"
    );
    Ok(())
}

fn on_pc(args: &FaultsArgs, scan: Plan) -> Result<Campaign> {
    let start = Instant::now();
    let campaign = Campaign::on_pc(args.injections, args.seed, args.only, scan)?;
    let injected: usize = campaign.rows.iter().map(|row| row.injected).sum();
    eprintln!(
        "ridgetone-eval: {injected} injections, {:.0} a second",
        injected as f64 / start.elapsed().as_secs_f64()
    );
    Ok(campaign)
}

/// Writes the figures and prints the table. Returns true if every count that must be zero is zero.
fn conclude(args: &FaultsArgs, campaign: &Campaign, plan: Option<&str>) -> Result<bool> {
    if let Some(folder) = &args.write {
        let before = page::load(folder, "faults")?;
        page::write(
            folder,
            "faults",
            &table::with_campaign(before, plan, campaign),
        )?;
    }
    if args.json {
        output::line(&serde_json::to_string(campaign)?)?;
    } else {
        page::print(&Tables::from([(
            "faults".into(),
            table::table(campaign, |_| true),
        )]))?;
    }
    for row in &campaign.rows {
        let failures = row.failures();
        if !failures.is_empty() {
            let (place, failures) = (row.place.title(), failures.join(", "));
            eprintln!(
                "ridgetone-eval: FAILED: {} ({place}): {failures}",
                row.fault
            );
        }
        for complaint in &row.complaints {
            eprintln!("ridgetone-eval: {}: {complaint}", row.fault);
        }
    }
    Ok(campaign.is_clean())
}
