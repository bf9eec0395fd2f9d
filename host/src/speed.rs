//! A column of speeds or positions next to the channels of a recording.

use crate::tables::{bracketed, listed};

/// Units of length, in millimetres.
const LENGTHS: [(&str, f64); 22] = [
    ("mm", 1.0),
    ("cm", 10.0),
    ("m", 1000.0),
    ("um", 1e-3),
    ("in", 25.4),
    ("µm", 1e-3),
    ("μm", 1e-3),
    ("nm", 1e-6),
    ("dm", 100.0),
    ("km", 1e6),
    ("inch", 25.4),
    ("inches", 25.4),
    ("ft", 304.8),
    ("feet", 304.8),
    ("mil", 0.0254),
    ("mils", 0.0254),
    ("thou", 0.0254),
    ("millimetre", 1.0),
    ("millimetres", 1.0),
    ("metre", 1000.0),
    ("metres", 1000.0),
    ("meters", 1000.0),
];

/// Units of time, in seconds.
const TIMES: [(&str, f64); 9] = [
    ("s", 1.0),
    ("sec", 1.0),
    ("second", 1.0),
    ("ms", 1e-3),
    ("min", 60.0),
    ("minute", 60.0),
    ("h", 3600.0),
    ("hr", 3600.0),
    ("hour", 3600.0),
];

/// Units of speed that are a single word, in millimetres per second.
const SPEEDS: [(&str, f64); 9] = [
    ("mps", 1000.0),
    ("mmps", 1.0),
    ("kmh", 1e6 / 3600.0),
    ("kph", 1e6 / 3600.0),
    ("mph", 1_609_344.0 / 3600.0),
    ("ips", 25.4),
    ("ipm", 25.4 / 60.0),
    ("fps", 304.8),
    ("mmpm", 1.0 / 60.0),
];

/// Other units that may end a name.
const OTHERS: [&str; 22] = [
    "deg", "degree", "degrees", "rad", "rpm", "rps", "hz", "v", "mv", "count", "counts", "tick",
    "ticks", "step", "steps", "pulses", "n", "g", "pct", "percent", "revs", "turns",
];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Position of the finger on the surface.
    Position,
    /// Speed of the finger over the surface.
    Speed,
}

impl Quantity {
    /// Returns a unit in millimetres or millimetres per second.
    fn mm(self, unit: &str) -> Option<f64> {
        let unit = unit
            .to_lowercase()
            .replace(" per ", "/")
            .replace([' ', '.', '^', '*'], "");
        let in_table = |table: &[(&str, f64)], unit: &str| {
            let known = table.iter().find(|(name, _)| *name == unit);
            known.map(|(_, value)| *value)
        };
        if self == Self::Position {
            return in_table(&LENGTHS, &unit);
        }
        if let Some(known) = in_table(&SPEEDS, &unit) {
            return Some(known);
        }
        let (length, time) = match unit.split_once('/') {
            Some(parts) => parts,
            None => (unit.strip_suffix("s-1")?, "s"),
        };
        Some(in_table(&LENGTHS, length)? / in_table(&TIMES, time)?)
    }

    fn units(self) -> &'static str {
        match self {
            Self::Position => "mm, cm, m, um or in",
            Self::Speed => "mm/s, cm/s, m/s, um/s, in/s, mm/min, m/min or km/h",
        }
    }
}

/// A column with the finger's position or speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    quantity: Quantity,
    name: String,
    /// Unit of the column in millimetres or millimetres per second, if specified.
    mm_per_unit: Option<f64>,
}

impl Column {
    /// Parses `NAME` or `NAME:UNIT`.
    pub fn parse(quantity: Quantity, text: &str) -> Result<Self, String> {
        let named = |name: &str, mm_per_unit| Self {
            quantity,
            name: name.to_owned(),
            mm_per_unit,
        };
        let Some((name, unit)) = text.rsplit_once(':') else {
            return Ok(named(text, None));
        };
        match quantity.mm(unit) {
            Some(mm) => Ok(named(name, Some(mm))),
            // The name itself may contain a colon.
            None if unit.contains([' ', '(', '[']) => Ok(named(text, None)),
            None => Err(format!("unit {unit:?}: choose {}", quantity.units())),
        }
    }

    /// Returns the column with its full name. The unit in brackets may have been omitted.
    #[must_use]
    pub fn resolved(self, names: &[String]) -> Self {
        let is_it = |name: &&String| bracketed(name).is_some_and(|(before, _)| before == self.name);
        if names.contains(&self.name) {
            return self;
        }
        match names.iter().filter(is_it).collect::<Vec<_>>()[..] {
            [name] => Self {
                name: name.clone(),
                ..self
            },
            _ => self,
        }
    }

