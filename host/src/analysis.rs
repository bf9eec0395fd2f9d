//! Analyses of raw frames that the board does not send: the spectrum of a window, and curves of the
//! reported tone over the same frames.

use crate::digits::seconds;
use crate::frame::Frame;
use crate::harmonics::{self, Frequencies, Harmonic, Harmonics, Reading, powers};
use crate::live::{Live, Strips};
use ridgetone_proto::plan::{Plan, Sampling};
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::Estimate;
use ridgetone_tone::{FRAMES_MAX, FRAMES_MIN};
use serde::Serialize;
use std::f64::consts::TAU;

/// Power of an empty bin in decibels: below the noise floor of 24 bits and 16 channels.
const DB_MIN: f32 = -120.0;

/// Half-width of the noise band around a line, cycles per window, as in the estimator
/// (`crates/tone/src/noise_bins.rs`).
pub const NEIGHBOURHOOD_CYCLES: f64 = 5.0;

/// Minimum number of points in a spectrum, so that its lines look smooth.
const POINTS_MIN: usize = 64;

/// Number of frequencies per bin that are tried in the search for the strongest line.
const BETWEEN_BINS: usize = 16;

/// Periodogram over all channels, after subtracting a straight line from each.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spectrum {
    /// Device time of the window's first and last frame, seconds.
    pub from_s: f64,
    pub until_s: f64,
    /// True for the window of the latest estimate, false for the latest frames.
    pub of_estimate: bool,
    /// Bin spacing in hertz; the first bin is at 0 Hz.
    pub bin_hz: f64,
    /// Fraction of the channels' power in each bin, in decibels: 0 if all power is in one line.
    pub power_db: Vec<f32>,
    /// Frequency of the strongest line, which may lie between bins, hertz.
    pub strongest_hz: Option<f64>,
    /// Harmonics of the reported tone, fundamental first; empty unless this is the window of an
    /// estimate with a tone.
    pub lines: Vec<HarmonicLine>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HarmonicLine {
    pub frequency_hz: f64,
    pub power_db: f32,
}

/// Spectrum of the residual, normalised like [`Spectrum`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResidualSpectrum {
    pub bin_hz: f64,
    pub power_db: Vec<f32>,
    /// Noise band around the fundamental, and the noise in it: the median of its bins.
    pub from_hz: f64,
    pub until_hz: f64,
    pub noise_db: f32,
}

/// Curves of the reported tone over those frames of its window that are still kept.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curves {
    /// Device time of each frame, seconds.
    pub t_s: Vec<f64>,
    /// Voltages of each taxel; `None` where they are missing or doubtful.
    pub read_v: Vec<Vec<Option<f32>>>,
    /// Offset and fundamental of each taxel in volts; `None` if the fit left it out.
    pub tone_v: Vec<Option<Vec<f32>>>,
    /// The whole fit of each taxel: baseline, all harmonics, interferer.
    pub fit_v: Vec<Option<Vec<f32>>>,
    /// Harmonics of each fitted taxel, the fundamental first.
    pub harmonics: Vec<Option<Vec<Harmonic>>>,
    /// RMS of the residual of each fitted taxel, volts.
    pub residual_v: Vec<Option<f32>>,
    pub residual_spectrum: Option<ResidualSpectrum>,
}

/// Returns the spectrum of the latest estimate's window if all its frames are kept, otherwise of
/// the latest frames; `None` with too few frames.
pub fn spectrum(live: &Live) -> Option<Spectrum> {
    let window = live
        .estimate()
        .and_then(|estimate| windowed(&live.strips, estimate))
        .filter(|found| found.is_whole);
    let of_estimate = window.is_some();
    let frames = window.map_or_else(|| latest(live), |window| window.frames);
    let (first, last) = (frames.first()?, frames.last()?);
    let slots = last.number.wrapping_sub(first.number).checked_add(1)?;
    if frames.len() < FRAMES_MIN as usize || slots as usize > FRAMES_MAX || last.t_s <= first.t_s {
        return None;
    }
    let rate_hz = f64::from(slots - 1) / (last.t_s - first.t_s);
    let lines_of = Periodogram::of(&frames, slots as usize);
    let points = (slots as usize).next_power_of_two().max(POINTS_MIN);
    let bin_hz = rate_hz / points as f64;
    let power_db = lines_of.power_db(points);
    let tone = live
        .estimate()
        .filter(|found| of_estimate && found.status.has_tone());
    let lines = tone.map_or_else(Vec::new, |tone| lines(tone, bin_hz, &power_db));
    Some(Spectrum {
        from_s: first.t_s,
        until_s: last.t_s,
        of_estimate,
        bin_hz,
        strongest_hz: lines_of
            .strongest_cycles(&power_db)
            .map(|cycles| cycles * rate_hz / f64::from(slots)),
        lines,
        power_db,
    })
}

