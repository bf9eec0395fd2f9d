//! Settings that are measured: a line of the paper's Table 2, a window, noise, overtones.

use crate::simulated::Simulated;
use anyhow::Result;
use hal_mock::{Sliding, TABLE_2};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Fewest cycles in a window that is measured.
pub const CYCLES_MIN: f64 = 1.0;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Length {
    /// This number of seconds, of a slide that is long enough.
    Seconds(f64),
    /// The whole slide of the paper's 60 mm, its ends trimmed as the detector does.
    Slide,
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Seconds(seconds) => write!(f, "{seconds} s"),
            Self::Slide => f.write_str("whole slide"),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    pub speed_mm_s: f64,
    pub period_mm: f64,
    pub length: Length,
    /// Noise, decibels below the tone's fundamental.
    pub snr_db: f64,
    /// Harmonics that the scene carries, the fundamental included, 1 to 4.
    pub carried: u8,
}

impl Setting {
    /// All lines of Table 2 that have a cycle in the window.
    pub fn table_2(length: Length, snr_db: f64, carried: u8) -> impl Iterator<Item = Self> {
        let lines = TABLE_2.into_iter();
        lines
            .map(move |(speed_mm_s, period_mm)| Self {
                speed_mm_s,
                period_mm,
                length,
                snr_db,
                carried,
            })
            .filter(|setting| setting.cycles() >= CYCLES_MIN)
    }

    pub fn frequency_hz(&self) -> f64 {
        self.speed_mm_s / self.period_mm
    }

    /// Cycles in the window, those of a whole slide before it is trimmed.
    pub fn cycles(&self) -> f64 {
        match self.length {
            Length::Seconds(window_s) => self.frequency_hz() * window_s,
            Length::Slide => Sliding::default().slide_mm / self.period_mm,
        }
    }

    /// Whether the estimator fits a slope to each channel, and the bound takes it as unknown.
    pub fn slope(&self) -> bool {
        true
    }

    /// A window; every seed gives another.
    pub fn window(&self, seed: u64) -> Result<Simulated> {
        match self.length {
            // Long enough, whatever the speed.
            Length::Seconds(window_s) => Simulated::new(
                &self.scene(self.speed_mm_s * (window_s + 1.0), seed),
                window_s,
            ),
            Length::Slide => Simulated::whole_slide(&self.scene(Sliding::default().slide_mm, seed)),
        }
    }

    fn scene(&self, slide_mm: f64, seed: u64) -> Sliding {
        let Self {
            speed_mm_s,
            period_mm,
            snr_db,
            carried,
            ..
        } = *self;
        let mut overtones = Sliding::default().overtones;
        overtones
            .iter_mut()
            .skip(usize::from(carried).saturating_sub(1))
            .for_each(|relative| *relative = 0.0);
        Sliding {
            speed_mm_s,
            period_mm,
            slide_mm,
            snr_db: Some(snr_db),
            overtones,
            seed,
            ..Sliding::default()
        }
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            speed_mm_s,
            period_mm,
            length,
            snr_db,
            ..
        } = self;
        write!(
            f,
            "{speed_mm_s} mm/s, {period_mm} mm, {length}, {snr_db} dB"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_of_less_than_a_cycle_are_left_out() {
        assert_eq!(Setting::table_2(Length::Seconds(0.2), 20.0, 4).count(), 7);
        assert_eq!(Setting::table_2(Length::Slide, 20.0, 4).count(), 10);
    }

    #[test]
    fn a_whole_slide_is_trimmed() {
        let setting = Setting {
            speed_mm_s: 48.0,
            period_mm: 3.1,
            length: Length::Slide,
            snr_db: 40.0,
            carried: 2,
        };
        // 1.25 s at 241.14 Hz are 301 frames, less five at either end.
        assert_eq!(setting.window(3).expect("a slide").values.len(), 291);
    }
}
