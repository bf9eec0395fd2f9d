//! What twelve bits cost: the STM32's own converter, behind amplifiers or bare, beside the ADS1258
//! in front of the same tones.
//!
//! The noise is the converters' own. An amplifier's noise and the converter's nonlinearity are not
//! in it.

use super::contender::fit;
use crate::page::{Table, figure, fixed, percent};
use crate::parallel;
use crate::simulated::{Simulated, converter_noise_v};
use anyhow::{Context, Result, ensure};
use hal_mock::{Amplifier, Scene, Sliding, SlidingScene, Stm32Adc};
use ridgetone_finger::converter::OnboardPlan;
use ridgetone_finger::converter::oversampled::{Buffer, Filled, HALF, Oversampler};
use ridgetone_proto::plan::Plan;
use ridgetone_tone::{Status, Values};
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicU16, Ordering::Relaxed};

/// Windows of each tone and converter, for the page.
pub const WINDOWS: u32 = 60;
/// A window, seconds.
const WINDOW_S: f64 = 1.0;
/// Inputs of the Nucleo, for all converters.
const INPUTS: u16 = Plan::ONBOARD.inputs;
const CHANNELS: usize = INPUTS.count_ones() as usize;
/// Mean square of the tones over all taxels is that of a sine of this rms, microvolts.
const TONES_UV: [f64; 4] = [1000.0, 100.0, 20.0, 5.0];
const SPEED_MM_S: f64 = 30.0;
const PERIOD_MM: f64 = 3.0;
const HARMONICS: u8 = 4;

/// A converter and what is before it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Converter {
    Ads1258,
    Own(Amplifier),
}

const CONVERTERS: [(&str, Converter); 3] = [
    ("ADS1258, `paper`", Converter::Ads1258),
    (
        "STM32's own, gain of 20",
        Converter::Own(Amplifier::Gain(20.0)),
    ),
    ("STM32's own, bare bridges", Converter::Own(Amplifier::Bare)),
];

/// A converter in front of a tone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub tone_uv: f64,
    pub converter: String,
    pub windows: u32,
    pub good: u32,
    /// Good ones that are off by more than five of their sigmas.
    pub wrong: u32,
    /// RMS error of the good ones, hertz.
    pub rms_hz: Option<f64>,
    /// Root of the mean square of their sigmas, hertz.
    pub sigma_hz: Option<f64>,
}

/// A scene with its tones made weaker; the levels stay.
struct Weak {
    scene: SlidingScene,
    levels_v: Vec<f64>,
    gain: f64,
    from_s: f64,
}

impl Scene for Weak {
    fn volts(&mut self, input: u8, t_s: f64) -> f64 {
        let level_v = self.levels_v[usize::from(input)];
        level_v + self.gain * (self.scene.volts(input, self.from_s + t_s) - level_v)
    }

    fn end_s(&self) -> f64 {
        self.scene.end_s() - self.from_s
    }
}

fn scene(snr_db: f64, seed: u64) -> Sliding {
    Sliding {
        speed_mm_s: SPEED_MM_S,
        period_mm: PERIOD_MM,
        slide_mm: SPEED_MM_S * (WINDOW_S + 1.0),
        snr_db: Some(snr_db),
        seed,
        ..Sliding::default()
    }
}

/// The window of a tone by the ADS1258.
fn by_ads1258(tone_uv: f64, seed: u64) -> Result<Simulated> {
    let noise_v = converter_noise_v(&Plan::PAPER);
    let snr_db = 20.0 * (1e-6 * tone_uv / noise_v).log10();
    Simulated::by_plan(&scene(snr_db, seed), WINDOW_S, &Plan::PAPER, noise_v)
}

/// The frames of that tone by the STM32's own converter.
fn by_own(tone_uv: f64, seed: u64, amplifier: Amplifier) -> Result<Vec<Values>> {
    // As strong as it is beside noise that is left out here.
    let strong = SlidingScene::new(scene(0.0, seed))?;
    let (levels_v, gain) = (levels_v(&strong), 1e-6 * tone_uv / strong.noise_v());
    let quiet = Sliding {
        snr_db: None,
        ..scene(0.0, seed)
    };
    let quiet = SlidingScene::new(quiet)?;
    let weak = Weak {
        from_s: quiet.truth().slide_start_s + 0.1 + 0.1 * (0.618 * seed as f64).fract(),
        scene: quiet,
        levels_v,
        gain,
    };
    let mut adc = Stm32Adc::new(Box::new(weak), amplifier, seed);
    let plan = OnboardPlan::of(&Plan::ONBOARD);
    let averaging = plan.averaging().context("it fits")?;
    let sample_s = 1.0 / (frame_rate_hz() * f64::from(plan.scans) * CHANNELS as f64);
    let oversampler = Oversampler::new();
    let buffer: Buffer = [const { AtomicU16::new(0) }; 2 * HALF];
    oversampler.begin(&averaging);
    let frames = (WINDOW_S * frame_rate_hz()).round() as usize;
    let mut values = Vec::with_capacity(frames);
    let mut at = 0_u32;
    while values.len() < frames {
        for place in &buffer[..averaging.half()] {
            let t_s = f64::from(at) * sample_s;
            place.store(adc.sample((at % CHANNELS as u32) as u8, t_s), Relaxed);
            at += 1;
        }
        if oversampler.take(&buffer, Filled::First, 0) {
            let code = |channel| oversampler.code(channel).map_or(0, |(code, _)| code);
            // Near zero, where a float holds every code.
            values.push(std::array::from_fn(|channel| {
                (code(channel) - 0x3c_0000) as f32
            }));
        }
    }
    Ok(values)
}