/// Returns a tone's harmonics below half the frame rate, each with the power of its stronger
/// adjacent bin.
fn lines(tone: &Estimate, bin_hz: f64, power_db: &[f32]) -> Vec<HarmonicLine> {
    let line = |k: u8| {
        let frequency_hz = f64::from(k) * f64::from(tone.frequency);
        let below = (frequency_hz / bin_hz) as usize;
        let power_db = power_db.get(below)?.max(*power_db.get(below + 1)?);
        Some(HarmonicLine {
            frequency_hz,
            power_db,
        })
    };
    (1..=tone.harmonics).map_while(line).collect()
}

fn decibel(power: f32) -> f32 {
    (10.0 * power.log10()).max(DB_MIN)
}

/// Returns the spectrum of `volts` less the fit in `whole`, both by taxel, around the tone at
/// `frequency_hz`.
fn residual_spectrum(
    volts: &[Vec<Option<f32>>],
    whole: &[Option<Harmonics>],
    rate_hz: f64,
    frequency_hz: f64,
) -> Option<ResidualSpectrum> {
    let mut lines_of = Periodogram::default();
    for (volts, found) in volts.iter().zip(whole) {
        let Some(found) = found else { continue };
        let residual = volts.iter().zip(&found.fit_v);
        // Count missing values as zero.
        let residual = residual.map(|(v, fit)| v.map_or(0.0, |v| f64::from(v) - f64::from(*fit)));
        lines_of.add(harmonics::about_line(volts), residual.collect());
    }
    let frames = lines_of.frames()?;
    let points = frames.next_power_of_two().max(POINTS_MIN);
    let bin_hz = rate_hz / points as f64;
    let power_db = lines_of.power_db(points);
    let reach_hz = NEIGHBOURHOOD_CYCLES * rate_hz / frames as f64;
    let (from_hz, until_hz) = ((frequency_hz - reach_hz).max(0.0), frequency_hz + reach_hz);
    let bins = power_db
        .iter()
        .enumerate()
        .skip(1)
        .map(|(bin, db)| (bin as f64 * bin_hz, *db));
    let mut beside: Vec<f32> = bins
        .filter(|(hz, _)| (from_hz..=until_hz).contains(hz))
        .map(|(_, db)| db)
        .collect();
    beside.sort_by(f32::total_cmp);
    let noise_db = *beside.get(beside.len() / 2)?;
    Some(ResidualSpectrum {
        bin_hz,
        power_db,
        from_hz,
        until_hz,
        noise_db,
    })
}

