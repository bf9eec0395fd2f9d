//! The tables of `docs/results/faults.md`.

use super::campaign::Campaign;
use super::row::{Delays, Place, Row};
use crate::page::{Table, filled, grouped, table_of};
use anyhow::{Context, Result};

/// The page with its tables as they were filled in last.
const PAGE: &str = include_str!("../../../../docs/results/faults.md");

pub fn page(campaign: &Campaign) -> Result<String> {
    let numbers = numbers(campaign).context("without the damaged frames the page is not whole")?;
    filled(PAGE, |name| match name {
        "faults" => Some(table(campaign)),
        "numbers" => Some(numbers.clone()),
        // By runs of their own.
        plan => table_of(PAGE, plan).map(str::to_owned),
    })
}

/// A page with the table of runs with the scan plan of this name filled in, and nothing else.
pub fn with_plan(page: &str, plan: &str, campaign: &Campaign) -> Result<String> {
    let table = table(campaign);
    filled(page, |name| {
        if name == plan {
            Some(table.clone())
        } else {
            table_of(page, name).map(str::to_owned)
        }
    })
}

/// Numbers of injections and touches, and of damaged frames of telemetry; none if these were not
/// counted.
fn numbers(campaign: &Campaign) -> Option<String> {
    let errors = campaign.bit_errors?;
    let headings = "injections in touches|touches|first seed|damaged frames of telemetry|checksum right by chance|\
                    the empty message";
    let mut table = Table::new(0, headings);
    let of_touches = campaign.rows.iter().filter(|row| row.runs > 0);
    let injected: usize = of_touches.clone().map(|row| row.injected).sum();
    let runs: usize = of_touches.map(|row| row.runs).sum();
    let numbers = [
        injected as u64,
        runs as u64,
        campaign.seed,
        errors.sent,
        errors.checksum_passed,
        errors.empty,
    ];
    table.row(&numbers.map(grouped));
    Some(table.end())
}

pub fn table(campaign: &Campaign) -> String {
    let headings = "fault|on|injected|reported|after, median / longest|recovered|after, median / longest|\
                    estimates good / good with faults / doubtful|wrong but good|with faults|off, less than 0.5 %|\
                    lost silently|reported as lost beyond|altered|false alarms";
    let mut table = Table::new(2, headings);
    campaign.rows.iter().for_each(|row| table.row(&cells(row)));
    table.end()
}

fn cells(row: &Row) -> Vec<String> {
    let counts = &row.counts;
    let [mut detected, recovered] = [&row.detected, &row.recovered].map(delay_cells);
    if row.unseen > 0 {
        detected[0] += &format!(" ({})", grouped(row.unseen as u64));
    }
    let mut cells = vec![
        row.fault.clone(),
        row.place.title(),
        grouped(row.injected as u64),
    ];
    cells.extend(detected.into_iter().chain(recovered));
    let estimates = [counts.good, counts.good_with_faults, counts.doubtful].map(grouped);
    let excess = grouped(counts.excess);
    cells.extend([
        estimates.join(" / "),
        grouped(counts.wrong),
        grouped(counts.wrong_with_faults),
        grouped(counts.off),
        grouped(counts.silent),
        if row.loss_is_known {
            excess
        } else {
            format!("({excess})")
        },
        // Which reads the image took is not known.
        match row.place {
            Place::Emulator => "-".into(),
            _ if row.may_alter() => format!("({})", grouped(counts.altered)),
            _ => grouped(counts.altered),
        },
        grouped(counts.false_alarms),
    ]);
    cells
}

/// How many, and how soon.
fn delay_cells(delays: &Option<Delays>) -> [String; 2] {
    let Some(Delays {
        count,
        median_s,
        longest_s,
    }) = *delays
    else {
        return ["-".into(), "-".into()];
    };
    let times = if count == 0 || median_s.is_nan() {
        "-".into()
    } else {
        format!("{} / {}", seconds(median_s), seconds(longest_s))
    };
    [grouped(count as u64), times]
}

fn seconds(seconds: f64) -> String {
    if seconds < 0.0995 {
        format!("{:.1} ms", 1e3 * seconds)
    } else {
        format!("{seconds:.2} s")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_a_row_for_every_fault() {
        let mut campaign =
            Campaign::on_pc(1, 1, None, ridgetone_proto::plan::Plan::PAPER).expect("a campaign");
        assert!(
            page(&campaign).is_err(),
            "without the lines it is not whole"
        );
        campaign.on_lines(1).expect("rows");
        let page = page(&campaign).expect("a page");
        // Those of a scan plan are of a run of their own.
        let (own, _) = page.split_once("<!-- table: hand -->").expect("a table");
        let rows = own.lines().filter(|line| line.starts_with("| ")).count();
        // Two headings, and the row of numbers.
        assert_eq!(rows, 3 + campaign.rows.len());
        assert!(page.contains(" | 100 | 0 | "), "{page}");
    }
}
