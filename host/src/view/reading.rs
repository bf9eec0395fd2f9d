//! How a table on the page is read where its file does not say it: its time, its rate, its unit.

use crate::input::REFERENCE_V;
use crate::samples::Samples;
use anyhow::{Result, anyhow};
use hal_mock::TimeColumn;
use std::path::Path;

/// The converter's own noise, volts (SBAS297G, at the scan's data rate).
const NOISE_V: f64 = 4.5e-6;

/// A table whose greatest value is less than this many times the converter's noise is scaled up.
const NOISES: f64 = 1000.0;

#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// The column that is the time; guessed if none.
    pub time_column: Option<TimeColumn>,
    /// Rows per second; those of the stamps if none.
    pub rate_hz: Option<f64>,
    /// Volts per unit; by the values if none.
    pub scale: Option<f64>,
}

impl Reading {
    /// Volts per unit of a table: as given, or the power of ten that brings its values into the
    /// converter's range. Values in it stay as they are.
    pub fn volts_per_unit(&self, samples: &Samples) -> Result<f64> {
        if let Some(scale) = self.scale {
            return Ok(scale);
        }
        let greatest = greatest(samples)?;
        let is_in_range = (NOISES * NOISE_V..=REFERENCE_V).contains(&greatest);
        Ok(if is_in_range || greatest == 0.0 {
            1.0
        } else {
            10f64.powf((REFERENCE_V / greatest).log10().floor())
        })
    }

    /// With another column as the time: its name, `NAME:UNIT` or `none`; guessed if it is empty.
    pub fn with_time(&self, columns: &[String], text: &str) -> Result<Self> {
        let time_column = if text.is_empty() {
            None
        } else if columns.iter().any(|name| name == text) {
            Some(TimeColumn::Named(text.to_owned(), None))
        } else {
            Some(TimeColumn::parse(text).map_err(|why| anyhow!(why))?)
        };
        Ok(Self {
            time_column,
            ..self.clone()
        })
    }

    /// The name of the column that was chosen.
    pub fn time_name(&self) -> Option<&str> {
        match self.time_column.as_ref()? {
            TimeColumn::Nothing => Some("none"),
            TimeColumn::Named(name, _) => Some(name),
        }
    }

    /// All columns of a table with numbers; none of a file that has no columns without a time.
    pub fn columns(path: &Path) -> Vec<String> {
        Samples::file_with(path, Some(TimeColumn::Nothing))
            .and_then(|samples| samples.open())
            .map_or_else(|_| Vec::new(), |rows| rows.names().to_vec())
    }
}

/// The greatest magnitude of a table's values.
fn greatest(samples: &Samples) -> Result<f64> {
    let (mut rows, mut values, mut greatest) = (samples.open()?, Vec::new(), 0f64);
    while rows.advance()? {
        rows.values(&mut values)?;
        let finite = values.iter().filter(|value| value.is_finite());
        greatest = finite.fold(greatest, |most, value| most.max(value.abs()));
    }
    Ok(greatest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn scale_of(greatest: f64) -> f64 {
        let value_at = Arc::new(move |row, _| if row == 3 { -greatest } else { 0.1 * greatest });
        let samples = Samples::array("an array", vec!["a".into()], 9, value_at, None);
        Reading::default().volts_per_unit(&samples).unwrap()
    }

    #[test]
    fn values_beyond_the_converters_range_are_scaled_by_a_power_of_ten() {
        for (greatest, scale) in [
            (0.0, 1.0),
            (0.02, 1.0),
            (4.0, 1.0),
            (9.81, 0.1),
            (65_535.0, 1e-5),
            (2e-6, 1e6),
        ] {
            let found = scale_of(greatest);
            assert!((found / scale - 1.0).abs() < 1e-12, "{greatest}: {found}");
        }
    }

    #[test]
    fn a_time_column_is_one_of_the_names_or_has_a_unit() {
        let columns = ["Latest: Time (s)".to_owned(), "t".to_owned()];
        let named = |text: &str| Reading::default().with_time(&columns, text);
        assert_eq!(
            named("Latest: Time (s)").unwrap().time_name(),
            Some("Latest: Time (s)")
        );
        let in_ms = TimeColumn::Named("t".into(), Some(1e3));
        assert_eq!(named("t:ms").unwrap().time_column, Some(in_ms));
        assert_eq!(named("").unwrap().time_column, None);
        assert!(named("t:furlong").is_err());
    }
}
