//! The wavelengths of another paper: gratings of 0.5 to 3 mm under a hand's speeds, by its spectrum of 32 ms and by the firmware.
//!
//! Okamoto et al., "Transmission of Tactile Roughness through Master-slave Systems", section IV: Figures 8 (constant speeds), 9 (a
//! hand to and fro), 10 and 11 (power over the speed and over the wavelength). The finger is ours, and so is its skin.

use crate::page::{Table, figure, filled, table_of};
use crate::parallel;
use anyhow::{Context, Result};
use hal_mock::{Sliding, sliding::Hand};
use nalgebra::{DMatrix, DVector};
use ridgetone::frame::TimedConversion;
use ridgetone::surface::profile::Profile;
use ridgetone_host::input::{Input, Source};
use ridgetone_host::output;
use ridgetone_host::replay::{self, START_US};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::profile::{After, KNOTS_MAX, Knot};
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Estimate, Event, Packet, Span, Status};
use std::f64::consts::TAU;
use std::fs;
use std::ops::RangeInclusive;
use std::path::Path;

/// The scales, mm; a ridge is half as wide (section III-B). Figures 8 and 9 begin at 0.5 mm, Figure 11 at 0.8.
const WAVELENGTHS_MM: [f64; 10] = [0.5, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0];
/// The mean of a hand's speed, and two standard deviations to each side, mm/s (section IV-A).
const SPEEDS_MM_S: [f64; 3] = [73.5, 125.4, 177.4];
/// Length of a scan, mm (section IV-A).
const SCAN_MM: f64 = 175.0;
/// Its window, the best of four by its own search, and the longest of these, seconds.
const WINDOW_S: f64 = 0.032;
const LONGEST_S: f64 = 0.128;
/// The accuracy that the longer window is chosen by, as a share of the wavelength.
const ACCURACY: f32 = 0.005;
/// Fewest cycles in a window that is judged: fewer may be a single bump.
const CYCLES: f64 = 1.5;
/// Powers of Figure 11, in its unit, as its equation 2 has them.
const POLYNOMIAL: [f64; 5] = [72_298.0, -248_938.0, 309_743.0, -162_663.0, 30_770.0];

/// Wavelengths that it was fitted over, and its coefficient of determination.
const FITTED_MM: RangeInclusive<f64> = 0.8..=2.0;
const R2: f64 = 0.94;

/// How the finger moves.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Motion {
    Steady(f64),
    Hand,
}

impl Motion {
    /// Speed at a time after the slide's beginning, mm/s.
    fn speed_mm_s(self, t_s: f64) -> f64 {
        let Hand { peak_mm_s, swing_hz, .. } = Hand::default();
        match self {
            Self::Steady(speed_mm_s) => speed_mm_s,
            Self::Hand => peak_mm_s * (TAU * swing_hz * t_s).sin(),
        }
    }

    fn place_mm(self, t_s: f64) -> f64 {
        let Hand { peak_mm_s, swing_hz, .. } = Hand::default();
        match self {
            Self::Steady(speed_mm_s) => speed_mm_s * t_s,
            Self::Hand => peak_mm_s / (TAU * swing_hz) * (1.0 - (TAU * swing_hz * t_s).cos()),
        }
    }

    /// From the lowest place of a window to the highest, mm.
    fn range_mm(self, from_s: f64, until_s: f64) -> f64 {
        let places = (0..=32).map(|step| self.place_mm(from_s + (until_s - from_s) * f64::from(step) / 32.0));
        let (least, most) = places.fold((f64::MAX, f64::MIN), |(least, most), mm| (least.min(mm), most.max(mm)));
        most - least
    }
}

/// Errors of wavelengths, as shares of the true one.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    /// Windows of at least [`CYCLES`] cycles, and those of them that are `good`.
    windows: usize,
    good: usize,
    /// Sums of squares over the good ones: of the errors, and of the errors over their own standard deviations.
    squares: f64,
    over_sigma: f64,
    /// Good windows, of any number of cycles, that are off by more than 5 % and five standard deviations.
    wrong: usize,
}

