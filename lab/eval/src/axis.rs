//! Axes: places of values and of ticks in a picture.

use ridgetone_host::picture::layout::nice;

#[derive(Clone, Copy, Debug)]
pub struct Axis {
    pub powers: (f64, f64),
    /// Their places, pixels.
    pub at: (f64, f64),
}

impl Axis {
    /// Whole decades around all values.
    pub fn around(values: impl Iterator<Item = f64>, at: (f64, f64)) -> Self {
        let range = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), value| {
            (value.min(a), value.max(b))
        });
        let (least, most) = if range.0 > 0.0 && range.1.is_finite() {
            range
        } else {
            (1.0, 10.0)
        };
        let from = least.log10().floor();
        Self {
            powers: (from, most.log10().ceil().max(from + 1.0)),
            at,
        }
    }

    pub fn place(&self, value: f64) -> f64 {
        let (from, to) = self.powers;
        self.at.0 + (self.at.1 - self.at.0) * (value.log10() - from) / (to - from)
    }

    pub fn ticks(&self) -> impl Iterator<Item = i32> {
        self.powers.0 as i32..=self.powers.1 as i32
    }
}

/// An evenly divided axis.
#[derive(Clone, Copy, Debug)]
pub struct Linear {
    pub range: (f64, f64),
    pub at: (f64, f64),
}

impl Linear {
    pub fn place(&self, value: f64) -> f64 {
        let (from, to) = self.range;
        self.at.0 + (self.at.1 - self.at.0) * (value - from) / (to - from)
    }

    /// Round values, about `wanted` of them, with as many decimals as they need.
    pub fn ticks(&self, wanted: u32) -> Vec<(f64, String)> {
        let (from, to) = self.range;
        let step = nice((to - from) / f64::from(wanted));
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let numbers = (from / step - 1e-9).ceil() as i64..=(to / step + 1e-9).floor() as i64;
        numbers
            .map(|n| n as f64 * step)
            .map(|value| (value, format!("{value:.decimals$}")))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_holds_its_values_in_whole_decades() {
        let axis = Axis::around([0.03, 4.0].into_iter(), (0.0, 300.0));
        assert_eq!(axis.ticks().collect::<Vec<_>>(), [-2, -1, 0, 1]);
        assert!((axis.place(1.0) - 200.0).abs() < 1e-9);
        assert_eq!(Axis::around([].into_iter(), (0.0, 1.0)).ticks().count(), 2);
    }

    #[test]
    fn ticks_are_round_and_within() {
        let axis = Linear {
            range: (-0.3, 1.0),
            at: (100.0, 0.0),
        };
        let ticks: Vec<String> = axis.ticks(5).into_iter().map(|(_, label)| label).collect();
        assert_eq!(ticks, ["-0.2", "0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert!((axis.place(0.35) - 50.0).abs() < 1e-9);
    }
}
