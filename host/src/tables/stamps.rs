//! Converts the stamps of rows to seconds: units, counters that wrap, midnight, daylight saving.

use super::cells::Numbers;
use super::clock_time::{ClockTime, DAY_S};

/// Values at which microcontrollers' counters wrap: 16 and 32 bits.
const WRAPS: [f64; 2] = [65_536.0, 4_294_967_296.0];

/// Start of a count other than 1970.
#[derive(Debug)]
struct Origin {
    /// Units per second in which the program counts.
    per_second: f64,
    /// Seconds from the start to 1970.
    before_1970_s: f64,
    note: &'static str,
}

/// Number of .NET's and Windows' ticks per second.
pub const TICKS_PER_SECOND: f64 = 1e7;

const ORIGINS: [Origin; 5] = [
    Origin {
        per_second: 1.0,
        before_1970_s: 2_082_844_800.0,
        note: "it counts from 1904, as LabVIEW does",
    },
    Origin {
        per_second: TICKS_PER_SECOND,
        before_1970_s: 11_644_473_600.0,
        note: "it counts from 1601, as Windows does",
    },
    Origin {
        per_second: TICKS_PER_SECOND,
        before_1970_s: 62_135_596_800.0,
        note: "it counts from the year 1, as .NET does",
    },
    Origin {
        per_second: 1.0 / DAY_S,
        before_1970_s: 25_569.0 * DAY_S,
        note: "it counts from 1900, as spreadsheets do",
    },
    Origin {
        per_second: 1.0 / DAY_S,
        before_1970_s: 719_529.0 * DAY_S,
        note: "it counts from the year 0, as MATLAB does",
    },
];

/// Years 2000 to 2035, seconds since 1970.
const THIS_TIME_S: core::ops::Range<f64> = 946_684_800.0..2_082_844_800.0;

/// Finds the start of a count, other than 1970, that gives a date between 2000 and 2035.
fn origin(count: f64, per_second: f64) -> Option<&'static Origin> {
    let mut known = ORIGINS
        .iter()
        .filter(|origin| origin.per_second == per_second);
    known.find(|origin| THIS_TIME_S.contains(&(count / per_second - origin.before_1970_s)))
}

/// True for the count of .NET's or Windows' ticks at a date between 2000 and 2035.
pub fn are_ticks(count: f64) -> bool {
    origin(count, TICKS_PER_SECOND).is_some()
}

/// Steps of daylight saving time, seconds.
const SAVING_S: f64 = 3600.0;

/// Maximum deviation of a daylight-saving step from an hour, in row spacings.
const SAVING_STEPS: f64 = 10.0;

/// Kind of the stamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unit {
    /// Numbers, with this many per second.
    PerSecond(f64),
    /// Dates, or times of day.
    Clock,
}

/// Turns the stamps of a column into seconds, row by row.
#[derive(Clone, Debug)]
pub struct Stamps {
    pub unit: Unit,
    /// Added to the number that is read, in the unit of that number.
    offset: f64,
    before: Option<f64>,
    /// Latest positive step between two stamps.
    step_s: Option<f64>,
    /// Start of the count, if it is not 1970.
    origin: Option<&'static Origin>,
    has_wrapped: bool,
    has_passed_midnight: bool,
    has_saved: bool,
}

impl Stamps {
    pub fn new(unit: Unit) -> Self {
        Self {
            unit,
            offset: 0.0,
            before: None,
            step_s: None,
            origin: None,
            has_wrapped: false,
            has_passed_midnight: false,
            has_saved: false,
        }
    }

    /// Converts the next row's stamp to seconds; `None` if the cell has no time.
    pub fn seconds(&mut self, cell: &str, numbers: &Numbers) -> Option<f64> {
        let (read, per_second) = match self.unit {
            Unit::PerSecond(per_second) => {
                let read = numbers.number(cell).filter(|read| !read.is_nan())?;
                if self.before.is_none()
                    && let Some(origin) = origin(read, per_second)
                {
                    self.offset = -origin.before_1970_s * per_second;
                    self.origin = Some(origin);
                }
                self.follow_counter(read);
                (read, per_second)
            }
            Unit::Clock => {
                let clock = ClockTime::parse(cell)?;
                self.follow_clock(clock);
                (clock.seconds(), 1.0)
            }
        };
        self.before = Some(read);
        Some((read + self.offset) / per_second)
    }

    fn follow_counter(&mut self, read: f64) {
        let Some(before) = self.before else {
            return;
        };
        let is_counter = before.fract() == 0.0 && read.fract() == 0.0 && read >= 0.0;
        let wrap = WRAPS
            .into_iter()
            .find(|wrap| before < *wrap && before - read > 0.5 * wrap);
        if let Some(wrap) = wrap.filter(|_| is_counter) {
            self.offset += wrap;
            self.has_wrapped = true;
        }
    }