impl Errors {
    fn rms(&self) -> Option<f64> {
        (self.good > 0).then(|| (self.squares / self.good as f64).sqrt())
    }

    fn rms_over_sigma(&self) -> Option<f64> {
        (self.good > 0).then(|| (self.over_sigma / self.good as f64).sqrt())
    }
}

/// A scan of a scale.
#[derive(Clone, Debug)]
struct Scan {
    wavelength_mm: f64,
    motion: Motion,
    /// By the paper's method, by the firmware in its window, and in a window by accuracy.
    fft: Option<f64>,
    short: Errors,
    long: Errors,
    /// Mean square of the fundamental's amplitude over the channels, mV^2; none without a tone.
    power_mv2: Option<f64>,
}

/// A run's estimates, its frames in volts with their times, and the slide's times, seconds of the device.
struct Run {
    estimates: Vec<Estimate>,
    frames: Vec<(f64, [f32; TAXELS])>,
    slide_s: (f64, f64),
}

fn scene(wavelength_mm: f64, motion: Motion) -> Sliding {
    let (speed_mm_s, hand) = match motion {
        Motion::Steady(speed_mm_s) => (speed_mm_s, None),
        Motion::Hand => (Hand::default().peak_mm_s, Some(Hand::default())),
    };
    let ridge_mm = 0.5 * wavelength_mm;
    let (hold_before_s, hold_after_s) = (0.6, 0.5);
    Sliding {
        speed_mm_s,
        period_mm: wavelength_mm,
        ridge_mm,
        slide_mm: SCAN_MM,
        hold_before_s,
        hold_after_s,
        hand,
        ..Sliding::physical()
    }
}

/// The hand's speed for the firmware, one swing that repeats, from the slide's beginning on, seconds of the device. The speed is linear
/// between knots, so that a knot's own speed would give too short a way: all are larger by the same factor, with which the place is
/// right at every knot.
fn profile(from_s: f64) -> Result<Profile> {
    let swing_s = 1.0 / Hand::default().swing_hz;
    let half_step = 0.5 * TAU / (KNOTS_MAX - 1) as f64;
    let factor = half_step.tan() / half_step;
    let knots: Vec<Knot> = (0..KNOTS_MAX)
        .map(|knot| {
            let t_s = swing_s * knot as f64 / (KNOTS_MAX - 1) as f64;
            Knot {
                t_us: ((from_s + t_s) * 1e6).round() as u32,
                speed_mm_s: (factor * Motion::Hand.speed_mm_s(t_s)) as f32,
            }
        })
        .collect();
    Ok(Profile::new(&knots, After::Repeat)?)
}

fn run(scene: &Sliding, window_s: f64, accuracy: f32) -> Result<Run> {
    let settings = Settings {
        window_s: window_s as f32,
        hop_s: 0.05,
        harmonics: 2,
        accuracy,
        ..Settings::DEFAULT.with_plan(Plan::HAND)
    };
    let once = |profile: Option<Profile>| -> Result<Run> {
        let input = Input { source: Source::Scene(scene.clone()), seed: scene.seed, ..Input::default() }
            .open_in(&Plan::HAND)?;
        let truth = input.truth.context("a scene has its truth")?;
        let (mut estimates, mut frames, mut first_us) = (Vec::new(), Vec::<(f64, [f32; TAXELS])>::new(), None);
        let mut sink = |packet: &Packet| {
            if let Event::Estimate(estimate) = &packet.event {
                estimates.push(estimate.clone());
            }
            Ok(())
        };
        let mut watch = |timed: TimedConversion| {
            let t_s = f64::from(timed.t_us - *first_us.get_or_insert(timed.t_us)) * 1e-6;
            // AIN0 to AIN15 have the ids 8 to 23 (SBAS297G).
            let Some(taxel) = usize::from(timed.status().chid()).checked_sub(8).filter(|taxel| *taxel < TAXELS) else {
                return;
            };
            if taxel == 0 {
                frames.push((t_s, [0.0; TAXELS]));
            }
            if let Some((_, values)) = frames.last_mut() {
                values[taxel] = ads1258::reading::volts(timed.code(), settings.vref_v);
            }
        };
        replay::run_watched(input, settings, profile, &mut sink, &mut |_, _| {}, &mut watch)?;
        let zero_s = f64::from(first_us.context("no conversion")? - START_US) * 1e-6;
        Ok(Run { estimates, frames, slide_s: (truth.slide_start_s - zero_s, truth.slide_end_s - zero_s) })
    };
    let steady = once(None)?;
    if scene.hand.is_none() { Ok(steady) } else { once(Some(profile(steady.slide_s.0)?)) }
}

