//! The estimators: Ridgetone's own fit, and the baselines.

use crate::accuracy::{Answer, Sample};
use crate::baselines::{Method, Scratch, nls};
use crate::bound::Clue;
use crate::setting::Setting;
use crate::simulated::Simulated;
use anyhow::{Context, Result};
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::{Fit, Fitter, FrameSpan, Scene, Status, Table, Values};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contender {
    /// Ridgetone's fit of the first `channels` channels with up to `harmonics` harmonics.
    Ridgetone { harmonics: u8, channels: u8 },
    /// The opponent on all channels, with up to `harmonics` harmonics.
    Nls { harmonics: u8 },
    /// Another method on the first `channels` channels.
    Baseline { method: Method, channels: u8 },
}

impl Contender {
    pub fn answer(&self, window: &Simulated) -> Result<Option<Answer>> {
        match *self {
            Self::Ridgetone {
                harmonics,
                channels,
            } => Ok(answer(
                &fit(&window.values, harmonics, first(channels))?,
                window.frame_rate_hz,
            )),
            Self::Nls { harmonics } => {
                let estimate = nls::estimate(&window.values, TAXELS, harmonics.into(), None);
                let to_hz = |per_frame: f64| per_frame * window.frame_rate_hz;
                Ok(estimate.map(|estimate| Answer {
                    hz: to_hz(estimate.frequency),
                    sigma_hz: Some(to_hz(estimate.sigma)),
                    ambiguous: false,
                }))
            }
            Self::Baseline { method, channels } => {
                let estimate = method.estimate(
                    &window.values,
                    channels.into(),
                    &mut Box::new(Scratch::EMPTY),
                );
                let hz = estimate.map(|frequency| f64::from(frequency) * window.frame_rate_hz);
                Ok(hz.map(|hz| Answer {
                    hz,
                    sigma_hz: None,
                    ambiguous: false,
                }))
            }
        }
    }

    /// Channels of the bound that it is compared with: those it may use; for a baseline all.
    fn channels(&self) -> usize {
        match *self {
            Self::Ridgetone { channels, .. } => channels.into(),
            Self::Nls { .. } | Self::Baseline { .. } => TAXELS,
        }
    }
}

/// The answer of a fit.
pub fn answer(fit: &Fit, frame_rate_hz: f64) -> Option<Answer> {
    let to_hz = |per_frame: f32| f64::from(per_frame) * frame_rate_hz;
    let (hz, sigma_hz) = (to_hz(fit.frequency), Some(to_hz(fit.sigma)));
    fit.status.has_tone().then_some(Answer {
        hz,
        sigma_hz,
        ambiguous: fit.status != Status::Good,
    })
}

/// The mask of the first `channels` taxels: bit k is taxel k.
pub fn first(channels: u8) -> u16 {
    u16::MAX >> (u16::BITS - u32::from(channels))
}

/// Ridgetone's fit of a window's frames, of the taxels in `inputs`.
pub fn fit(values: &[Values], harmonics: u8, inputs: u16) -> Result<Fit> {
    fit_scene(values, &Scene::with_harmonics(harmonics), inputs)
}

/// Ridgetone's fit in any scene.
pub fn fit_scene(values: &[Values], scene: &Scene, inputs: u16) -> Result<Fit> {
    let valid = vec![inputs; values.len()];
    let mut table = Table {
        values,
        valid: &valid,
    };
    let mut fitter = Box::new(Fitter::new());
    let fit = fitter.fit(
        &mut FrameSpan::new(&mut table, 0, valid.len() as u32).with_quantization(1.0),
        scene,
    );
    fit.context("a table loses no frames")
}

/// One window for all contenders.
pub fn samples(setting: &Setting, seed: u64, contenders: &[Contender]) -> Result<Vec<Sample>> {
    let window = setting.window(seed)?;
    let clues = window.clues(setting.slope(), setting.carried.into())?;
    let sample = |contender: &Contender| {
        let clue = Clue::sum(&clues[..contender.channels()]);
        Ok(Sample {
            true_hz: window.frequency_hz,
            bound_hz: clue.sigma_hz(),
            luck_hz: clue.error_hz(),
            answer: contender.answer(&window)?,
        })
    };
    contenders.iter().map(sample).collect()
}