    /// Creates a column of positions in millimetres.
    pub fn millimetres(name: &str) -> Self {
        Self {
            quantity: Quantity::Position,
            name: name.to_owned(),
            mm_per_unit: Some(1.0),
        }
    }

    /// Finds the only column whose name begins with `position` or `speed`.
    pub fn found(names: &[String]) -> Result<Self, String> {
        let begins = |name: &&String, word: &str| name.to_lowercase().starts_with(word);
        let all: Vec<Self> = [(Quantity::Position, "position"), (Quantity::Speed, "speed")]
            .into_iter()
            .flat_map(|(quantity, word)| {
                let own = names.iter().filter(move |name| begins(name, word));
                own.map(move |name| Self::parse(quantity, name))
            })
            .collect::<Result<_, _>>()?;
        match <[Self; 1]>::try_from(all) {
            Ok([one]) => Ok(one),
            Err(all) => Err(format!(
                "{} columns are called position or speed; there are: {}: choose one with --position-column or --speed-column",
                if all.is_empty() { "no" } else { "several" },
                listed(names)
            )),
        }
    }

    /// Sets the unit of positions in encoder counts.
    #[must_use]
    pub fn with_mm_per_count(self, mm_per_count: Option<f64>) -> Self {
        Self {
            mm_per_unit: mm_per_count.or(self.mm_per_unit),
            ..self
        }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn quantity(&self) -> Quantity {
        self.quantity
    }

    /// Returns the unit in millimetres: as specified, or from the column's name, or 1. Fails if the
    /// unit is not a length or speed. Also fails for whole numbers without a unit, which may be
    /// encoder counts.
    pub fn mm_per_unit(&self, values: &[f64]) -> Result<f64, String> {
        if let Some(known) = self.mm_per_unit {
            return Ok(known);
        }
        match self.named_mm() {
            Named::Known(mm) => return Ok(mm),
            Named::Unknown(unit) => return Err(self.refusal(&unit)),
            Named::Nothing => {}
        }
        // A constant column is refused elsewhere, for being constant.
        let moves = values.windows(2).any(|pair| pair[0] != pair[1]);
        let are_whole = values
            .iter()
            .all(|value| value.is_nan() || value.fract() == 0.0);
        let (name, option) = (&self.name, self.option());
        match self.quantity {
            _ if !(are_whole && moves) => Ok(1.0),
            Quantity::Position => Err(format!(
                "column {name} has whole numbers without a unit: say which with {option} {name}:mm (or m, cm, um, in), or give --mm-per-count if they are counts"
            )),
            Quantity::Speed => Err(format!(
                "column {name} has whole numbers without a unit: say which with {option} {name}:mm/s (or m/s, cm/s, um/s, in/s)"
            )),
        }
    }

    fn option(&self) -> &'static str {
        match self.quantity {
            Quantity::Position => "--position-column",
            Quantity::Speed => "--speed-column",
        }
    }

    /// Finds the unit at the end of the name or in brackets: `speed_m_s`, `x [mm]`, `speed (km/h)`.
    fn named_mm(&self) -> Named {
        if let Some((before, inside)) = bracketed(&self.name)
            && !before.is_empty()
        {
            return match self.quantity.mm(inside) {
                Some(mm) => Named::Known(mm),
                None => Named::Unknown(inside.to_owned()),
            };
        }
        let name = self.name.to_lowercase();
        let words: Vec<&str> = name
            .split(|c: char| !c.is_alphanumeric())
            .filter(|word| !word.is_empty())
            .collect();
        let known = match (self.quantity, &words[..]) {
            (Quantity::Position, [_, .., unit]) => self.quantity.mm(unit),
            (Quantity::Speed, [_, .., unit]) if self.quantity.mm(unit).is_some() => {
                self.quantity.mm(unit)
            }
            (Quantity::Speed, [_, .., length, time]) => {
                self.quantity.mm(&format!("{length}/{time}"))
            }
            _ => None,
        };
        match (known, &words[..]) {
            (Some(mm), _) => Named::Known(mm),
            (None, [_, .., last]) if OTHERS.contains(last) => Named::Unknown((*last).to_owned()),
            _ => Named::Nothing,
        }
    }

    fn refusal(&self, unit: &str) -> String {
        let (name, option) = (&self.name, self.option());
        let what = match self.quantity {
            Quantity::Position => "no length on the surface",
            Quantity::Speed => "no speed over the surface",
        };
        let way_out = match self.quantity {
            Quantity::Position => format!(
                "say how many mm one is with --mm-per-count, or give another unit as {option} '{name}:mm'"
            ),
            Quantity::Speed => format!(
                "convert the column to mm/s, or give another unit as {option} '{name}:mm/s'"
            ),
        };
        format!(
            "column {name}: {unit:?} is {what} that is known: {way_out} ({})",
            self.quantity.units()
        )
    }

