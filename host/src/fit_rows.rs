//! Fits of many files or windows: a row of a table, or a line of JSON, for each.

use crate::fit_report;
use crate::names::name;
use crate::table_fit::TableFit;
use crate::tone::{Domain, WithSigma};
use anyhow::Result;
use ridgetone_proto::telemetry::Status;
use serde_json::json;
use std::io::Write;

const COLUMNS: [&str; 14] = [
    "file",
    "from_s",
    "to_s",
    "rows",
    "rows_missing",
    "frequency_hz",
    "sigma_hz",
    "frequency_per_mm",
    "sigma_per_mm",
    "period_mm",
    "period_sigma_mm",
    "status",
    "harmonics",
    "why",
];

/// Writes the results of fits and counts them.
pub struct FitRows<'a> {
    form: Form<'a>,
    pub count: u64,
    /// Number of good fits written.
    pub good: u64,
}

enum Form<'a> {
    /// A table with a header.
    Csv(Box<csv::Writer<&'a mut dyn Write>>),
    /// One JSON object per line.
    Json(&'a mut dyn Write),
}

impl<'a> FitRows<'a> {
    /// Starts a table, or lines of JSON.
    pub fn new(out: &'a mut dyn Write, is_json: bool) -> Result<Self> {
        let form = if is_json {
            Form::Json(out)
        } else {
            let mut csv = Box::new(csv::Writer::from_writer(out));
            csv.write_record(COLUMNS)?;
            Form::Csv(csv)
        };
        let (count, good) = (0, 0);
        Ok(Self { form, count, good })
    }

    /// Writes the fit of a file or of a window in it.
    pub fn fit(&mut self, file: &str, fit: &TableFit) -> Result<()> {
        self.count += 1;
        self.good += u64::from(fit.status == Status::Good);
        let csv = match &mut self.form {
            Form::Json(out) => return Ok(writeln!(out, "{}", fit_report::json(file, fit)?)?),
            Form::Csv(csv) => csv,
        };
        let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let frequency = fit.tone.frequency();
        let in_time = frequency.filter(|_| fit.domain == Domain::Time);
        let by_position = frequency.filter(|_| fit.domain == Domain::Position);
        let period = by_position.map(WithSigma::inverse);
        Ok(csv.write_record([
            file.to_owned(),
            fit.from_s.to_string(),
            fit.to_s.to_string(),
            fit.rows.to_string(),
            fit.rows_missing.to_string(),
            number(in_time.map(|found| found.value)),
            number(in_time.map(|found| found.sigma)),
            number(by_position.map(|found| found.value)),
            number(by_position.map(|found| found.sigma)),
            number(period.map(|found| found.value)),
            number(period.map(|found| found.sigma)),
            name(fit.status).to_string(),
            fit.harmonics.to_string(),
            String::new(),
        ])?)
    }

    /// Writes the reason why a file, or its window from `from_s` on, has no fit.
    pub fn refused(&mut self, file: &str, from_s: Option<f64>, why: &str) -> Result<()> {
        self.count += 1;
        match &mut self.form {
            Form::Json(out) => {
                let line = json!({"type": "no_fit", "file": file, "from_s": from_s, "why": why});
                Ok(writeln!(out, "{line}")?)
            }
            Form::Csv(csv) => {
                let from_s = from_s.map_or(String::new(), |from_s| from_s.to_string());
                let mut record = vec![file.to_owned(), from_s];
                record.resize(COLUMNS.len() - 1, String::new());
                record.push(why.to_owned());
                Ok(csv.write_record(record)?)
            }
        }
    }

    pub fn finish(&mut self) -> Result<()> {
        match &mut self.form {
            Form::Csv(csv) => Ok(csv.flush()?),
            Form::Json(out) => Ok(out.flush()?),
        }
    }
}
