//! The board's event `feel`: its view, and its words.

use super::coefficients::NAMES;
use super::words::{OUTSIDE_SCALE, absent, is_outside_scale, needs};
use crate::digits::{plus_minus, seconds};
use crate::events::view;
use crate::names::name;
use ridgetone_feel::{Indices, PAPER_WINDOW_S, ROUGH, Receptor, SOFT, Score, band_hz};
use ridgetone_proto::telemetry::{Feel, Measured, NO_LEVEL, RECEPTORS};

/// The scores of the board.
const SCORES: [(&str, Score); 2] = [("soft", SOFT), ("rough", ROUGH)];

impl From<&Feel> for view::Feel {
    fn from(feel: &Feel) -> Self {
        let value = |found: Option<Measured>| found.map(|found| found.value);
        let sigma = |found: Option<Measured>| found.map(|found| found.sigma);
        let receptor = |kind: Receptor| {
            let per_hz = feel.per_hz[kind as usize];
            view::Receptor {
                receptor: NAMES[kind as usize],
                intensity: value(per_hz).map(|per_hz| per_hz * PAPER_WINDOW_S),
                intensity_sigma: sigma(per_hz).map(|per_hz| per_hz * PAPER_WINDOW_S),
                intensity_per_hz: value(per_hz),
                intensity_per_hz_sigma: sigma(per_hz),
                absent: why(feel, kind),
            }
        };
        Self {
            t_s: seconds(feel.t_us),
            window_s: feel.window_s,
            rate_hz: feel.rate_hz,
            taxels: feel.taxels,
            faults: feel.faults,
            m: value(feel.force_ratio),
            m_sigma: sigma(feel.force_ratio),
            receptors: Receptor::ALL.map(receptor),
            scores: scores(feel).map(|(name, found, absent)| view::Score {
                name: name.to_owned(),
                score: value(found),
                score_sigma: sigma(found),
                outside_scale: is_outside_scale(value(found)),
                absent,
            }),
            spectrum: levels(feel)
                .map(|(hz, level_db)| view::Level { hz, level_db })
                .collect(),
        }
    }
}

/// Middles and levels of the bands that have a line, hertz and decibels over one micrometre from
/// peak to peak.
pub fn levels(feel: &Feel) -> impl Iterator<Item = (f32, i8)> {
    let known = feel
        .levels_db
        .into_iter()
        .enumerate()
        .filter(|(_, level_db)| *level_db != NO_LEVEL);
    known.map(|(band, level_db)| (band_hz(band), level_db))
}

/// Why a receptor has no intensity.
fn why(feel: &Feel, receptor: Receptor) -> Option<String> {
    absent(
        receptor,
        feel.rate_hz.into(),
        feel.window_s.into(),
        bins(feel),
    )
}

/// Bins of the event's transform.
fn bins(feel: &Feel) -> usize {
    (f64::from(feel.rate_hz) * f64::from(feel.window_s) / 2.0).round() as usize
}

/// The scores, each with why it is absent.
fn scores(feel: &Feel) -> [(&'static str, Option<Measured>, Option<String>); 2] {
    let [fa1, fa2, sa1, sa2] = feel.per_hz.map(|found| found.map(|found| found.value));
    let values = [
        fa1,
        fa2,
        sa1,
        sa2,
        feel.force_ratio.map(|ratio| ratio.value),
    ];
    let indices = Indices {
        values,
        covariance: Default::default(),
    };
    let [soft, rough] = SCORES;
    let of = |(name, score): (&'static str, Score), found| (name, found, needs(&score, &indices));
    [of(soft, feel.soft), of(rough, feel.rough)]
}

/// An intensity a hertz, or a score.
pub struct Reading {
    pub name: &'static str,
    pub found: Option<Measured>,
}

/// What the receptors do, in the order of [`Receptor::ALL`].
pub fn receptors(feel: &Feel) -> [Reading; RECEPTORS] {
    Receptor::ALL.map(|receptor| Reading {
        name: receptor.name(),
        found: feel.per_hz[receptor as usize],
    })
}

/// What people would say, from 1 to 7.
pub fn ratings(feel: &Feel) -> [Reading; 2] {
    scores(feel).map(|(name, found, _)| Reading { name, found })
}

/// The event in words.
pub fn words(feel: &Feel) -> String {
    let word = |Reading { name, found, .. }: Reading| match found {
        Some(Measured { value, sigma }) => {
            format!("{name} {}", plus_minus(value.into(), sigma.into()))
        }
        None => format!("{name} -"),
    };
    let mut out = format!(
        "{:.3} s at {:.0} Hz  {} a hertz; {}; {} taxels",
        feel.window_s,
        feel.rate_hz,
        receptors(feel).map(word).join(", "),
        ratings(feel).map(word).join(", "),
        feel.taxels.count_ones()
    );
    if let Some(why) = Receptor::ALL
        .into_iter()
        .find_map(|receptor| why(feel, receptor))
    {
        out += &format!("; {why}");
    }
    let outside = ratings(feel)
        .into_iter()
        .filter(|rating| is_outside_scale(rating.found.map(|found| found.value)));
    let outside: Vec<_> = outside.map(|rating| rating.name).collect();
    if !outside.is_empty() {
        out += &format!("; {} {OUTSIDE_SCALE}", outside.join(" and "));
    }
    if !feel.faults.is_none() {
        let names: Vec<_> = feel.faults.iter().map(name).collect();
        out += &format!(", faults: {}", names.join(", "));
    }
    out
}