/// Returns the latest estimate's tone over the frames of its window; `None` without a tone, or if
/// none of the frames is kept.
pub fn curves(live: &Live) -> Option<Curves> {
    let estimate = live.estimate()?;
    if !estimate.status.has_tone() {
        return None;
    }
    let Windowed {
        frames, centre_s, ..
    } = windowed(&live.strips, estimate)?;
    if frames.is_empty() {
        return None;
    }
    let plan = live.settings().plan;
    let after_s = |taxel: usize| slot_s(&plan, taxel);
    let curve = |taxel: usize| {
        let channel = estimate
            .channels
            .iter()
            .find(|channel| usize::from(channel.taxel) == taxel)?;
        let value = |frame: &Frame| {
            // The phases assume that all taxels are read at once; this taxel's slot is later.
            let t_s = frame.t_s + after_s(taxel) - centre_s;
            let wave = (TAU * f64::from(estimate.frequency) * t_s + f64::from(channel.phase_rad))
                .cos() as f32;
            channel.offset_v + channel.amplitude_v * wave
        };
        Some(frames.iter().map(value).collect())
    };
    let whole = |taxel: usize| -> Option<Harmonics> {
        estimate
            .channels
            .iter()
            .find(|channel| usize::from(channel.taxel) == taxel)?;
        let t_s: Vec<f64> = frames
            .iter()
            .map(|frame| frame.t_s + after_s(taxel) - centre_s)
            .collect();
        let volts: Vec<Option<f32>> = frames.iter().map(|frame| frame.volts[taxel]).collect();
        let interferer_hz = estimate.interferer_hz.map(f64::from);
        harmonics::fit(
            &t_s,
            &volts,
            estimate.frequency.into(),
            estimate.harmonics,
            interferer_hz,
        )
    };
    let whole: Vec<Option<Harmonics>> = (0..TAXELS).map(whole).collect();
    let read_v: Vec<Vec<Option<f32>>> = (0..TAXELS)
        .map(|taxel| frames.iter().map(|frame| frame.volts[taxel]).collect())
        .collect();
    let (first, last) = (frames.first()?, frames.last()?);
    let rate_hz = (frames.len() - 1) as f64 / (last.t_s - first.t_s).max(f64::MIN_POSITIVE);
    Some(Curves {
        residual_spectrum: residual_spectrum(&read_v, &whole, rate_hz, estimate.frequency.into()),
        residual_v: whole
            .iter()
            .map(|found| found.as_ref().map(|found| found.residual_v))
            .collect(),
        harmonics: whole
            .iter()
            .map(|found| found.as_ref().map(|found| found.harmonics.clone()))
            .collect(),
        fit_v: whole
            .into_iter()
            .map(|found| found.map(|found| found.fit_v))
            .collect(),
        t_s: frames.iter().map(|frame| frame.t_s).collect(),
        read_v,
        tone_v: (0..TAXELS).map(curve).collect(),
    })
}

/// Returns the time from a frame's first conversion to that of a taxel, seconds.
fn slot_s(plan: &Plan, taxel: usize) -> f64 {
    if plan.sampling == Sampling::AtOnce {
        return 0.0;
    }
    let before = (0..taxel)
        .filter(|other| plan.inputs >> other & 1 != 0)
        .count();
    before as f64 * f64::from(plan.conversion_ns()) * 1e-9
}

/// Frames of an estimate's window.
struct Windowed {
    /// Frames of the window that are still kept.
    frames: Vec<Frame>,
    /// Midpoint between the window's first and last frame, seconds.
    centre_s: f64,
    /// True if the window's first and last frames are kept.
    is_whole: bool,
}

fn windowed(strips: &Strips, estimate: &Estimate) -> Option<Windowed> {
    let (oldest, newest) = (strips.iter().next()?, strips.iter().next_back()?);
    let frame_s =
        (newest.t_s - oldest.t_s) / f64::from(newest.number.wrapping_sub(oldest.number).max(1));
    // A window is one frame longer than the time from its first stamp to its last.
    let end_s = seconds(estimate.t_us);
    let start_s = end_s - f64::from(estimate.window_s) + frame_s;
    let slack_s = 0.5 * frame_s;
    let inside = |frame: &&Frame| frame.t_s > start_s - slack_s && frame.t_s < end_s + slack_s;
    Some(Windowed {
        frames: strips.iter().filter(inside).copied().collect(),
        centre_s: 0.5 * (start_s + end_s),
        is_whole: oldest.t_s < start_s + slack_s && newest.t_s > end_s - slack_s,
    })
}

/// Returns the latest frames, as many as fit in a window.
fn latest(live: &Live) -> Vec<Frame> {
    let wanted = (live.settings().window_s * nominal_hz(live)).round() as usize;
    let frames = live.strips.iter();
    let skipped = frames.len().saturating_sub(wanted);
    frames.skip(skipped).copied().collect()
}

fn nominal_hz(live: &Live) -> f32 {
    live.hello()
        .map_or(ridgetone_proto::settings::FRAME_RATE_HZ, |hello| {
            hello.frame_rate_hz
        })
}

/// Channels of a window. A channel's power in a line counts as a fraction of its total power.
#[derive(Default)]
struct Periodogram {
    channels: Vec<Shares>,
}

/// A channel, and the sum of squares to which its lines are normalised.
struct Shares {
    squares: f64,
    values: Vec<f64>,
}

