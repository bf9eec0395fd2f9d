//! Which runs the paper shows, and what of them.

use super::estimate::{Cut, least_squares_hz, periodogram, sine};
use super::paper::{FIGURE_5_S, RUNS, series};
use super::repeatability::correlation;
use super::results::{Contact, Curve, Opposite, Overlay, Pictures, Spectrum};
use super::taken::Taken;
use crate::baselines::Scratch;
use hal_mock::TABLE_2;

/// Data series of Figure 3.
const FIGURE_3: [usize; 2] = [12, 16];
/// Of Figures 4 and 5: the paper does not say which. Lines 0.5 Hz apart mean 30 mm/s, and 1.4 Hz
/// between the nominal frequencies of the two the gratings of 3.6 and 3.1 mm.
const FIGURES_4_5: [usize; 2] = [5, 21];
/// Of Figure 6.
const FIGURE_6: usize = 20;
/// Of Figure 10: piezoresistors 1 and 3 of unit 1.
const FIGURE_10: (usize, [usize; 2]) = (1, [0, 2]);
/// Piezoresistor 1 of units 1 and 2.
const PAIR: [usize; 2] = [0, 4];
/// Into the slide where Figure 5's window begins, seconds.
const WINDOW_AT_S: f64 = 0.5;

/// Adds those of another run.
pub fn add(all: &mut Pictures, more: &Pictures) {
    all.contacts.extend(more.contacts.iter().cloned());
    all.spectra.extend(more.spectra.iter().cloned());
    all.overlay = all.overlay.take().or_else(|| more.overlay.clone());
    all.opposite = all.opposite.take().or_else(|| more.opposite.clone());
}

/// The pictures of a run, by combination and run from 0 on. Of `runs` runs the last stands for
/// those not taken.
pub fn of_run((c, run): (usize, u32), runs: u32, taken: &Taken, cut: &Cut) -> Pictures {
    let number = series(c, run);
    let is = |wanted: usize| {
        let of_combination = (wanted - 1) % RUNS as usize;
        wanted - of_combination + of_combination.min(runs as usize - 1) == number
    };
    let mut pictures = Pictures::default();
    if FIGURE_3.into_iter().any(is) {
        pictures.contacts.push(contact(number, taken, cut));
    }
    for (figure, _) in FIGURES_4_5
        .into_iter()
        .enumerate()
        .filter(|(_, wanted)| is(*wanted))
    {
        pictures
            .spectra
            .push(spectrum((c, number), figure == 1, taken, cut));
    }
    if is(FIGURE_6) {
        pictures.overlay = overlay(number, taken, cut);
    }
    if is(FIGURE_10.0) {
        pictures.opposite = opposite(number, taken, cut);
    }
    pictures
}

fn contact(series: usize, taken: &Taken, cut: &Cut) -> Contact {
    let truth = taken.truth;
    Contact {
        series,
        taxels: PAIR,
        curves: PAIR.map(|taxel| Curve::new(taken.volts(taxel))),
        spike_s: cut.spike_s,
        cut_s: cut.slide_s,
        slide_s: (truth.slide_start_s, truth.slide_end_s),
        found_s: taken.longest_slide_s(),
    }
}

/// Of the whole cut for Figure 4, of a short window for Figure 5.
fn spectrum((c, series): (usize, usize), short: bool, taken: &Taken, cut: &Cut) -> Spectrum {
    let taxel = PAIR[0];
    let frames = if !short {
        cut.frames.clone()
    } else {
        let first = taken.frame_at(taxel, cut.slide_s.0 + WINDOW_AT_S);
        first..first + (FIGURE_5_S * taken.rate_hz).round() as usize
    };
    let (speed_mm_s, period_mm) = TABLE_2[c];
    Spectrum {
        series,
        taxel,
        curve: Curve::new(taken.part(taxel, &frames)),
        nominal_hz: speed_mm_s / period_mm,
        line_hz: taken.rate_hz / frames.len() as f64,
        mv: periodogram(&taken.samples(taxel, &frames))
            .iter()
            .map(|power| (1e6 * power.sqrt()).round() / 1e3)
            .collect(),
    }
}

fn overlay(series: usize, taken: &Taken, cut: &Cut) -> Option<Overlay> {
    let hz = least_squares_hz(taken, PAIR, &cut.frames, &mut Box::new(Scratch::EMPTY))?;
    let parts = PAIR.map(|taxel| taken.part(taxel, &cut.frames));
    let sines_mv = parts.map(|part| sine(part, hz).map(|volts| 1e3 * volts));
    Some(Overlay {
        series,
        taxels: PAIR,
        curves: parts.map(Curve::new),
        hz,
        sines_mv,
    })
}

fn opposite(series: usize, taken: &Taken, cut: &Cut) -> Option<Opposite> {
    let (_, taxels) = FIGURE_10;
    let curves = taxels.map(|taxel| Curve::new(taken.part(taxel, &cut.frames)));
    let volts = taxels.map(|taxel| taken.samples(taxel, &cut.frames));
    Some(Opposite {
        series,
        taxels,
        curves,
        correlation: correlation(&volts, 0)?,
    })
}
