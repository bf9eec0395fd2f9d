//! The bars of accuracy, and their measurements.

use super::contender::{Contender, fit, samples};
use crate::accuracy::{Accuracy, rounded};
use crate::bar::Bar;
use crate::parallel;
use crate::setting::{Length, Setting};
use anyhow::Result;
use hal_mock::TABLE_2;
use serde::{Deserialize, Serialize};

pub const LENGTHS: [Length; 6] = [
    Length::Seconds(0.2),
    Length::Seconds(0.3),
    Length::Seconds(0.4),
    Length::Seconds(0.6),
    Length::Seconds(1.0),
    Length::Slide,
];
/// Noise, decibels below the tone.
pub const SNRS_DB: [f64; 3] = [10.0, 20.0, 40.0];
/// Harmonics of the scene and most of the fit.
pub const HARMONICS: u8 = 4;

/// Most that the RMS error may be above the bound: in fewer cycles than [`FEW_CYCLES`], and from
/// these on.
const RATIO_BARS: [f64; 2] = [1.10, 1.05];
const FEW_CYCLES: f64 = 1.5;
/// Most that it may be at [`PERCENT_SNR_DB`], percent of the frequency.
const PERCENT_BAR: f64 = 1.7;
const PERCENT_SNR_DB: f64 = 20.0;
/// Share of 95 % intervals that must hold the truth, percent.
const COVERAGE_BAR: (f64, f64) = (93.0, 97.0);
/// Most windows of noise alone in which a tone is found, percent.
const FALSE_ALARM_BAR: f64 = 1.0;
/// Least windows in which a tone of [`DETECTION_CYCLES`] cycles at [`DETECTION_SNR_DB`] is found,
/// percent.
const DETECTION_BAR: f64 = 99.0;
const DETECTION_CYCLES: f64 = 2.0;
const DETECTION_SNR_DB: f64 = 10.0;
/// A detected tone is within this share of the true one.
const DETECTED_WITHIN: f64 = 0.1;

/// A setting whose ratio is within three standard errors of its bar is measured again, with eight
/// times as many windows, all of them new: of 171 settings on the bar's good side a few look worse
/// in some draws.
const NEAR_SIGMAS: f64 = 3.0;
const AGAIN: u32 = 8;

/// From one setting's seeds to the next one's.
const SEEDS: u64 = 100_000;
/// Seeds of the second look, of noise alone, and of detection.
const AGAIN_SEED: u64 = 50_000;
const NOISE_SEED: u64 = 1_000_000_000;
const DETECTION_SEED: u64 = 2_000_000_000;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Windows {
    pub accuracy: u32,
    pub noise: u32,
    /// For each line of Table 2 at the detection bar.
    pub detection: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    pub setting: Setting,
    pub accuracy: Accuracy,
}

impl Cell {
    fn ratio(&self) -> f64 {
        self.accuracy
            .error
            .map_or(f64::INFINITY, |error| error.ratio)
    }

    /// The most that its error over the bound may be.
    fn ratio_bar(&self) -> f64 {
        RATIO_BARS[usize::from(self.setting.cycles() >= FEW_CYCLES)]
    }

    fn is_near_the_bar(&self) -> bool {
        self.accuracy
            .error
            .is_none_or(|error| error.ratio + NEAR_SIGMAS * error.ratio_sigma > self.ratio_bar())
    }

    pub fn is_above(&self) -> bool {
        self.ratio() > self.ratio_bar()
    }
}

/// The tones found in windows of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// None where it follows from the cycles.
    pub length: Option<Length>,
    pub windows: u32,
    pub found: u32,
}

impl Found {
    fn percent(&self) -> f64 {
        percent(self.found, self.windows)
    }
}