fn errors(run: &Run, wavelength_mm: f64, motion: Motion) -> Errors {
    let mut errors = Errors::default();
    for estimate in run.estimates.iter().filter(|estimate| estimate.span == Span::Window) {
        let until_s = estimate.t_us as f64 * 1e-6 - run.slide_s.0;
        let from_s = until_s - f64::from(estimate.window_s);
        let (frequency, sigma) = (f64::from(estimate.frequency), f64::from(estimate.sigma));
        // Cycles a millimetre, or a second at a speed that is known.
        let wavelength = match motion {
            Motion::Steady(speed_mm_s) => speed_mm_s / frequency,
            Motion::Hand => 1.0 / frequency,
        };
        let (off, own) = (wavelength / wavelength_mm - 1.0, sigma / frequency);
        let is_good = estimate.status == Status::Good;
        errors.wrong += usize::from(is_good && off.abs() > 0.05 && off.abs() > 5.0 * own);
        if from_s < 0.0 || motion.range_mm(from_s, until_s) < CYCLES * wavelength_mm {
            continue;
        }
        errors.windows += 1;
        if is_good {
            errors.good += 1;
            errors.squares += off * off;
            errors.over_sigma += (off / own).powi(2);
        }
    }
    errors
}

/// The paper's method: in windows of 32 ms the speed over the frequency of maximal power, of all channels together. The root mean
/// square of its errors over the windows of at least [`CYCLES`] cycles.
fn fft(run: &Run, wavelength_mm: f64, motion: Motion) -> Option<f64> {
    let frames = (WINDOW_S * f64::from(Plan::HAND.frame_rate_hz())).round() as usize;
    let (mut squares, mut count) = (0.0, 0);
    for window in run.frames.windows(frames).step_by(frames / 2) {
        let [from_s, until_s] = [window[0].0, window[frames - 1].0].map(|t_s| t_s - run.slide_s.0);
        let is_slide = from_s >= 0.0 && until_s <= run.slide_s.1 - run.slide_s.0;
        if !is_slide || motion.range_mm(from_s, until_s) < CYCLES * wavelength_mm {
            continue;
        }
        let power = |bin: usize| -> f64 {
            let of = |taxel: usize| {
                let turned = window.iter().enumerate().map(|(at, (_, values))| {
                    let (sin, cos) = (TAU * (bin * at) as f64 / frames as f64).sin_cos();
                    (f64::from(values[taxel]) * cos, f64::from(values[taxel]) * sin)
                });
                let (re, im) = turned.fold((0.0, 0.0), |sum, term| (sum.0 + term.0, sum.1 + term.1));
                re * re + im * im
            };
            (0..TAXELS).map(of).sum()
        };
        let bin = (1..=frames / 2).max_by(|a, b| power(*a).total_cmp(&power(*b)))?;
        let frequency_hz = bin as f64 * f64::from(Plan::HAND.frame_rate_hz()) / frames as f64;
        let found_mm = motion.speed_mm_s(0.5 * (from_s + until_s)).abs() / frequency_hz;
        squares += (found_mm / wavelength_mm - 1.0).powi(2);
        count += 1;
    }
    (count > 0).then(|| (squares / f64::from(count)).sqrt())
}