    fn follow_clock(&mut self, clock: ClockTime) {
        let Some(before) = self.before else {
            return;
        };
        let step_s = clock.seconds() - before;
        let is_absolute = matches!(clock, ClockTime::Absolute(_));
        let is_of_day = matches!(clock, ClockTime::OfDay(_));
        let reach_s = SAVING_STEPS * self.step_s.unwrap_or(0.0);
        if is_of_day && step_s < -0.5 * DAY_S {
            self.offset += DAY_S;
            self.has_passed_midnight = true;
        } else if !is_absolute && (step_s.abs() - SAVING_S).abs() <= reach_s.min(0.5 * SAVING_S) {
            self.offset -= SAVING_S.copysign(step_s);
            self.has_saved = true;
        } else if step_s > 0.0 {
            self.step_s = Some(step_s);
        }
    }

    /// Returns the assumptions made about the rows so far.
    pub fn guessed(&self) -> impl Iterator<Item = &'static str> + use<> {
        let notes = [
            (self.has_wrapped, "its counter wraps and was unrolled"),
            (self.has_passed_midnight, "it passes midnight"),
            (
                self.has_saved,
                "a step of an hour is taken for daylight saving",
            ),
        ];
        let notes = notes
            .into_iter()
            .filter_map(|(has, note)| has.then_some(note));
        self.origin
            .map(|origin| origin.note)
            .into_iter()
            .chain(notes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(unit: Unit, cells: &[&str]) -> (Vec<f64>, Vec<&'static str>) {
        let (mut stamps, numbers) = (Stamps::new(unit), Numbers::new(true));
        let read = cells
            .iter()
            .map(|cell| stamps.seconds(cell, &numbers).expect("a time"));
        let read = read.collect();
        (read, stamps.guessed().collect())
    }

    #[test]
    fn counters_wrap() {
        let (read, notes) = seconds(Unit::PerSecond(1e6), &["4294963296", "0", "4000"]);
        assert_eq!(read, [4294.963296, 4294.967296, 4294.971296]);
        assert_eq!(notes.len(), 1);
        let (read, _) = seconds(Unit::PerSecond(1e3), &["65532", "65535", "2", "65534", "1"]);
        assert_eq!(read, [65.532, 65.535, 65.538, 131.070, 131.073]);
        // A small step backwards is not a wrap.
        assert_eq!(seconds(Unit::PerSecond(1.0), &["10", "9"]).0, [10.0, 9.0]);
    }

    #[test]
    fn programs_count_from_other_years_than_1970() {
        // `date -u -d 2026-03-05T12:00:00 +%s` is 1772712000; in Python,
        // `(datetime(2026, 3, 5, 12) - datetime(1601, 1, 1)).total_seconds()` is 13417185600.
        for (per_second, cell) in [
            (1e7, "134171856000000000"),
            (1e7, "639083088000000000"),
            (1.0 / DAY_S, "46086.5"),
            (1.0 / DAY_S, "740046.5"),
        ] {
            let (read, notes) = seconds(Unit::PerSecond(per_second), &[cell]);
            assert!((read[0] - 1_772_712_000.0).abs() < 1e-3, "{cell}: {read:?}");
            assert_eq!(notes.len(), 1, "{cell}");
        }
        let (read, notes) = seconds(Unit::PerSecond(1.0), &["3855556800.0", "3855556800.5"]);
        assert_eq!(
            (read, notes.len()),
            (vec![1_772_712_000.0, 1_772_712_000.5], 1)
        );
        let (read, notes) = seconds(Unit::PerSecond(1e6), &["3855556800", "3855556900"]);
        assert_eq!((read[0], notes.len()), (3855.5568, 0));
    }

    #[test]
    fn clocks_pass_midnight_and_are_put_forward_and_back() {
        let (read, _) = seconds(Unit::Clock, &["23:59:59.5", "23:59:59.9", "00:00:00.3"]);
        assert!((read[2] - read[1] - 0.4).abs() < 1e-9, "{read:?}");
        for hour in ["03", "01"] {
            let jumped = format!("2025-03-30 {hour}:00:00.000");
            let cells = [
                "2025-03-30 01:59:59.992",
                "2025-03-30 01:59:59.996",
                &jumped,
            ];
            let (read, notes) = seconds(Unit::Clock, &cells);
            assert!((read[2] - read[1] - 0.004).abs() < 1e-6, "{hour}: {read:?}");
            assert_eq!(notes.len(), 1);
        }
        // With a UTC offset the hour is unambiguous.
        let (read, _) = seconds(
            Unit::Clock,
            &[
                "2025-03-30T01:59:59.996+01:00",
                "2025-03-30T03:00:00.000+02:00",
            ],
        );
        assert!((read[1] - read[0] - 0.004).abs() < 1e-6, "{read:?}");
    }
}
