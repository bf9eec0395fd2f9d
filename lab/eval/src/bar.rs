//! A limit and what was measured.

use crate::page::{Table, grouped};
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bar {
    pub bar: String,
    pub limit: String,
    pub measured: String,
    pub met: bool,
}

impl Bar {
    /// A number that must not be greater than `limit`.
    pub fn at_most(bar: &str, limit: u64, measured: u64) -> Self {
        let met = measured <= limit;
        Self {
            bar: bar.into(),
            limit: format!("at most {}", grouped(limit)),
            measured: grouped(measured),
            met,
        }
    }
}

pub fn table<'a>(bars: impl IntoIterator<Item = &'a Bar>) -> String {
    let mut table = Table::new(4, "bar|limit|measured|");
    for Bar {
        bar,
        limit,
        measured,
        met,
    } in bars
    {
        let met = if *met { "met" } else { "**NOT MET**" };
        table.row(&[bar.clone(), limit.clone(), measured.clone(), met.into()]);
    }
    table.end()
}
