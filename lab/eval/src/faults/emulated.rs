//! Runs of the campaign with the firmware image on the emulated chip.

use super::family::Family;
use super::judge::{Judgement, judge};
use super::plan::Plan;
use super::scan_order::ScanOrder;
use super::task_sim::Ran;
use ads1258::Register;
use anyhow::Result;
use ridgetone_finger::converter::SCAN;
use ridgetone_host::emulator::{self, Options, Outcome};
use ridgetone_proto::telemetry::Packet;

/// Frequency error of a board's internal oscillator, ppm. The converter's clock then appears off by
/// about as much, within the 0.5 % that the rate check allows.
const INTERNAL_PPM: i32 = 4_000;

pub fn run(plan: &Plan, options: Options<'_>) -> Result<Judgement> {
    let (input, truth) = plan.open()?;
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet, _| {
        packets.push(packet.clone());
        Ok(())
    };
    let options = Options {
        keep_conversions: true,
        internal_ppm: (plan.family == Family::Oscillator).then_some(INTERNAL_PPM),
        ..options
    };
    let outcome = emulator::run(input, options, &mut sink, &mut |_, _| {})?;
    Ok(judge(plan, &truth, &ran(packets, &outcome)?))
}

/// Converts the results of an image run into the form of a PC run. The firmware reads twice and may
/// have taken either read, so a conversion counts as delivered if one read was right.
fn ran(packets: Vec<Packet>, outcome: &Outcome) -> Result<Ran> {
    let image = SCAN.registers()?;
    // The firmware's counter starts only after power-up.
    let first_us = outcome.conversions.first().map_or(0, |first| first.t_us);
    let since_ns = |t_us: u32| u64::from(t_us.wrapping_sub(first_us)) * 1000;
    let mut order = ScanOrder::new(&SCAN);
    let whole = outcome
        .conversions
        .iter()
        .filter(|timed| order.take(&timed.conversion()));
    // GPIOD reads back the pins' levels.
    let writable = Register::Gpiod as usize;
    Ok(Ran {
        packets,
        line: (outcome.counts.missing, outcome.counts.damaged),
        chip: outcome.chip,
        injected: outcome.injected.clone(),
        delivered: outcome.arrived,
        altered: 0,
        // The image's plan reads conversions twice, and takes the health readings in every scan.
        unseen_ns: Vec::new(),
        readings_ns: Vec::new(),
        // Runs are much shorter than the 71 minutes after which the counter wraps.
        whole_ns: whole
            .map(|timed| outcome.first_edge_us * 1000 + since_ns(timed.t_us))
            .collect(),
        zero_ns: outcome.first_edge_us * 1000,
        end_ns: outcome.end_us * 1000,
        registers_right: outcome.registers[..writable] == image[..writable],
    })
}
