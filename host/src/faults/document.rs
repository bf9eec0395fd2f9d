//! `docs/faults.md`: the text of a template around the table of a campaign.

use super::campaign::Campaign;
use super::row::{Delays, Place, Row};
use crate::bench::grouped;
use crate::markdown::{Table, filled};
use anyhow::{Result, bail};

const TEMPLATE: &str = include_str!("template.md");

/// The document.
///
/// # Errors
/// The template asks for what there is not.
pub fn document(campaign: &Campaign) -> Result<String> {
    filled(TEMPLATE, |name| {
        Ok(match name {
            "table" => table(campaign),
            "seed" => campaign.seed.to_string(),
            "injected" => count(campaign.rows.iter().filter(|row| row.runs > 0).map(|row| row.injected).sum()),
            "runs" => count(campaign.rows.iter().map(|row| row.runs).sum()),
            other => bail!("the template asks for {other}"),
        })
    })
}

fn count(of: usize) -> String {
    grouped(of as u64)
}

/// The table.
pub fn table(campaign: &Campaign) -> String {
    let mut table = Table::new(
        2,
        &[
            "fault",
            "on",
            "injected",
            "told",
            "after, median / longest",
            "well again",
            "after, median / longest",
            "estimates good / in doubt",
            "wrong but good",
            "with doubts",
            "lost silently",
            "altered",
            "false alarms",
        ],
    );
    campaign.rows.iter().for_each(|row| table.row(&cells(row)));
    table.end()
}

fn cells(row: &Row) -> Vec<String> {
    let how_many = |delays: &Option<Delays>| delays.map_or("-".into(), |delays| count(delays.count));
    let how_soon = |delays: &Option<Delays>| {
        delays
            .filter(|delays| delays.count > 0 && !delays.median_s.is_nan())
            .map_or("-".into(), |delays| format!("{} / {}", seconds(delays.median_s), seconds(delays.longest_s)))
    };
    vec![
        row.fault.clone(),
        row.place.title().into(),
        count(row.injected),
        how_many(&row.detected),
        how_soon(&row.detected),
        how_many(&row.recovered),
        how_soon(&row.recovered),
        format!("{} / {}", grouped(row.good), grouped(row.doubtful)),
        grouped(row.wrong),
        grouped(row.wrong_with_doubts),
        grouped(row.silent),
        // What the image believed of all that it read is not known.
        if row.place == Place::Pc { grouped(row.altered) } else { "-".into() },
        grouped(row.false_alarms),
    ]
}

fn seconds(seconds: f64) -> String {
    if seconds < 0.0995 { format!("{:.1} ms", 1e3 * seconds) } else { format!("{seconds:.2} s") }
}
