//! The tables of `docs/results/faults.json`.

use super::campaign::Campaign;
use super::row::{Delays, Place, Row};
use crate::page::{self, Figures, None as Nothing, Requirement, Table, Tables, fixed};
use serde_json::Value;

/// Replaces those tables in `figures` that this campaign produces: `faults`, `emulated` and
/// `numbers` for the default scan, or the table of another scan plan.
pub fn with_campaign(
    mut figures: Figures<Nothing>,
    plan: Option<&str>,
    campaign: &Campaign,
) -> Figures<Nothing> {
    let tables = &mut figures.tables;
    if let Some(plan) = plan {
        tables.insert(plan.to_owned(), table(campaign, |_| true));
    } else {
        tables.insert(
            "faults".into(),
            table(campaign, |place| place != Place::Emulator),
        );
        tables.insert(
            "emulated".into(),
            table(campaign, |place| place == Place::Emulator),
        );
        tables.insert("numbers".into(), numbers(campaign));
    }
    figures.tables = with_requirements(figures.tables);
    figures
}

/// Columns whose sum over all faults must be zero, each with the column and value that exempt a
/// row.
const ZEROS: [(&str, Option<(&str, &str)>); 6] = [
    ("wrong but good", None),
    ("wrong with faults", None),
    ("lost silently", None),
    (
        "reported as lost beyond",
        Some(("loss is known", "at most")),
    ),
    ("altered", Some(("may be altered", "yes"))),
    ("false alarms", None),
];

pub fn with_requirements(mut tables: Tables) -> Tables {
    let sums = |column: &str, unless: Option<(&str, &str)>| {
        let of_table = |table: &Table| {
            let find = |name: &str| table.columns.iter().position(|own| own == name);
            let is_exempt = |row: &Vec<Value>| {
                unless.is_some_and(|(name, word)| find(name).is_some_and(|at| row[at] == word))
            };
            let rows = table.rows.iter().filter(|row| !is_exempt(row));
            rows.filter_map(|row| row[find(column)?].as_u64())
                .sum::<u64>()
        };
        let tables = tables
            .iter()
            .filter(|(name, _)| !["numbers", "bars"].contains(&name.as_str()));
        tables.map(|(_, table)| of_table(table)).sum::<u64>()
    };
    let requirements = ZEROS.map(|(column, unless)| {
        let what = format!("{column}, with every scan plan and on the emulated chip");
        Requirement::at_most(&what, 0, sums(column, unless))
    });
    tables.insert("bars".into(), page::requirements(&requirements));
    tables
}

/// Returns the numbers of injections and touches, and of damaged telemetry frames if they were
/// counted.
fn numbers(campaign: &Campaign) -> Table {
    let of_touches = campaign.rows.iter().filter(|row| row.runs > 0);
    let injected: usize = of_touches.clone().map(|row| row.injected).sum();
    let runs: usize = of_touches.map(|row| row.runs).sum();
    let errors = campaign.bit_errors;
    let mut table = Table::new("what|number");
    let mut row = |what: &str, number: Value| table.row([what.into(), number]);
    row("injections in touches", injected.into());
    row("touches", runs.into());
    row("first seed", campaign.seed.into());
    row(
        "damaged frames of telemetry",
        errors.map(|errors| errors.sent).into(),
    );
    row(
        "of these with the right checksum by chance",
        errors.map(|errors| errors.checksum_passed).into(),
    );
    row(
        "of these the empty message",
        errors.map(|errors| errors.empty).into(),
    );
    table
}

/// Returns the table with a row for each fault in the places that `is_shown` accepts.
pub fn table(campaign: &Campaign, is_shown: impl Fn(Place) -> bool) -> Table {
    let mut table = Table::new(
        "fault|on|injected|reported|unseen|reported after, median, ms|longest, ms|\
         recovered|after, median, ms|longest, ms|good|good with faults|doubtful|wrong but good|\
         wrong with faults|off by less than 0.5 %|lost silently|loss is known|reported as lost beyond|altered|\
         may be altered|false alarms",
    );
    campaign
        .rows
        .iter()
        .filter(|row| is_shown(row.place))
        .for_each(|row| table.row(cells(row)));
    table
}

fn cells(row: &Row) -> Vec<Value> {
    let counts = &row.counts;
    let mut cells = vec![
        row.fault.clone().into(),
        row.place.title().into(),
        row.injected.into(),
    ];
    let [reported, recovered] = [&row.detected, &row.recovered].map(delays);
    let [count, median, longest] = reported;
    cells.extend([count, row.unseen.into(), median, longest]);
    cells.extend(recovered);
    cells.extend([
        counts.good.into(),
        counts.good_with_faults.into(),
        counts.doubtful.into(),
        counts.wrong.into(),
        counts.wrong_with_faults.into(),
        counts.off.into(),
        counts.silent.into(),
        if row.loss_is_known { "yes" } else { "at most" }.into(),
        counts.excess.into(),
        // Empty for the image, because it is unknown which of two reads the image took.
        if row.place == Place::Emulator {
            Value::Null
        } else {
            counts.altered.into()
        },
        if row.may_alter() { "yes" } else { "no" }.into(),
        counts.false_alarms.into(),
    ]);
    cells
}

/// Returns the count, and the median and maximum delay in milliseconds.
fn delays(delays: &Option<Delays>) -> [Value; 3] {
    let Some(Delays {
        count,
        median_s,
        longest_s,
    }) = *delays
    else {
        return [Value::Null, Value::Null, Value::Null];
    };
    let ms = |seconds: f64| fixed((count > 0).then_some(1e3 * seconds), 1);
    [count.into(), ms(median_s), ms(longest_s)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_has_a_row_of_all_columns() {
        let mut campaign =
            Campaign::on_pc(1, 1, None, ridgetone_proto::plan::Plan::PAPER).expect("a campaign");
        campaign.on_lines(1).expect("rows");
        let figures = with_campaign(Figures::default(), None, &campaign);
        let faults = &figures.tables["faults"];
        assert_eq!(faults.rows.len(), campaign.rows.len());
        assert!(
            faults
                .rows
                .iter()
                .all(|row| row.len() == faults.columns.len())
        );
        let hand = with_campaign(figures.clone(), Some("hand"), &campaign);
        assert_eq!(hand.tables["hand"], *faults);
        assert_eq!(hand.tables["numbers"], figures.tables["numbers"]);
    }
}
