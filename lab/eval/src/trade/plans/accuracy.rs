//! Errors of a plan's windows, in the same scene for all plans.

use super::Choice;
use crate::accuracy::{Accuracy, Sample};
use crate::bound::Clue;
use crate::parallel;
use crate::simulated::{Simulated, converter_noise_v};
use crate::trade::contender::{answer, fit};
use anyhow::Result;
use hal_mock::Sliding;
use ridgetone_proto::plan::Plan;

/// The tone over the noise of a conversion at the fastest data rate, decibels: its mean square over
/// all sixteen taxels is that of a sine of 0.17 mV.
const SNR_DB: f64 = 20.0;

/// Tones, hertz: two cycles in the shortest window, and below what the slowest plan can follow.
pub const TONES_HZ: [f64; 4] = [70.0, 80.0, 90.0, 100.0];

/// From one choice's seeds to the next one's.
const SEEDS: u64 = 1_000_000;

/// The scene of a tone, long enough for a slide of `slide_s` seconds. Its noise is as far below the
/// tone as a plan's converter makes it.
pub fn scene(plan: &Plan, tone_hz: f64, slide_s: f64, seed: u64) -> Sliding {
    let snr_db = SNR_DB + 20.0 * (converter_noise_v(&Plan::HAND) / converter_noise_v(plan)).log10();
    Sliding {
        speed_mm_s: tone_hz,
        period_mm: 1.0,
        slide_mm: tone_hz * slide_s,
        snr_db: Some(snr_db),
        overtones: [0.0; 3],
        seed,
        ..Sliding::default()
    }
}

/// A window, and the bound of the channels that its plan converts.
pub fn window(choice: Choice, tone_hz: f64, seed: u64) -> Result<(Simulated, Clue)> {
    let Choice { plan, window_s } = choice;
    let scene = scene(&plan, tone_hz, window_s + 1.0, seed);
    let window = Simulated::by_plan(&scene, window_s, &plan, converter_noise_v(&plan))?;
    // The estimator fits a slope.
    let clues = window.clues(true, 1)?;
    let own: Vec<Clue> = clues
        .into_iter()
        .zip(0..)
        .filter(|(_, taxel)| plan.inputs >> taxel & 1 == 1)
        .map(|(clue, _)| clue)
        .collect();
    Ok((window, Clue::sum(&own)))
}

fn sample(choice: Choice, tone_hz: f64, seed: u64) -> Result<Sample> {
    let (window, clue) = window(choice, tone_hz, seed)?;
    let fit = fit(&window.values, choice.settings().harmonics, window.inputs)?;
    Ok(Sample {
        true_hz: window.frequency_hz,
        bound_hz: clue.sigma_hz(),
        luck_hz: clue.error_hz(),
        answer: answer(&fit, window.frame_rate_hz),
    })
}

/// The accuracy of each choice, with `windows` windows of each tone.
pub fn measure(choices: &[Choice], windows: u32) -> Result<Vec<Accuracy>> {
    let items: Vec<(usize, f64, u64)> = (0..choices.len())
        .flat_map(|at| {
            TONES_HZ
                .into_iter()
                .zip(0..)
                .map(move |(tone_hz, tone)| (at, tone_hz, tone))
        })
        .flat_map(|(at, tone_hz, tone)| {
            let first = SEEDS * (at as u64 + 1) + u64::from(windows) * tone;
            (first..first + u64::from(windows)).map(move |seed| (at, tone_hz, seed))
        })
        .collect();
    let samples = parallel::map("windows of plans", &items, |(at, tone_hz, seed)| {
        sample(choices[*at], *tone_hz, *seed)
    })?;
    let each = TONES_HZ.len() * windows as usize;
    Ok(samples
        .chunks_exact(each.max(1))
        .map(Accuracy::new)
        .collect())
}
