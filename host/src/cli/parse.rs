//! Numbers on the command line.

/// Parses a finite number.
pub fn number(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|value| value.is_finite())
        .ok_or_else(|| "not a number".into())
}

/// Parses a time: seconds, or a date as in tables.
pub fn time(text: &str) -> Result<f64, String> {
    let date = || crate::tables::seconds_of(text);
    let why = "not a number of seconds, and no date such as 2026-01-31T12:30:05.25";
    number(text).ok().or_else(date).ok_or_else(|| why.into())
}

/// Parses a number greater than zero.
pub fn positive(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value > 0.0 {
        Ok(value)
    } else {
        Err("must be greater than 0".into())
    }
}