fn percent(part: u32, all: u32) -> f64 {
    100.0 * f64::from(part) / f64::from(all)
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bars {
    pub windows: Windows,
    /// Accuracy: every length, noise and line of Table 2.
    pub cells: Vec<Cell>,
    pub noise: Vec<Found>,
    pub detection: Found,
}

impl Bars {
    pub fn measure(windows: Windows) -> Result<Self> {
        Ok(Self {
            windows,
            cells: cells(windows.accuracy)?,
            noise: noise(windows.noise)?,
            detection: detection(windows)?,
        })
    }

    pub fn bars(&self) -> Vec<Bar> {
        let [few, others] = RATIO_BARS.map(|most| self.on_the_bound(most));
        vec![
            few,
            others,
            self.small(),
            self.octaves(),
            self.coverage(),
            self.false_alarms(),
            self.detected(),
        ]
    }

    /// The settings with this bar.
    fn on_the_bound(&self, most: f64) -> Bar {
        let cells: Vec<&Cell> = self
            .cells
            .iter()
            .filter(|cell| cell.ratio_bar() == most)
            .collect();
        let above = |snr_db: f64| {
            cells
                .iter()
                .filter(|cell| cell.is_above() && cell.setting.snr_db == snr_db)
                .count()
        };
        let each = SNRS_DB
            .map(|snr_db| format!("{} at {snr_db} dB", above(snr_db)))
            .join(", ");
        let worst = cells.iter().max_by(|a, b| a.ratio().total_cmp(&b.ratio()));
        let worst = worst.map_or_else(String::new, |cell| match cell.accuracy.error {
            Some(error) => format!(
                "; worst {:.3} \u{b1} {:.3} ({})",
                error.ratio, error.ratio_sigma, cell.setting
            ),
            None => format!("; no estimate at all ({})", cell.setting),
        });
        let cycles = if most == RATIO_BARS[0] {
            "1 to 1.5 cycles"
        } else {
            "from 1.5 cycles on"
        };
        Bar {
            bar: format!("RMS error over the bound, {cycles}"),
            limit: format!("at most {most:.2} in each setting"),
            measured: format!("above in {each}, of {} settings{worst}", cells.len()),
            met: !cells.iter().any(|cell| cell.is_above()),
        }
    }

    fn small(&self) -> Bar {
        let at = self
            .cells
            .iter()
            .filter(|cell| cell.setting.snr_db == PERCENT_SNR_DB);
        let percent = |cell: &Cell| {
            cell.accuracy
                .error
                .map_or(f64::INFINITY, |error| error.rms_percent)
        };
        let worst = at.max_by(|a, b| percent(a).total_cmp(&percent(b)));
        let measured = worst.map_or_else(String::new, |cell| {
            let bound = cell
                .accuracy
                .error
                .map_or(f64::NAN, |error| error.bound_percent);
            format!(
                "worst {:.3} %, where the bound is {bound:.3} % ({})",
                percent(cell),
                cell.setting
            )
        });
        Bar {
            bar: format!("RMS error at {PERCENT_SNR_DB} dB"),
            limit: format!("at most {PERCENT_BAR} % of the frequency in each setting"),
            measured,
            met: worst.is_some_and(|cell| percent(cell) <= PERCENT_BAR),
        }
    }

    fn octaves(&self) -> Bar {
        let sum = |count: &dyn Fn(&Accuracy) -> u32| {
            self.cells
                .iter()
                .map(|cell| count(&cell.accuracy))
                .sum::<u32>()
        };
        let (windows, octaves) = (sum(&|a| a.windows), sum(&|a| a.octaves));
        let (ambiguous, good) = (sum(&|a| a.ambiguous), sum(&|a| a.good));
        let silent = windows - good - ambiguous;
        Bar {
            bar: "octave errors".into(),
            limit: "none".into(),
            measured: format!(
                "{octaves} in {windows} windows ({ambiguous} ambiguous, {silent} without a frequency)"
            ),
            met: octaves == 0,
        }
    }

    fn coverage(&self) -> Bar {
        let groups = LENGTHS
            .into_iter()
            .flat_map(|length| SNRS_DB.map(|snr_db| (length, snr_db)));
        let mut shares: Vec<(f64, String)> = groups
            .map(|(length, snr_db)| {
                // Lines of Table 2 count alike, however many windows each of them was given.
                // Few cycles may have none that is good.
                let of = |cell: &&Cell| {
                    (cell.setting.length, cell.setting.snr_db) == (length, snr_db)
                        && cell.accuracy.good > 0
                };
                let shares = self
                    .cells
                    .iter()
                    .filter(of)
                    .map(|cell| percent(cell.accuracy.covered, cell.accuracy.good));
                let (sum, count) =
                    shares.fold((0.0, 0.0), |(sum, count), share| (sum + share, count + 1.0));
                (sum / count, format!("{length}, {snr_db} dB"))
            })
            .filter(|(share, _): &(f64, String)| share.is_finite())
            .collect();
        shares.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (least, most) = (shares.first(), shares.last());
        let within = |share: f64| share >= COVERAGE_BAR.0 && share <= COVERAGE_BAR.1;
        let share_of = |end: Option<&(f64, String)>| {
            end.map_or_else(String::new, |(share, at)| format!("{share:.1} % ({at})"))
        };
        Bar {
            bar: "95 % intervals that hold the truth, for each window and noise".into(),
            limit: format!("{} to {} %", COVERAGE_BAR.0, COVERAGE_BAR.1),
            measured: format!("{} to {}", share_of(least), share_of(most)),
            met: shares.iter().all(|(share, _)| within(*share)),
        }
    }

    fn false_alarms(&self) -> Bar {
        let worst = self
            .noise
            .iter()
            .map(Found::percent)
            .fold(f64::NEG_INFINITY, f64::max);
        let each = self.noise.iter().map(|found| {
            let length = found
                .length
                .map_or_else(String::new, |length| length.to_string());
            format!("{length}: {} of {}", found.found, found.windows)
        });
        Bar {
            bar: "false alarms in noise alone, by window".into(),
            limit: format!("at most {FALSE_ALARM_BAR} %"),
            measured: format!(
                "{worst:.2} % at most ({})",
                each.collect::<Vec<_>>().join(", ")
            ),
            met: worst <= FALSE_ALARM_BAR,
        }
    }

    fn detected(&self) -> Bar {
        let Found { windows, found, .. } = self.detection;
        let share = self.detection.percent();
        Bar {
            bar: format!("tones found at {DETECTION_SNR_DB} dB and {DETECTION_CYCLES} cycles"),
            limit: format!("at least {DETECTION_BAR} %"),
            measured: format!("{:.2} % ({found} of {windows})", rounded(share)),
            met: share >= DETECTION_BAR,
        }
    }
}

fn cells(windows: u32) -> Result<Vec<Cell>> {
    let of_length = |length| {
        SNRS_DB
            .into_iter()
            .flat_map(move |snr_db| Setting::table_2(length, snr_db, HARMONICS))
    };
    let settings: Vec<Setting> = LENGTHS.into_iter().flat_map(of_length).collect();
    let seeded: Vec<(Setting, u64)> = settings
        .iter()
        .copied()
        .zip((0..).map(|number| number * SEEDS))
        .collect();
    let mut cells = measured("accuracy", &seeded, windows)?;
    let near: Vec<usize> = (0..cells.len())
        .filter(|number| cells[*number].is_near_the_bar())
        .collect();
    let again: Vec<(Setting, u64)> = near
        .iter()
        .map(|n| (seeded[*n].0, seeded[*n].1 + AGAIN_SEED))
        .collect();
    for (number, cell) in near
        .into_iter()
        .zip(measured("near the bar", &again, AGAIN * windows)?)
    {
        cells[number] = cell;
    }
    Ok(cells)
}

/// `windows` windows of each setting, from its seed on.
fn measured(what: &str, seeded: &[(Setting, u64)], windows: u32) -> Result<Vec<Cell>> {
    if seeded.is_empty() || windows == 0 {
        return Ok(Vec::new());
    }
    let of = |&(setting, seed): &(Setting, u64)| {
        (0..windows).map(move |run| (setting, seed + u64::from(run)))
    };
    let items: Vec<(Setting, u64)> = seeded.iter().flat_map(of).collect();
    let all = parallel::map(what, &items, |(setting, seed)| {
        samples(setting, *seed, &[Contender::whole(HARMONICS)])
    })?;
    let of_setting = all.chunks(windows as usize).zip(seeded);
    Ok(of_setting
        .map(|(samples, (setting, _))| Cell {
            setting: *setting,
            accuracy: Accuracy::new(&samples.concat()),
        })
        .collect())
}

fn noise(windows: u32) -> Result<Vec<Found>> {
    let (speed_mm_s, period_mm) = TABLE_2[0];
    let found_in = |length: Length| {
        let setting = Setting {
            speed_mm_s,
            period_mm,
            length,
            snr_db: PERCENT_SNR_DB,
            carried: HARMONICS,
        };
        // As long as the longest slide, that of the slowest line.
        let window_s = match length {
            Length::Seconds(window_s) => window_s,
            Length::Slide => setting.window(0)?.window_s(),
        };
        let seeds: Vec<u64> = (0..u64::from(windows))
            .map(|run| NOISE_SEED + run)
            .collect();
        let found = parallel::map("noise alone", &seeds, |seed| {
            let fit = fit(&setting.noise(window_s, *seed)?.values, HARMONICS, u16::MAX)?;
            Ok(fit.status.has_tone())
        })?;
        Ok(Found {
            length: Some(length),
            windows,
            found: found.into_iter().map(u32::from).sum(),
        })
    };
    LENGTHS.into_iter().map(found_in).collect()
}

fn detection(windows: Windows) -> Result<Found> {
    let setting = |(speed_mm_s, period_mm): (f64, f64)| {
        let length = Length::Seconds(DETECTION_CYCLES * period_mm / speed_mm_s);
        Setting {
            speed_mm_s,
            period_mm,
            length,
            snr_db: DETECTION_SNR_DB,
            carried: HARMONICS,
        }
    };
    let seeds = DETECTION_SEED..DETECTION_SEED + u64::from(windows.detection);
    let items: Vec<(Setting, u64)> = TABLE_2
        .into_iter()
        .map(setting)
        .flat_map(|setting| seeds.clone().map(move |seed| (setting, seed)))
        .collect();
    let found = parallel::map("detection", &items, |(setting, seed)| {
        let window = setting.window(*seed)?;
        let answer = Contender::whole(HARMONICS)
            .answer(&window)?
            .filter(|answer| !answer.ambiguous);
        Ok(answer
            .is_some_and(|answer| (answer.hz / window.frequency_hz - 1.0).abs() <= DETECTED_WITHIN))
    })?;
    Ok(Found {
        length: None,
        windows: items.len() as u32,
        found: found.into_iter().map(u32::from).sum(),
    })
}
