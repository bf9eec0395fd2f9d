//! Numbers as text: significant digits, or as many decimals as an uncertainty needs. Device time in
//! seconds.

use ridgetone_proto::telemetry::Event;

pub fn seconds(t_us: u64) -> f64 {
    t_us as f64 / 1e6
}

/// Returns an event's device time in seconds, or the time of its end if it lasts; `None` for a
/// greeting or a reply.
pub fn time_s(event: &Event) -> Option<f64> {
    event.t_us().map(seconds)
}

/// Formats bytes in hexadecimal: "0A 31".
pub fn hex(bytes: &[u8]) -> String {
    let digits: Vec<_> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    digits.join(" ")
}

/// Formats a number with `digits` significant digits, without exponent between 1e-4 and 1e7.
pub fn significant(value: f64, digits: usize) -> String {
    let power = value.abs().log10().floor();
    if value == 0.0 || !value.is_finite() {
        value.to_string()
    } else if (-4.0..7.0).contains(&power) {
        let decimals = (digits as f64 - 1.0 - power).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.decimals$e}", decimals = digits.saturating_sub(1))
    }
}

/// Returns the number of decimals needed to show an uncertainty with two significant digits; `None`
/// if `sigma` is not an uncertainty.
pub fn decimals(sigma: f64) -> Option<usize> {
    // Use the exponent after rounding, since 0.0996 becomes 0.10.
    let power: i32 = format!("{sigma:.1e}").split_once('e')?.1.parse().ok()?;
    (sigma > 0.0 && sigma.is_finite()).then(|| (1 - power).max(0) as usize)
}

/// Formats a value and its uncertainty with the number of decimals that shows two significant
/// digits of the uncertainty.
pub fn with_sigma(value: f64, sigma: f64) -> (String, String) {
    match decimals(sigma) {
        Some(decimals) => (format!("{value:.decimals$}"), format!("{sigma:.decimals$}")),
        None => (significant(value, 7), sigma.to_string()),
    }
}

/// Formats `value +- sigma`, the uncertainty with two significant digits.
pub fn plus_minus(value: f64, sigma: f64) -> String {
    let (value, sigma) = with_sigma(value, sigma);
    format!("{value} +- {sigma}")
}

/// Formats a value and its uncertainty for screens, the uncertainty with two significant digits.
pub fn uncertain(value: f64, sigma: f64) -> String {
    let (value, sigma) = with_sigma(value, sigma);
    format!("{value} \u{b1} {sigma}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_uncertainty_has_two_digits() {
        for (value, sigma, expected) in [
            (8.33342, 0.00023, "8.33342 \u{b1} 0.00023"),
            (8.33342, 0.0996, "8.33 \u{b1} 0.10"),
            (12.3, 4.56, "12.3 \u{b1} 4.6"),
            (1234.5, 67.8, "1234 \u{b1} 68"),
            (3.60002, 6e-5, "3.600020 \u{b1} 0.000060"),
            (4.166_666_7, 1e-6, "4.1666667 \u{b1} 0.0000010"),
            (1.0, 0.0, "1.000000 \u{b1} 0"),
            (1.0, f64::NAN, "1.000000 \u{b1} NaN"),
        ] {
            assert_eq!(uncertain(value, sigma), expected);
        }
    }

    #[test]
    fn significant_digits() {
        assert_eq!(significant(0.250_123_44, 4), "0.2501");
        assert_eq!(significant(-12_345.678, 3), "-12346");
        assert_eq!(significant(1.234e-7, 3), "1.23e-7");
        assert_eq!(significant(0.0, 3), "0");
    }
}