fn scan(wavelength_mm: f64, motion: Motion) -> Result<Scan> {
    let scene = scene(wavelength_mm, motion);
    let short = run(&scene, WINDOW_S, 0.0)?;
    let long = run(&scene, LONGEST_S, ACCURACY)?;
    let of_slide =
        short.estimates.iter().find(|estimate| estimate.span == Span::Slide && estimate.status == Status::Good);
    let power_mv2 = of_slide.map(|estimate| {
        let squares = estimate.channels.iter().map(|channel| (1e3 * f64::from(channel.amplitude_v)).powi(2));
        squares.sum::<f64>() / estimate.channels.len() as f64
    });
    Ok(Scan {
        wavelength_mm,
        motion,
        fft: fft(&short, wavelength_mm, motion),
        short: errors(&short, wavelength_mm, motion),
        long: errors(&long, wavelength_mm, motion),
        power_mv2,
    })
}

/// Scans all scales, and fills in the tables of `reproduction.md` that are about them.
pub fn write(folder: &Path) -> Result<()> {
    let motions = [SPEEDS_MM_S.map(Motion::Steady).to_vec(), vec![Motion::Hand]].concat();
    let all: Vec<_> =
        motions.iter().flat_map(|motion| WAVELENGTHS_MM.map(|wavelength_mm| (wavelength_mm, *motion))).collect();
    let scans = parallel::map("scales", &all, |(wavelength_mm, motion)| scan(*wavelength_mm, *motion))?;
    let path = folder.join("reproduction.md");
    let page = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let text = filled(&page, |name| match name {
        "wavelengths" => Some(wavelengths(&scans)),
        "powers" => Some(powers(&scans)),
        "polynomials" => Some(polynomials(&scans)),
        _ => table_of(&page, name).map(str::to_owned),
    })?;
    output::whole_text(&path, &text)?;
    output::line(&path.display().to_string())
}

fn percent(share: Option<f64>) -> String {
    figure(share.map(|share| 100.0 * share), 2)
}

/// Figures 8 and 9.
fn wavelengths(scans: &[Scan]) -> String {
    let headings = "speed, mm/s|wavelength, mm|FFT of 32 ms, %|firmware, 32 ms, %|good|error / sigma|firmware, up to 128 ms, %|good|\
                    error / sigma|wrong but good";
    let mut table = Table::new(1, headings);
    for scan in scans {
        let speed = match scan.motion {
            Motion::Steady(speed_mm_s) => speed_mm_s.to_string(),
            Motion::Hand => "197 sin(2 pi 1.07 t)".into(),
        };
        let of = |errors: &Errors| {
            [
                percent(errors.rms()),
                format!("{} of {}", errors.good, errors.windows),
                figure(errors.rms_over_sigma(), 2),
            ]
        };
        let mut row = vec![speed, scan.wavelength_mm.to_string(), percent(scan.fft)];
        row.extend(of(&scan.short).into_iter().chain(of(&scan.long)));
        row.push((scan.short.wrong + scan.long.wrong).to_string());
        table.row(&row);
    }
    table.end()
}

