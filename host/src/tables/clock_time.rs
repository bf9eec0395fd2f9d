//! Parses dates and times of day.

use jiff::Timestamp;
use jiff::civil::{Date, DateTime};
use jiff::tz::Offset;
use std::borrow::Cow;

/// Seconds per day.
pub const DAY_S: f64 = 86_400.0;

/// Maximum number of words of a date before its time of day, and after it, as in
/// `Sat Jan 31 12:30:05 UTC 2026`.
pub const WORDS_MAX: usize = 3;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClockTime {
    /// Seconds since 1970: with an offset from UTC, or `Z`.
    Absolute(f64),
    /// Seconds since 1970 by a local clock, which may jump by an hour.
    Local(f64),
    /// Seconds since midnight, or since a start.
    OfDay(f64),
}

impl ClockTime {
    /// Parses `2026-01-31T12:30:05.25+01:00`, `31.01.2026 12:30:05,25 UTC`, `1/31/2026 0:30:05 PM`,
    /// `31-Jan-2026 12:30:05`, `Sat Jan 31 12:30:05 2026` and similar dates, times of day, dates
    /// without a year such as `Jan 31 12:30:05`, and `0 days 00:00:05.25`.
    pub fn parse(text: &str) -> Option<Self> {
        // Most cells are not times: reject them quickly.
        if !text.contains(':') {
            return compact(text).map(Self::Local);
        }
        if let Ok(stamp) = text.parse::<Timestamp>() {
            return Some(Self::Absolute(seconds(stamp)));
        }
        // In `00:00:01.005,250` of Zephyr the comma separates microseconds.
        let last = text.rsplit(':').next().unwrap_or_default();
        let point = if last.contains('.') { "" } else { "." };
        let text = text.replace(',', point).replace("::", ":");
        let with_days = |mark: &str| {
            let (days, time) = text.split_once(mark)?;
            let time = time.trim_start_matches(['s', '.', ' ', '+']);
            let days: f64 = days.parse().ok()?;
            Some(Self::OfDay(days * DAY_S + time_of_day_s(time)?))
        };
        let days = ["d ", " day"]
            .into_iter()
            .filter(|mark| text.contains(mark));
        days.filter_map(with_days)
            .next()
            .or_else(|| Self::of_words(&text))
    }

    /// Parses the words of a date, a time of day and a time zone.
    fn of_words(text: &str) -> Option<Self> {
        let digit = |at: Option<usize>| {
            at.and_then(|at| text.as_bytes().get(at))
                .is_some_and(u8::is_ascii_digit)
        };
        let mut marks = text.match_indices('T');
        let mark = marks.find(|(at, _)| digit(at.checked_sub(1)) && digit(Some(at + 1)));
        let (front, back) = mark.map_or((text, ""), |(at, _)| (&text[..at], &text[at + 1..]));
        let mut words = Vec::with_capacity(6);
        words.extend(front.split_whitespace().chain(back.split_whitespace()));
        let at = words.iter().position(|word| word.contains(':'))?;
        let (time, attached) = match words[at].find(['+', '-', 'Z']) {
            Some(end) => words[at].split_at(end),
            None => (words[at], ""),
        };
        let mut date = Vec::with_capacity(4);
        date.extend(words[..at].iter().map(|word| word.trim_end_matches('.')));
        let has_weekday = date.first().is_some_and(|word| is_weekday(word));
        if has_weekday {
            date.remove(0);
        }
        let (mut half, mut zone_s) = ("", self::zone_s(attached));
        if zone_s.is_none() && !attached.is_empty() {
            return None;
        }
        for word in &words[at + 1..] {
            match self::zone_s(word) {
                Some(found_s) if !date.is_empty() => zone_s = Some(found_s),
                _ if matches!(word.to_ascii_lowercase().as_str(), "am" | "pm") => half = word,
                _ if is_zone_name(word) => {}
                // Without a weekday, a year after the time may be a reading.
                _ if has_weekday => date.push(word),
                _ => return None,
            }
        }
        let of_day_s = match half {
            "" => time_of_day_s(time)?,
            half => time_of_day_s(&format!("{time}{half}"))?,
        };
        // Several numbers may be readings.
        let date = match date[..] {
            [] => return Some(Self::OfDay(of_day_s)),
            [date] => Cow::Borrowed(date),
            _ => Some(date.join("-").into()).filter(|date: &Cow<str>| has_letter(date))?,
        };
        let Some(date) = day(&date) else {
            let known = dated(&format!("2000-{date}"))?;
            return Some(Self::OfDay(
                f64::from(known.day_of_year()) * DAY_S + of_day_s,
            ));
        };
        let midnight = DateTime::from_parts(date, jiff::civil::Time::midnight());
        let local_s = seconds(Offset::UTC.to_timestamp(midnight).ok()?) + of_day_s;
        Some(zone_s.map_or(Self::Local(local_s), |zone_s| {
            Self::Absolute(local_s - zone_s)
        }))
    }

