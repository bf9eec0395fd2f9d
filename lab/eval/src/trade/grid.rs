//! The trade: accuracy by window, channels and harmonics, beside other methods on the same windows.

use super::contender::{Contender, samples};
use super::results::{NLS, RIDGETONE, Row};
use crate::accuracy::{Accuracy, Sample};
use crate::baselines::Method;
use crate::parallel;
use crate::setting::{Length, Setting};
use anyhow::Result;
use ridgetone_proto::settings::TAXELS;

/// The opponent, which is slow, gets every tenth window.
const SLOW_EVERY: u64 = 10;
/// Seeds of a window's and scene's windows begin at multiples of this.
const SEEDS: u64 = 10_000_000;

/// Lengths of windows, seconds: from the shortest of the bars to the longest setting.
pub const WINDOWS_S: [f64; 6] = [0.2, 0.3, 0.4, 0.6, 1.0, 3.9];
const CHANNELS: [u8; 4] = [1, 2, 4, 16];
/// Harmonics of a scene, and most of a fit, the fundamental included.
pub const HARMONICS: [u8; 4] = [1, 2, 3, 4];
/// Harmonics of the other methods' scenes: the tone alone, which all of them assume, and those of a
/// grating.
const CARRIED: [u8; 2] = [1, 4];
/// Noise, decibels below the tone.
const SNR_DB: f64 = 20.0;

/// Whether a fit of up to `harmonics` harmonics is measured in a scene of `carried`: as many as
/// there are, with any number of channels; what fewer do to a scene like a grating's, and what the
/// default does to a pure tone, with all.
fn is_measured(carried: u8, harmonics: u8, channels: u8) -> bool {
    let [fewest, .., most] = HARMONICS;
    let all = usize::from(channels) == TAXELS;
    carried == harmonics || all && (carried == most || carried == fewest && harmonics == most)
}

/// The estimators for scenes of `carried` harmonics.
fn contenders(carried: u8) -> Vec<Contender> {
    let fits = HARMONICS
        .into_iter()
        .flat_map(|harmonics| CHANNELS.map(|channels| (harmonics, channels)));
    let mut all: Vec<Contender> = fits
        .filter(|(harmonics, channels)| is_measured(carried, *harmonics, *channels))
        .map(|(harmonics, channels)| Contender::Ridgetone {
            harmonics,
            channels,
        })
        .collect();
    if CARRIED.contains(&carried) {
        all.extend(Method::ALL.map(|method| Contender::Baseline {
            method,
            channels: method.channels_max() as u8,
        }));
        all.push(Contender::Nls { harmonics: carried });
    }
    all
}

/// Measures all rows, `windows` of each line of Table 2.
pub fn measure(windows: u32) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (window_s, number) in WINDOWS_S.into_iter().zip(0..) {
        for carried in HARMONICS {
            rows.extend(of_scene(
                window_s,
                carried,
                windows,
                SEEDS * (10 * number + u64::from(carried)),
            )?);
        }
    }
    Ok(rows)
}

fn of_scene(window_s: f64, carried: u8, windows: u32, seed: u64) -> Result<Vec<Row>> {
    let contenders = contenders(carried);
    let quick: Vec<Contender> = contenders
        .iter()
        .filter(|contender| !matches!(contender, Contender::Nls { .. }))
        .copied()
        .collect();
    let settings = Setting::table_2(Length::Seconds(window_s), SNR_DB, carried);
    let runs = 0..u64::from(windows);
    let items: Vec<(Setting, u64)> = settings
        .flat_map(|setting| runs.clone().map(move |run| (setting, run)))
        .collect();
    let what = format!("trade, {window_s} s, {carried} harmonics");
    let all = parallel::map(&what, &items, |(setting, run)| {
        let who = if run % SLOW_EVERY == 0 {
            &contenders
        } else {
            &quick
        };
        Ok(who
            .iter()
            .copied()
            .zip(samples(setting, seed + run, who)?)
            .collect::<Vec<_>>())
    })?;
    let row = |contender: &Contender| {
        let own = all.iter().flatten().filter(|(who, _)| who == contender);
        let own: Vec<Sample> = own.map(|(_, sample)| *sample).collect();
        let (method, harmonics, channels) = match *contender {
            Contender::Ridgetone {
                harmonics,
                channels,
            } => (RIDGETONE, harmonics, channels),
            Contender::Nls { harmonics } => (NLS, harmonics, TAXELS as u8),
            Contender::Baseline { method, channels } => (method.name(), 1, channels),
        };
        Row {
            method: method.into(),
            window_s,
            frames: (window_s * ridgetone_host::input::frame_rate_hz()).round() as u32,
            carried,
            harmonics,
            channels,
            accuracy: Accuracy::new(&own),
            instructions: None,
        }
    };
    Ok(contenders.iter().map(row).collect())
}