/// Figures 10 and 11.
fn powers(scans: &[Scan]) -> String {
    let mut table =
        Table::new(0, "wavelength, mm|73.5 mm/s, mV^2|125.4 mm/s|177.4 mm/s|most over least|the paper's equation 2");
    for wavelength_mm in WAVELENGTHS_MM {
        let of = |speed_mm_s| {
            scans.iter().find(|scan| (scan.wavelength_mm, scan.motion) == (wavelength_mm, Motion::Steady(speed_mm_s)))
        };
        let powers: Vec<Option<f64>> =
            SPEEDS_MM_S.iter().map(|speed_mm_s| of(*speed_mm_s).and_then(|scan| scan.power_mv2)).collect();
        let known: Vec<f64> = powers.iter().flatten().copied().collect();
        let spread = (known.len() == powers.len()).then(|| {
            known.iter().fold(0.0, |most: f64, one| most.max(*one))
                / known.iter().fold(f64::MAX, |least: f64, one| least.min(*one))
        });
        let paper = POLYNOMIAL.iter().rev().fold(0.0, |sum, factor| sum * wavelength_mm + factor);
        let mut row = vec![wavelength_mm.to_string()];
        row.extend(powers.iter().map(|power| figure(*power, 5)));
        row.extend([figure(spread, 2), figure(FITTED_MM.contains(&wavelength_mm).then_some(paper), 0)]);
        table.row(&row);
    }
    table.end()
}

/// The polynomial of fourth order through the powers of [`FITTED_MM`], at all speeds, from the constant on; and its coefficient of
/// determination.
fn polynomial(scans: &[Scan]) -> Option<([f64; 5], f64)> {
    let is_steady = |scan: &&Scan| scan.motion != Motion::Hand && FITTED_MM.contains(&scan.wavelength_mm);
    let points: Vec<(f64, f64)> =
        scans.iter().filter(is_steady).filter_map(|scan| Some((scan.wavelength_mm, scan.power_mv2?))).collect();
    let powers = DVector::from_iterator(points.len(), points.iter().map(|point| point.1));
    let terms = DMatrix::from_fn(points.len(), POLYNOMIAL.len(), |row, order| points[row].0.powi(order as i32));
    let factors = terms.clone().svd(true, true).solve(&powers, 1e-12).ok()?;
    let (left, mean) = (&terms * &factors - &powers, powers.mean());
    let r2 = 1.0 - left.norm_squared() / powers.map(|power| power - mean).norm_squared();
    Some((std::array::from_fn(|order| factors[order]), r2))
}

/// Equation 2 and ours.
fn polynomials(scans: &[Scan]) -> String {
    let mut table = Table::new(1, "power|lambda^4|lambda^3|lambda^2|lambda|1|R^2");
    let mut row = |name: &str, factors: [f64; 5], r2: f64, decimals| {
        let factors = factors.iter().rev().map(|factor| figure(Some(*factor), decimals));
        table.row(&[vec![name.into()], factors.collect(), vec![figure(Some(r2), 4)]].concat());
    };
    row("the paper's equation 2, its unit", POLYNOMIAL, R2, 0);
    if let Some((factors, r2)) = polynomial(scans) {
        row("here, mV^2", factors, r2, 4);
    }
    table.end()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One scale at each kind of motion: the firmware is within half a percent where the window holds 1.5 cycles.
    #[test]
    fn a_scale_is_measured_within_half_a_percent() {
        for motion in [Motion::Steady(125.4), Motion::Hand] {
            let scan = scan(1.5, motion).expect("a scan");
            for errors in [scan.short, scan.long] {
                assert!(errors.good > 5 && errors.wrong == 0, "{scan:?}");
                assert!(errors.rms().is_some_and(|rms| rms < 0.005), "{scan:?}");
            }
            assert!(scan.fft.is_some_and(|rms| rms > 0.02), "{scan:?}");
        }
    }

    /// Against the powers that the paper gives for four of its gratings.
    #[test]
    fn the_papers_polynomial_has_its_maximum() {
        let of = |mm: f64| POLYNOMIAL.iter().rev().fold(0.0, |sum, factor| sum * mm + factor);
        for (mm, power) in [(0.8, 703.0), (1.4, 2740.0), (1.7, 2091.0), (2.0, 4410.0)] {
            assert!((of(mm) - power).abs() < 1.0, "{mm} mm: {}", of(mm));
        }
    }
}
