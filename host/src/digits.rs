//! Numbers as text: significant digits, and as many decimals as an uncertainty needs. Device time
//! in seconds.

use ridgetone_proto::telemetry::Event;

/// Microseconds in seconds.
pub fn seconds(t_us: u64) -> f64 {
    t_us as f64 / 1e6
}

/// Device time of an event, seconds: of its end if it lasts. A greeting and a reply have none.
pub fn time_s(event: &Event) -> Option<f64> {
    event.t_us().map(seconds)
}

/// A number with `digits` significant digits, plain between 1e-4 and 1e7.
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

/// Decimals at which an uncertainty has a digit other than 0, at least `least`.
pub fn decimals(sigma: f64, least: usize) -> usize {
    // Half a unit of the last decimal is rounded up; single precision has at most nine decimals.
    if sigma > 0.0 {
        (-(2.0 * sigma).log10()).ceil().clamp(least as f64, 9.0) as usize
    } else {
        least
    }
}

/// `value +- sigma`, both with the same number of [`decimals`], at least `least`.
pub fn plus_minus(value: f64, sigma: f64, least: usize) -> String {
    let places = decimals(sigma, least);
    format!("{value:.places$} +- {sigma:.places$}")
}

/// A value and its uncertainty, the uncertainty with two significant digits.
pub fn uncertain(value: f64, sigma: f64) -> String {
    let (value, sigma) = two_digits(value, sigma);
    format!("{value} \u{b1} {sigma}")
}

/// A value and its uncertainty with as many decimals as the uncertainty needs for two significant
/// digits.
pub fn two_digits(value: f64, sigma: f64) -> (String, String) {
    // The exponent after rounding: 0.0996 is 0.10.
    let power: i32 = format!("{sigma:.1e}")
        .split_once('e')
        .and_then(|(_, power)| power.parse().ok())
        .unwrap_or(0);
    if sigma > 0.0 && sigma.is_finite() {
        let decimals = (1 - power).max(0) as usize;
        (format!("{value:.decimals$}"), format!("{sigma:.decimals$}"))
    } else {
        (value.to_string(), sigma.to_string())
    }
}

/// A value and its uncertainty with the same number of [`decimals`], at least four.
pub fn with_sigma(value: f64, sigma: f64) -> (String, String) {
    let decimals = decimals(sigma, 4);
    (format!("{value:.decimals$}"), format!("{sigma:.decimals$}"))
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
            (1.0, 0.0, "1 \u{b1} 0"),
        ] {
            assert_eq!(uncertain(value, sigma), expected);
        }
    }

    #[test]
    fn an_uncertainty_is_never_shown_as_0() {
        let shown = |value, sigma| with_sigma(value, sigma);
        assert_eq!(shown(8.33342, 0.00023), ("8.3334".into(), "0.0002".into()));
        assert_eq!(shown(3.60002, 6e-5), ("3.6000".into(), "0.0001".into()));
        assert_eq!(
            shown(4.1666667, 2.6e-6),
            ("4.166667".into(), "0.000003".into())
        );
        assert_eq!(
            shown(4.1666667, 1e-6),
            ("4.166667".into(), "0.000001".into())
        );
        assert_eq!(shown(31.25, 12.0), ("31.2500".into(), "12.0000".into()));
        assert_eq!(
            (shown(1.0, 0.0).1, shown(1.0, f64::NAN).1),
            ("0.0000".into(), "NaN".into())
        );
    }

    #[test]
    fn significant_digits() {
        assert_eq!(significant(0.250_123_44, 4), "0.2501");
        assert_eq!(significant(-12_345.678, 3), "-12346");
        assert_eq!(significant(1.234e-7, 3), "1.23e-7");
        assert_eq!(significant(0.0, 3), "0");
    }
}