    /// Returns the seconds without their origin.
    pub fn seconds(self) -> f64 {
        match self {
            Self::Absolute(s) | Self::Local(s) | Self::OfDay(s) => s,
        }
    }
}

/// Formats seconds since 1970 as a date; `None` outside the years 2000 to 2099.
pub fn date(seconds: f64) -> Option<String> {
    if !(946_684_800.0..4_102_444_800.0).contains(&seconds) {
        return None;
    }
    let microseconds = (seconds * 1e6).round() as i64;
    let stamp = Timestamp::from_microsecond(microseconds).ok()?;
    let date = stamp.to_zoned(jiff::tz::TimeZone::UTC).datetime();
    Some(date.to_string())
}

fn has_letter(text: &str) -> bool {
    text.contains(char::is_alphabetic)
}

fn is_weekday(word: &str) -> bool {
    let is = |form: &str| jiff::fmt::strtime::parse(form, word).is_ok();
    has_letter(word) && (is("%A") || is("%a"))
}

/// True for the name of a time zone other than UTC, such as `CET`. Its offset is not known.
fn is_zone_name(word: &str) -> bool {
    (3..=5).contains(&word.len()) && word.bytes().all(|byte| byte.is_ascii_uppercase())
}

/// Parses an offset from UTC, such as `+02:00`, `-0530`, `Z` or `UTC`. Returns seconds.
fn zone_s(text: &str) -> Option<f64> {
    if ["Z", "UTC", "GMT"].contains(&text) {
        return Some(0.0);
    }
    let digits = text.strip_prefix(['+', '-'])?.replacen(':', "", 1);
    let is_offset = digits.len() == 4 && digits.bytes().all(|byte| byte.is_ascii_digit());
    let (hours, minutes) = is_offset.then(|| digits.split_at(2))?;
    let (hours, minutes): (f64, f64) = (hours.parse().ok()?, minutes.parse().ok()?);
    let offset_s = 3600.0 * hours + 60.0 * minutes;
    let is_offset = hours <= 14.0 && minutes % 15.0 == 0.0 && minutes < 60.0;
    is_offset.then(|| offset_s.copysign(if text.starts_with('-') { -1.0 } else { 1.0 }))
}

/// Parses `20260131123005.25`. Milliseconds may follow without a point, and a space, `T` or `_`
/// may separate date and time. Returns seconds since 1970.
fn compact(text: &str) -> Option<f64> {
    let joined;
    let text = match text.as_bytes().get(8) {
        Some(b' ' | b'T' | b'_') => {
            joined = text.get(..8)?.to_owned() + text.get(9..)?;
            &joined
        }
        _ => text,
    };
    let (digits, fraction) = text.split_once('.').unwrap_or((text, "0"));
    let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if !matches!(digits.len(), 14 | 17) || !is_digits(digits) || !is_digits(fraction) {
        return None;
    }
    let part = |from: usize, to: usize| digits[from..to].parse::<f64>().ok();
    let (year, month, day) = (part(0, 4)?, part(4, 6)?, part(6, 8)?);
    let (hour, minute, second) = (part(8, 10)?, part(10, 12)?, part(12, 14)?);
    let millisecond = if digits.len() == 17 {
        part(14, 17)?
    } else {
        0.0
    };
    let is_time = hour < 24.0 && minute < 60.0 && second < 61.0;
    if !((1950.0..2100.0).contains(&year) && is_time) {
        return None;
    }
    let date = Date::new(year as i16, month as i8, day as i8).ok()?;
    let midnight = DateTime::from_parts(date, jiff::civil::Time::midnight());
    let midnight_s = seconds(Offset::UTC.to_timestamp(midnight).ok()?);
    let fraction: f64 = format!("0.{fraction}").parse().ok()?;
    Some(midnight_s + 3600.0 * hour + 60.0 * minute + second + 1e-3 * millisecond + fraction)
}

fn seconds(stamp: Timestamp) -> f64 {
    stamp.as_second() as f64 + f64::from(stamp.subsec_nanosecond()) * 1e-9
}

/// Parses `12:30:05.25`, `12:30:05:250`, `12:30` and `0:30:05 PM`. In `30:05.25` the decimals show
/// that the parts are minutes and seconds.
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
    if !has_half && time.contains('.') && time.matches(':').count() == 1 {
        return (minutes < 60.0).then_some(60.0 * hours + minutes);
    }
    let seconds = parts.next().unwrap_or(Some(0.0))?;
    let milliseconds = parts.next().unwrap_or(Some(0.0))?;
    let hours = if has_half { hours % 12.0 } else { hours };
    let is_time = hours < 25.0 && minutes < 60.0 && seconds < 61.0 && parts.next().is_none();
    is_time.then_some(3600.0 * hours + 60.0 * minutes + seconds + 1e-3 * milliseconds + later_s)
}