impl Periodogram {
    /// Makes the periodogram of frames after subtracting straight lines; a missing value counts as
    /// zero.
    fn of(frames: &[Frame], slots: usize) -> Self {
        let mut lines_of = Self::default();
        for taxel in 0..TAXELS {
            let mut volts = vec![None; slots];
            for frame in frames {
                let at = frame.number.wrapping_sub(frames[0].number) as usize;
                if let Some(place) = volts.get_mut(at) {
                    *place = frame.volts[taxel];
                }
            }
            let (line, squares) = harmonics::straight_line(&volts);
            let values = volts.iter().enumerate().map(|(at, volts)| {
                volts.map_or(0.0, |volts| {
                    f64::from(volts) - line[0] - line[1] * at as f64
                })
            });
            lines_of.add(squares, values.collect());
        }
        lines_of
    }

    /// Adds a channel, unless it has no power.
    fn add(&mut self, squares: f64, values: Vec<f64>) {
        if squares > 0.0 && squares.is_finite() {
            self.channels.push(Shares { squares, values });
        }
    }

    fn frames(&self) -> Option<usize> {
        self.channels.first().map(|channel| channel.values.len())
    }

    /// Returns the fraction of the channels' power in the line at each frequency (cycles per
    /// window).
    fn powers(&self, frequencies: Frequencies) -> Vec<f64> {
        let mut mean = vec![0.0; frequencies.count];
        for Shares { squares, values } in &self.channels {
            let readings = values.iter().enumerate().map(|(row, value)| Reading {
                at: row as f64 / values.len() as f64,
                value: *value,
            });
            let scale = 0.5 * squares * (values.len() * self.channels.len()) as f64;
            for (mean, power) in mean.iter_mut().zip(powers(readings, frequencies)) {
                *mean += power / scale;
            }
        }
        mean
    }

    fn cycles(&self, bin: f64, points: usize) -> f64 {
        bin * self.frames().unwrap_or(0) as f64 / points as f64
    }

    /// Returns the powers of bins spaced by 1 / `points` of the frame rate, decibels.
    fn power_db(&self, points: usize) -> Vec<f32> {
        let frequencies = Frequencies {
            first: 0.0,
            step: self.cycles(1.0, points),
            count: points / 2,
        };
        let powers = self.powers(frequencies).into_iter();
        powers.map(|power| decibel(power as f32)).collect()
    }

    /// Searches for the strongest line of at least two cycles near the strongest bin of
    /// [`Self::power_db`].
    fn strongest_cycles(&self, power_db: &[f32]) -> Option<f64> {
        let points = 2 * power_db.len();
        let bins = power_db
            .iter()
            .enumerate()
            .map(|(bin, db)| (self.cycles(bin as f64, points), *db));
        let (cycles, _) = bins
            .filter(|(cycles, _)| *cycles >= 2.0)
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        let step = self.cycles(1.0, points) / BETWEEN_BINS as f64;
        let beside = Frequencies {
            first: cycles - BETWEEN_BINS as f64 * step,
            step,
            count: 2 * BETWEEN_BINS + 1,
        };
        let powers = self.powers(beside).into_iter().enumerate();
        let (strongest, _) = powers.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(beside.first + strongest as f64 * step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ads1258::Channel;
    use ridgetone_finger::converter::Ads1258Plan;

    fn of(inputs: u16, own: Ads1258Plan) -> Plan {
        Ads1258Plan { inputs, ..own }.plan()
    }

    #[test]
    fn inputs_that_are_sampled_at_once_are_not_late() {
        let plan = Plan::of_frames(1000.0, 3).unwrap();
        assert_eq!([0, 1, 2].map(|taxel| slot_s(&plan, taxel)), [0.0; 3]);
    }

    /// Asserts that a taxel's delay is that of its slot in the scan, as the driver orders it.
    #[test]
    fn a_taxel_is_as_late_as_its_conversion() {
        for plan in [
            Plan::PAPER,
            Plan::HAND,
            of(0x5555, Ads1258Plan::HAND),
            of(0x8001, Ads1258Plan::PAPER),
        ] {
            let inputs =
                Ads1258Plan::of(&plan)
                    .config()
                    .scan()
                    .filter_map(|channel| match channel {
                        Channel::Single(input) => Some(usize::from(input)),
                        _ => None,
                    });
            for (slot, taxel) in (0u32..).zip(inputs) {
                let expected_s = f64::from(slot * plan.conversion_ns()) * 1e-9;
                assert_eq!(slot_s(&plan, taxel), expected_s, "{plan:?}, {taxel}");
            }
        }
    }
}
