//! A scan of a scale: how far off are the paper's method and the firmware.

use super::errors::{Bound, Errors, fft};
use super::motion::Motion;
use super::paper::{ACCURACY, LONGEST_S, WINDOW_S};
use super::run::{FELT_LATE_S, Slid, settings};
use super::skin::Skin;
use anyhow::Result;
use ridgetone_proto::telemetry::{Span, Status};

/// A scan of a scale.
#[derive(Clone, Debug)]
pub struct Scan {
    pub wavelength_mm: f64,
    pub motion: Motion,
    pub skin: Skin,
    /// Whether it holds the windows in which the finger turns, or the others.
    pub is_turning: bool,
    /// By the paper's method, by the firmware, or the fit by position, in its window, and in a window by accuracy.
    pub fft: Option<f64>,
    pub short: Errors,
    pub long: Errors,
    /// Mean square of the fundamental's amplitude over the channels, mV^2; none without a tone.
    pub power_mv2: Option<f64>,
}

/// Slides once; of a hand gives the windows in which it turns apart.
pub fn scan(wavelength_mm: f64, motion: Motion, skin: Skin) -> Result<Vec<Scan>> {
    let slid = Slid::new(wavelength_mm, motion, skin)?;
    let bound = Bound::new(&slid)?;
    let short = slid.answers(settings(skin, WINDOW_S, 0.0), FELT_LATE_S)?;
    // A fit by position has no part for the tolerance of the low-pass in its sigma, as the chip had:
    // half the sigma is asked for.
    let accuracy = match motion {
        Motion::Hand => 0.5 * ACCURACY,
        Motion::Steady(_) => ACCURACY,
    };
    let long = slid.answers(settings(skin, LONGEST_S, accuracy), FELT_LATE_S)?;
    let of_slide = short
        .iter()
        .find(|answer| answer.span == Span::Slide && answer.status == Status::Good);
    let power_mv2 = of_slide.map(|answer| 1e6 * answer.square_v2);
    let of = |is_turning: bool| Scan {
        wavelength_mm,
        motion,
        skin,
        is_turning,
        fft: fft(&slid).filter(|_| !is_turning),
        short: Errors::new(&slid, &short, &bound, is_turning),
        long: Errors::new(&slid, &long, &bound, is_turning),
        power_mv2,
    };
    let both = [false, true]
        .into_iter()
        .filter(|is_turning| !is_turning || motion == Motion::Hand);
    Ok(both.map(of).collect())
}