/// Parses a date with the year first or last. If the year is last and slashes separate the parts,
/// the first part is the month, unless it is too large.
fn day(text: &str) -> Option<Date> {
    if has_letter(text) {
        return dated(text);
    }
    if text.len() == 8 && text.as_bytes()[4] == b'-' {
        return Date::strptime("%Y-%j", text).ok();
    }
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

/// Parses a date with the name of the month.
fn dated(text: &str) -> Option<Date> {
    let orders = [
        "%d-%b-%Y", "%d-%B-%Y", "%b-%d-%Y", "%B-%d-%Y", "%Y-%b-%d", "%Y-%B-%d",
    ];
    orders
        .iter()
        .find_map(|order| Date::strptime(order, text).ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_dates_that_are_read_again() {
        for seconds in [1_769_862_605.25, 1_677_146_936.428_01, 1_000_000_000.0] {
            let text = date(seconds).expect("a date");
            let again = ClockTime::parse(&text).expect("a date").seconds();
            assert!((again - seconds).abs() < 1e-6, "{text}: {again}");
        }
        assert_eq!((date(12.0), date(f64::NAN)), (None, None));
    }

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
            ("31-Jan-2026 12:30:05.25", ClockTime::Local(noon)),
            ("2026/01/31 12:30:05::250", ClockTime::Local(noon)),
            ("20260131123005.25", ClockTime::Local(noon)),
            ("20260131123005250", ClockTime::Local(noon)),
            ("2026-01-31 12:30:05.25 UTC", ClockTime::Absolute(noon)),
            ("2026-01-31 12:30:05.25 Z", ClockTime::Absolute(noon)),
            ("2026-01-31 14:30:05.250 +0200", ClockTime::Absolute(noon)),
            ("2026-01-31 07:00:05,25 -05:30", ClockTime::Absolute(noon)),
            ("31.01.2026 14:30:05.25+02:00", ClockTime::Absolute(noon)),
            (
                "Sat, 31 Jan 2026 12:30:05.25 GMT",
                ClockTime::Absolute(noon),
            ),
            ("Sat Jan 31 12:30:05.25 2026", ClockTime::Local(noon)),
            ("Sat Jan 31 12:30:05.25 UTC 2026", ClockTime::Absolute(noon)),
            ("2026-01-31 12:30:05.25 CET", ClockTime::Local(noon)),
            ("31 January 2026 12:30:05.25", ClockTime::Local(noon)),
            ("Jan 31, 2026 12:30:05.25", ClockTime::Local(noon)),
            ("2026-031T12:30:05.25", ClockTime::Local(noon)),
            ("20260131 123005.25", ClockTime::Local(noon)),
            ("20260131T123005.25", ClockTime::Local(noon)),
            (
                "Jan 31 12:30:05.25",
                ClockTime::OfDay(31.0 * DAY_S + 45_005.25),
            ),
            (
                "Feb  1 12:30:05.25",
                ClockTime::OfDay(32.0 * DAY_S + 45_005.25),
            ),
            ("0d 00:01:01.5", ClockTime::OfDay(61.5)),
            ("2000-02-29 00:00:00", ClockTime::Local(951_782_400.0)),
            ("00:01:01.5", ClockTime::OfDay(61.5)),
            ("00:01:01:500", ClockTime::OfDay(61.5)),
            ("00:01:01.500,000", ClockTime::OfDay(61.5)),
            ("01:01.5", ClockTime::OfDay(61.5)),
            ("61:01,5", ClockTime::OfDay(3661.5)),
            ("01:01", ClockTime::OfDay(3660.0)),
            ("0 days 00:01:01.500000", ClockTime::OfDay(61.5)),
            ("1 day, 0:01:01", ClockTime::OfDay(86_461.0)),
            ("-1 days +23:59:59.5", ClockTime::OfDay(-0.5)),
        ] {
            assert_eq!(ClockTime::parse(text), Some(expected), "{text}");
        }
        for text in [
            "yesterday",
            "a:b",
            "2026-13-01 00:00:00",
            "1.5",
            "12:75:00",
            "20261331123005",
            "Jan 31 12:30:05 2048",
            "12:30:05 +0512",
            "12:30:05 1.5",
            "1 2 3 12:30:05",
            "2026-01-31 12:30:05 +0512",
            "12:30:05 left",
        ] {
            assert_eq!(ClockTime::parse(text), None, "{text}");
        }
    }
}