fn frame_rate_hz() -> f64 {
    Plan::ONBOARD.frame_rate_hz().into()
}

fn levels_v(scene: &SlidingScene) -> Vec<f64> {
    let channels = scene.channels().iter();
    channels.map(|channel| channel.offset_v).collect()
}

/// An answer: off by, and sigma, hertz, if it is good.
fn answer(converter: Converter, tone_uv: f64, seed: u64) -> Result<Option<[f64; 2]>> {
    let true_hz = SPEED_MM_S / PERIOD_MM;
    let (values, rate_hz) = match converter {
        Converter::Ads1258 => {
            let window = by_ads1258(tone_uv, seed)?;
            ensure!((window.frequency_hz / true_hz - 1.0).abs() < 1e-9);
            (window.values, window.frame_rate_hz)
        }
        Converter::Own(amplifier) => (by_own(tone_uv, seed, amplifier)?, frame_rate_hz()),
    };
    let fit = fit(&values, HARMONICS, INPUTS)?;
    let [hz, sigma_hz] = [fit.frequency, fit.sigma].map(|value| f64::from(value) * rate_hz);
    Ok((fit.status == Status::Good).then_some([hz - true_hz, sigma_hz]))
}

/// A cell of the table before it is measured: a tone, and a converter with its name.
#[derive(Clone, Copy, Debug)]
struct Cell {
    tone_uv: f64,
    name: &'static str,
    converter: Converter,
}

/// Measures all rows, `windows` windows each.
pub fn measure(windows: u32) -> Result<Vec<Row>> {
    let cells: Vec<Cell> = TONES_UV
        .into_iter()
        .flat_map(|tone_uv| {
            CONVERTERS.map(|(name, converter)| Cell {
                tone_uv,
                name,
                converter,
            })
        })
        .collect();
    let items: Vec<(Cell, u64)> = cells
        .iter()
        .flat_map(|cell| (0..windows).map(|seed| (*cell, 1 + u64::from(seed))))
        .collect();
    let answers = parallel::map("windows of converters", &items, |(cell, seed)| {
        answer(cell.converter, cell.tone_uv, *seed)
    })?;
    let answers = answers.chunks_exact(windows.max(1) as usize);
    let rows = cells.iter().zip(answers);
    Ok(rows.map(|(cell, answers)| row(cell, answers)).collect())
}

fn row(cell: &Cell, answers: &[Option<[f64; 2]>]) -> Row {
    let good: Vec<[f64; 2]> = answers.iter().flatten().copied().collect();
    let rms = |of: usize| {
        let squares: f64 = good.iter().map(|answer| answer[of].powi(2)).sum();
        (!good.is_empty()).then(|| (squares / good.len() as f64).sqrt())
    };
    let is_wrong = |[off_hz, sigma_hz]: &&[f64; 2]| off_hz.abs() > 5.0 * sigma_hz;
    Row {
        tone_uv: cell.tone_uv,
        converter: cell.name.to_owned(),
        windows: answers.len() as u32,
        good: good.len() as u32,
        wrong: good.iter().filter(is_wrong).count() as u32,
        rms_hz: rms(0),
        sigma_hz: rms(1),
    }
}

/// The table: a row for each tone.
pub fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "tone, uV rms|ADS1258: good, %|its RMS, mHz|gain of 20: good, %|its RMS, mHz|bare: good, %|its RMS, mHz",
    );
    for of_tone in rows.chunks_exact(CONVERTERS.len()) {
        let cells = of_tone.iter().flat_map(|row| {
            [
                percent(row.good, row.windows),
                figure(row.rms_hz.map(|hz| 1e3 * hz), 2),
            ]
        });
        let tone = of_tone.first().map(|row| row.tone_uv);
        table.row([fixed(tone, 0)].into_iter().chain(cells));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gain 20 makes up for the twelve bits; a bare bridge needs a tone some thirty times as strong.
    #[test]
    fn an_amplifier_makes_up_for_twelve_bits() {
        let sigma = |converter| {
            let answer = answer(converter, 1000.0, 1).unwrap();
            answer.expect("good")[1]
        };
        let [ads1258, gain, bare] = CONVERTERS.map(|(_, converter)| sigma(converter));
        assert!((0.5..2.0).contains(&(gain / ads1258)), "{gain} {ads1258}");
        assert!((15.0..60.0).contains(&(bare / ads1258)), "{bare} {ads1258}");
    }

    /// What the page says of all of them.
    #[test]
    fn no_window_of_the_page_is_good_and_wrong() {
        let trade = crate::trade::load(&crate::tests::from_root("docs/results")).unwrap();
        assert_eq!(trade.converters.len(), TONES_UV.len() * CONVERTERS.len());
        assert!(trade.converters.iter().all(|row| row.wrong == 0));
    }
}