    /// Describes the assumed unit, if not millimetres.
    pub fn guessed(&self) -> Option<String> {
        let (Named::Known(mm), None) = (self.named_mm(), self.mm_per_unit) else {
            return None;
        };
        let per_second = match self.quantity {
            Quantity::Speed => "/s",
            Quantity::Position => "",
        };
        let unit = LENGTHS.iter().find(|(_, known)| *known == mm);
        match unit {
            _ if mm == 1.0 => None,
            Some((unit, _)) => Some(format!("column {} is in {unit}{per_second}", self.name)),
            None => Some(format!(
                "column {} is in units of {} mm{per_second}",
                self.name,
                crate::digits::significant(mm, 4)
            )),
        }
    }
}

/// Unit found in a name.
enum Named {
    /// Unit in millimetres or millimetres per second.
    Known(f64),
    /// Unit that is unknown, or neither a length nor a speed.
    Unknown(String),
    Nothing,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;

    #[test]
    fn speeds_are_summed_and_gaps_filled() {
        let grid = Grid {
            places: vec![0, 1, 4, 5],
            ..Grid::even(0, 10.0)
        };
        let column = |quantity, text| Column::parse(quantity, text).unwrap();
        let speeds = |text, values: &[f64]| {
            let speed = column(Quantity::Speed, text);
            grid.positions_mm(&speed, values).unwrap()
        };
        let speed = speeds("v:mm/s", &[10.0, 20.0, 20.0, -40.0]);
        assert_eq!(speed, [0.0, 1.5, 3.5, 5.5, 7.5, 6.5]);
        let blank = speeds("v_mm_s", &[10.0, f64::NAN, 20.0, -40.0]);
        assert_eq!(blank, [0.0, 1.5, 3.0, 4.5, 6.0, 5.0]);
        let x = column(Quantity::Position, "x:mm");
        let position = grid.positions_mm(&x, &[7.0, 8.0, 11.0, 9.0]).unwrap();
        assert_eq!(position, [0.0, 1.0, 2.0, 3.0, 4.0, 2.0]);
    }

    #[test]
    fn units_are_given_named_or_asked_for() {
        let mm = |quantity, text: &str, values: &[f64]| {
            Column::parse(quantity, text).and_then(|column| column.mm_per_unit(values))
        };
        let (position, speed) = (Quantity::Position, Quantity::Speed);
        for (quantity, text, expected) in [
            (speed, "v:m/s", 1000.0),
            (speed, "speed_m_s", 1000.0),
            (speed, "Speed [cm/s]", 10.0),
            (speed, "v_mm_s", 1.0),
            (speed, "v", 1.0),
            (position, "x:um", 1e-3),
            (position, "x_m", 1000.0),
            (position, "x", 1.0),
            (speed, "speed (km/h)", 1e6 / 3600.0),
            (speed, "speed_m_min", 1000.0 / 60.0),
            (speed, "speed (mm/min)", 1.0 / 60.0),
            (speed, "v [m s-1]", 1000.0),
            (speed, "feed_ipm", 25.4 / 60.0),
            (speed, "v:km/h", 1e6 / 3600.0),
            (position, "position (inch)", 25.4),
            (position, "x_um", 1e-3),
        ] {
            assert_eq!(mm(quantity, text, &[0.25, 1.5]), Ok(expected), "{text}");
        }
        assert!(
            mm(position, "encoder", &[1.0, 4.0]).is_err_and(|why| why.contains("--mm-per-count"))
        );
        assert!(
            mm(speed, "v", &[1.0, 4.0]).is_err_and(|why| why.contains("--speed-column v:mm/s"))
        );
        assert!(mm(speed, "v:mm", &[0.5]).is_err_and(|why| why.contains("choose mm/s")));
        for (quantity, name, unit) in [
            (speed, "speed (rpm)", "rpm"),
            (speed, "speed_rpm", "rpm"),
            (position, "position (deg)", "deg"),
            (position, "position (furlongs)", "furlongs"),
        ] {
            let refused = mm(quantity, name, &[0.25, 1.5]);
            assert!(
                refused.is_err_and(|why| why.contains(&format!("{unit:?}"))),
                "{name}"
            );
        }
        let names = ["position (m)".to_owned(), "a".to_owned()];
        let column = Column::parse(position, "position")
            .unwrap()
            .resolved(&names);
        assert_eq!(
            (column.name(), column.mm_per_unit(&[0.5, 1.0])),
            ("position (m)", Ok(1000.0))
        );
        let counts = Column::parse(position, "encoder")
            .unwrap()
            .with_mm_per_count(Some(0.025));
        assert_eq!(counts.mm_per_unit(&[1.0, 4.0]), Ok(0.025));
    }
}
