//! `docs/faults.md`: the text of a template around the table of a campaign.

use super::campaign::Campaign;
use super::family::Family;
use super::row::{Delays, Place, Row};
use crate::bench::grouped;
use crate::bit_errors::BitErrors;
use crate::markdown::{Table, filled};
use anyhow::{Context, Result, bail};

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
            "control_off" => off_of(campaign, Family::None),
            "passed" => grouped(bit_errors(campaign)?.checksum_passed),
            "empty" => grouped(bit_errors(campaign)?.empty),
            "flipped" => grouped(bit_errors(campaign)?.sent),
            other => bail!("the template asks for {other}"),
        })
    })
}

/// Of the good estimates of a family's runs on the PC those that are off, as text.
fn off_of(campaign: &Campaign, family: Family) -> String {
    let row = campaign.rows.iter().find(|row| row.place == Place::Pc && row.name == family.name());
    row.map_or("-".into(), |row| format!("{} of {}", grouped(row.off), grouped(row.good + row.good_with_doubts)))
}

fn bit_errors(campaign: &Campaign) -> Result<&BitErrors> {
    campaign.bit_errors.as_ref().context("without the damaged frames the document is not whole")
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
            "estimates good / good with doubts / doubtful",
            "wrong but good",
            "with doubts",
            "off, less than 0.5 %",
            "lost silently",
            "told as lost beyond",
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
        format!("{} / {} / {}", grouped(row.good), grouped(row.good_with_doubts), grouped(row.doubtful)),
        grouped(row.wrong),
        grouped(row.wrong_with_doubts),
        grouped(row.off),
        grouped(row.silent),
        if row.loss_is_known { grouped(row.excess) } else { format!("({})", grouped(row.excess)) },
        // What the image believed of all that it read is not known.
        if row.place == Place::Pc { grouped(row.altered) } else { "-".into() },
        grouped(row.false_alarms),
    ]
}

fn seconds(seconds: f64) -> String {
    if seconds < 0.0995 { format!("{:.1} ms", 1e3 * seconds) } else { format!("{seconds:.2} s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_document_has_a_row_for_all_and_no_gap() {
        let mut campaign = Campaign::on_pc(1, 1, None).expect("a campaign");
        assert!(document(&campaign).is_err(), "without the lines it is not whole");
        campaign.on_lines(1).expect("rows");
        let document = document(&campaign).expect("a document");
        assert!(!document.contains("{{"), "{document}");
        let rows = document.lines().filter(|line| line.starts_with("| ")).count();
        assert_eq!(rows, 1 + campaign.rows.len());
        assert!(document.contains("Of 100 frames\n  0 had"), "{document}");
    }
}
