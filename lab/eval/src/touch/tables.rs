//! The tables of `docs/results/touch.md`.

use super::Row;
use super::measure::Found;
use crate::page::{Table, figure};

const HEADINGS: &str = "|slide found, %|false slides, %|start, ms|end, ms|both near, %|both near what shows, %|\
                        contact found, %|false contacts, %|contact, ms|release found, %|release, ms|good at rest, %";

/// A table by its name: a group's.
pub fn table(rows: &[Row], name: &str) -> Option<String> {
    let mut table = Table::new(1, HEADINGS);
    let mut rows = rows.iter().filter(|row| row.group == name).peekable();
    rows.peek()?;
    rows.for_each(|row| table.row(&[vec![row.name.clone()], cells(&row.found)].concat()));
    Some(table.end())
}

fn cells(found: &Found) -> Vec<String> {
    let share = |count: u32, of: u32| {
        figure(
            (of > 0).then(|| 100.0 * f64::from(count) / f64::from(of)),
            1,
        )
    };
    let spread = |[low, median, high]: [f64; 3]| format!("{median:.0} ({low:.0}, {high:.0})");
    let errors = |ms: Option<[f64; 3]>| ms.map_or_else(|| "-".into(), spread);
    vec![
        share(found.slides_found, found.slides),
        share(found.slides_false, found.traces),
        errors(found.start_ms),
        errors(found.end_ms),
        share(found.near, found.slides),
        share(found.near_visible, found.slides),
        share(found.contacts_found, found.contacts),
        share(found.contacts_false, found.traces),
        errors(found.contact_ms),
        share(found.releases_found, found.traces),
        errors(found.release_ms),
        share(found.still_good, found.traces),
    ]
}
