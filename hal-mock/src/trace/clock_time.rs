//! Dates and times of day as text.

use jiff::Timestamp;
use jiff::civil::{Date, DateTime};
use jiff::tz::Offset;

/// Seconds of a day.
pub const DAY_S: f64 = 86_400.0;

/// What a text says of a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClockTime {
    /// Seconds since 1970: with an offset from UTC, or `Z`.
    Absolute(f64),
    /// Seconds since 1970 by a local clock, which may jump by an hour.
    Local(f64),
    /// Seconds since midnight.
    OfDay(f64),
}

impl ClockTime {
    /// Reads `2026-01-31T12:30:05.25+01:00`, `31.01.2026 12:30:05,25`, `1/31/2026 0:30:05 PM` and
    /// the like; a time of day, too.
    pub fn parse(text: &str) -> Option<Self> {
        // Most cells of a table are no time: that should cost little.
        if !text.contains(':') {
            return None;
        }
        if let Ok(stamp) = text.parse::<Timestamp>() {
            return Some(Self::Absolute(seconds(stamp)));
        }
        let text = text.replace(',', ".");
        let (date, time) = match text.split_once(['T', ' ']) {
            Some((date, time)) if !date.contains(':') => (Some(date), time.trim()),
            _ => (None, text.as_str()),
        };
        let of_day_s = time_of_day_s(time)?;
        let Some(date) = date else {
            return Some(Self::OfDay(of_day_s));
        };
        let midnight = Offset::UTC.to_timestamp(DateTime::from_parts(
            day(date)?,
            jiff::civil::Time::midnight(),
        ));
        Some(Self::Local(seconds(midnight.ok()?) + of_day_s))
    }

    /// Seconds, from whatever it counts.
    pub fn seconds(self) -> f64 {
        match self {
            Self::Absolute(s) | Self::Local(s) | Self::OfDay(s) => s,
        }
    }
}

fn seconds(stamp: Timestamp) -> f64 {
    stamp.as_second() as f64 + f64::from(stamp.subsec_nanosecond()) * 1e-9
}

/// `12:30:05.25`, `12:30:05:250`, `12:30`, `0:30:05 PM`.
fn time_of_day_s(text: &str) -> Option<f64> {
    let lower = text.to_ascii_lowercase();
    let (time, later_s) = match (lower.strip_suffix("am"), lower.strip_suffix("pm")) {
        (Some(time), _) => (time, 0.0),
        (_, Some(time)) => (time, 0.5 * DAY_S),
        _ => (lower.as_str(), 0.0),
    };
    let has_half = time.len() < lower.len();
    let mut parts = time.trim().split(':').map(|part| {
        let is_number = part.starts_with(|c: char| c.is_ascii_digit());
        part.parse::<f64>().ok().filter(|_| is_number)
    });
    let (hours, minutes) = (parts.next()??, parts.next()??);
    let seconds = parts.next().unwrap_or(Some(0.0))?;
    let milliseconds = parts.next().unwrap_or(Some(0.0))?;
    let hours = if has_half { hours % 12.0 } else { hours };
    let is_time = hours < 25.0 && minutes < 60.0 && seconds < 61.0 && parts.next().is_none();
    is_time.then_some(3600.0 * hours + 60.0 * minutes + seconds + 1e-3 * milliseconds + later_s)
}

/// The day of a date: year first, or last; then the month is first after slashes, unless it cannot
/// be one.
fn day(text: &str) -> Option<Date> {
    let parts: Vec<i16> = text
        .split(['-', '/', '.'])
        .map(|part| part.parse().ok())
        .collect::<Option<_>>()?;
    let [first, second, third] = parts[..] else {
        return None;
    };
    let (year, month, day) = if first > 31 {
        (first, second, third)
    } else if text.contains('/') && first <= 12 {
        (third, first, second)
    } else {
        (third, second, first)
    };
    Date::new(year, month.try_into().ok()?, day.try_into().ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_seconds_since_1970() {
        // `date -u -d 2026-01-31T12:30:05.25 +%s.%N`
        let noon = 1_769_862_605.25;
        for (text, expected) in [
            ("2026-01-31T12:30:05.25Z", ClockTime::Absolute(noon)),
            ("2026-01-31T13:30:05.25+01:00", ClockTime::Absolute(noon)),
            ("2026-01-31 12:30:05.25", ClockTime::Local(noon)),
            ("31.01.2026 12:30:05,25", ClockTime::Local(noon)),
            ("1/31/2026 12:30:05.25 PM", ClockTime::Local(noon)),
            ("2000-02-29 00:00:00", ClockTime::Local(951_782_400.0)),
            ("00:01:01.5", ClockTime::OfDay(61.5)),
            ("00:01:01:500", ClockTime::OfDay(61.5)),
        ] {
            assert_eq!(ClockTime::parse(text), Some(expected), "{text}");
        }
        for text in ["yesterday", "a:b", "2026-13-01 00:00:00", "1.5", "12:75:00"] {
            assert_eq!(ClockTime::parse(text), None, "{text}");
        }
    }
}
