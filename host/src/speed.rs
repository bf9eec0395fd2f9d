//! A column of speeds or positions next to the channels of a recording.

/// Units of length by their millimetres.
const LENGTHS: [(&str, f64); 6] = [
    ("mm", 1.0),
    ("cm", 10.0),
    ("m", 1000.0),
    ("um", 1e-3),
    ("µm", 1e-3),
    ("in", 25.4),
];

/// Quantity in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Position of the finger on the surface.
    Position,
    /// Speed of the finger over the surface.
    Speed,
}

/// A column with the finger's position or speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    quantity: Quantity,
    name: String,
    /// Millimetres, or millimetres per second, of the column's unit, if somebody says it.
    mm_per_unit: Option<f64>,
}

impl Column {
    /// `NAME` or `NAME:UNIT`.
    pub fn parse(quantity: Quantity, text: &str) -> Result<Self, String> {
        let named = |name: &str, mm_per_unit| Self {
            quantity,
            name: name.to_owned(),
            mm_per_unit,
        };
        let Some((name, unit)) = text.rsplit_once(':') else {
            return Ok(named(text, None));
        };
        let length = match quantity {
            Quantity::Position => Some(unit),
            Quantity::Speed => unit.strip_suffix("/s"),
        };
        let per_second = if quantity == Quantity::Speed {
            "/s"
        } else {
            ""
        };
        match length.and_then(millimetres) {
            Some(mm) => Ok(named(name, Some(mm))),
            None => Err(format!(
                "unit {unit:?}: choose mm{per_second}, cm{per_second}, m{per_second}, um{per_second} or in{per_second}"
            )),
        }
    }

    /// A column of positions in millimetres.
    pub fn millimetres(name: &str) -> Self {
        Self {
            quantity: Quantity::Position,
            name: name.to_owned(),
            mm_per_unit: Some(1.0),
        }
    }

    /// The one column among these whose name begins with `position` or `speed`.
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
                names.join(", ")
            )),
        }
    }

    /// Reads positions in counts of an encoder.
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

    /// Millimetres of its unit: as given, or as its name says; else it is in millimetres. Whole
    /// numbers without a unit may be counts, and the error asks.
    pub fn mm_per_unit(&self, values: &[f64]) -> Result<f64, String> {
        if let Some(known) = self.mm_per_unit.or_else(|| self.named_mm()) {
            return Ok(known);
        }
        // A column that stands still is refused for that.
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

    /// Millimetres of the unit at the end of its name: `speed_m_s`, `x [mm]`.
    fn named_mm(&self) -> Option<f64> {
        let name = self.name.to_lowercase();
        let words: Vec<&str> = name
            .split(|c: char| !c.is_alphanumeric())
            .filter(|word| !word.is_empty())
            .collect();
        match (self.quantity, &words[..]) {
            (Quantity::Position, [_, .., unit]) => millimetres(unit),
            (Quantity::Speed, [_, .., unit, "s"]) => millimetres(unit),
            _ => None,
        }
    }

    /// What its unit is taken for, where that is not millimetres.
    pub fn guessed(&self) -> Option<String> {
        let mm = self
            .named_mm()
            .filter(|mm| *mm != 1.0 && self.mm_per_unit.is_none())?;
        let unit = LENGTHS
            .iter()
            .find(|(_, known)| *known == mm)
            .map(|(unit, _)| *unit)?;
        let per_second = if self.quantity == Quantity::Speed {
            "/s"
        } else {
            ""
        };
        Some(format!("column {} is in {unit}{per_second}", self.name))
    }
}

fn millimetres(unit: &str) -> Option<f64> {
    let known = LENGTHS.iter().find(|(name, _)| *name == unit);
    known.map(|(_, mm)| *mm)
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
        let counts = Column::parse(position, "encoder")
            .unwrap()
            .with_mm_per_count(Some(0.025));
        assert_eq!(counts.mm_per_unit(&[1.0, 4.0]), Ok(0.025));
    }
}
