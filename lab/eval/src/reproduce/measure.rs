//! The measurement: every run is made once; the data of the tables follow from it.

use super::estimate::{Cut, cut, fft_hz, joint_hz, least_squares_hz};
use super::paper::{DELAY_S, STEP_S, TABLE_3, WINDOWS_S, series};
use super::protocol::{Imperfect, scene};
use super::repeatability::correlation;
use super::results::{Cause, Combination, Expected, Firmware, Pair, Run, Windows, rms};
use super::taken::{Place, Taken};
use crate::baselines::Scratch;
use crate::parallel;
use anyhow::{Context, Result};
use hal_mock::TABLE_2;
use ridgetone_host::digits::seconds;
use ridgetone_host::static_image::by_taxel;
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::{Event, Hold, Span, Status};

pub const ALL: [usize; TAXELS] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

struct Measured {
    run: Run,
    /// Per length of window, per window: naive Fourier analysis, least squares, our fit; hertz.
    windows: Vec<Vec<[Option<f64>; 3]>>,
    /// The 55 mm of piezoresistor 1 of units 1 and 2, volts.
    cropped: [Vec<f64>; 2],
}

/// Lengths of the windows of Figure 7, seconds: its own range in its own steps.
pub fn window_lengths_s() -> impl Iterator<Item = f64> {
    let (shortest_s, longest_s) = WINDOWS_S;
    let steps = ((longest_s - shortest_s) / STEP_S).round() as u32;
    (0..=steps).map(move |step| ((shortest_s + f64::from(step) * STEP_S) * 1e3).round() / 1e3)
}

/// Makes and measures `runs` runs of some of the ten combinations, by their numbers from 0 on.
pub fn combinations(which: &[usize], runs: u32, place: Place<'_>) -> Result<Vec<Combination>> {
    let items: Vec<(usize, u32)> = which
        .iter()
        .flat_map(|c| (0..runs).map(move |run| (*c, run)))
        .collect();
    let all = parallel::map("runs", &items, |(c, run)| measure(*c, *run, place))?;
    let mut combinations = Vec::new();
    for (c, measured) in which.iter().zip(all.chunks(runs as usize)) {
        let (speed_mm_s, period_mm) = TABLE_2[*c];
        let mut combination = Combination {
            speed_mm_s,
            period_mm,
            runs: measured
                .iter()
                .map(|measured| measured.run.clone())
                .collect(),
            windows: Vec::new(),
            repeatability: None,
        };
        combination.windows = window_lengths_s()
            .enumerate()
            .filter_map(|(n, length_s)| windows(&combination, measured, n, length_s))
            .collect();
        let rate_hz = ridgetone_host::input::frame_rate_hz();
        let half_cycle = (0.5 * rate_hz / combination.nominal_hz()).round() as usize;
        let of_channel = |n: usize| {
            let series: Vec<Vec<f64>> = measured
                .iter()
                .map(|measured| measured.cropped[n].clone())
                .collect();
            correlation(&series, half_cycle)
        };
        combination.repeatability = of_channel(0)
            .zip(of_channel(1))
            .map(|(one, two)| [one, two]);
        combinations.push(combination);
    }
    Ok(combinations)
}

fn measure(c: usize, run: u32, place: Place<'_>) -> Result<Measured> {
    let series = series(c, run);
    let (speed_mm_s, period_mm) = TABLE_2[c];
    let taken = Taken::new(scene(speed_mm_s, period_mm, run, Imperfect::ALL), place)?;
    let first = found(&taken, TABLE_3[0].taxels, speed_mm_s)
        .with_context(|| format!("data series {series}"))?;
    let mut scratch = Box::new(Scratch::EMPTY);
    let mut windows = Vec::new();
    for length_s in window_lengths_s() {
        windows.push(of_length(&taken, &first, length_s, &mut scratch)?);
    }
    let cropped = TABLE_3[0]
        .taxels
        .map(|taxel| taken.samples(taxel, &first.frames));
    Ok(Measured {
        run: whole(&taken, series, speed_mm_s)?,
        windows,
        cropped,
    })
}

/// The paper's cut, or an error.
fn found(taken: &Taken, taxels: [usize; 2], speed_mm_s: f64) -> Result<Cut> {
    cut(taken, taxels, speed_mm_s)
        .with_context(|| format!("no spike {DELAY_S} s before a slide at {speed_mm_s} mm/s"))
}

/// A run over its whole length.
fn whole(taken: &Taken, series: usize, speed_mm_s: f64) -> Result<Run> {
    let mut scratch = Box::new(Scratch::EMPTY);
    let mut pairs = [Pair {
        fft_hz: None,
        least_squares_hz: None,
    }; 2];
    for (pair, paper) in pairs.iter_mut().zip(TABLE_3) {
        let frames = found(taken, paper.taxels, speed_mm_s)?.frames;
        pair.fft_hz = fft_hz(taken, &paper.taxels, &frames);
        pair.least_squares_hz = least_squares_hz(taken, paper.taxels, &frames, &mut scratch);
    }
    let frames = found(taken, TABLE_3[0].taxels, speed_mm_s)?.frames;
    Ok(Run {
        series,
        true_hz: taken.truth.frequency_hz,
        true_slide_s: (taken.truth.slide_start_s, taken.truth.slide_end_s),
        pairs,
        all_fft_hz: fft_hz(taken, &ALL, &frames),
        all_fit_hz: joint_hz(taken, &frames)?,
        firmware: firmware(taken),
        images_v: static_images(taken),
    })
}

/// The firmware's report: its longest slide.
pub fn firmware(taken: &Taken) -> Option<Firmware> {
    let contact_s = taken
        .events(|event| match event {
            Event::Contact(contact) => Some(seconds(contact.t_us)),
            _ => None,
        })
        .next()?;
    let tone_hz = taken
        .events(|event| match event {
            Event::Estimate(fit) if fit.span == Span::Slide => Some(fit.clone()),
            _ => None,
        })
        .max_by(|a, b| a.window_s.total_cmp(&b.window_s))
        .filter(|fit| matches!(fit.status, Status::Good | Status::Unsteady))
        .map(|fit| (f64::from(fit.frequency), f64::from(fit.sigma)));
    Some(Firmware {
        contact_s,
        slide_s: taken.longest_slide_s()?,
        tone_hz,
    })
}

/// The firmware's static images before and after the slide (phases B and D): volts over the level
/// before the touch by taxel; empty where it reported none or a taxel was dead. Of several holds
/// the last one.
fn static_images(taken: &Taken) -> [Vec<f64>; 2] {
    [Hold::BeforeSlide, Hold::AfterSlide].map(|hold| {
        let images = taken.events(|event| match event {
            Event::Image(image) if image.hold == hold => Some(by_taxel(image)),
            _ => None,
        });
        let level_v = |pressed: Option<_>| {
            pressed.map(|pressed: ridgetone_proto::telemetry::Pressed| f64::from(pressed.level_v))
        };
        images
            .last()
            .and_then(|image| image.into_iter().map(level_v).collect())
            .unwrap_or_default()
    })
}

/// All windows of a length in a run's cut, every 50 ms.
fn of_length(
    taken: &Taken,
    cut: &Cut,
    length_s: f64,
    scratch: &mut Scratch,
) -> Result<Vec<[Option<f64>; 3]>> {
    let taxels = TABLE_3[0].taxels;
    let count = (length_s * taken.rate_hz).round() as usize;
    let starts = (0..).map(|step| cut.slide_s.0 + f64::from(step) * STEP_S);
    let starts = starts.take_while(|start_s| start_s + length_s <= cut.slide_s.1 + 1e-9);
    let mut all = Vec::new();
    for start_s in starts {
        let first = taken.frame_at(taxels[0], start_s);
        let frames = first..first + count;
        all.push([
            fft_hz(taken, &taxels, &frames),
            least_squares_hz(taken, taxels, &frames, scratch),
            joint_hz(taken, &frames)?.map(|(hz, _)| hz),
        ]);
    }
    Ok(all)
}

fn windows(
    combination: &Combination,
    measured: &[Measured],
    n: usize,
    window_s: f64,
) -> Option<Windows> {
    let nominal_hz = combination.nominal_hz();
    let each = || {
        measured
            .iter()
            .flat_map(|m| m.windows[n].iter().map(|window| (*window, m.run.true_hz)))
    };
    let error = |method: usize, of: &dyn Fn(f64) -> f64| {
        rms(each()
            .filter_map(|(window, true_hz)| Some(window[method]? - of(true_hz)))
            .map(Some))
    };
    let nominal = |_: f64| nominal_hz;
    let truth = |true_hz: f64| true_hz;
    Some(Windows {
        window_s,
        windows: each().count() as u32,
        fft_hz: error(0, &nominal)?,
        least_squares_hz: error(1, &nominal)?,
        own_least_squares_hz: error(1, &truth)?,
        all_hz: error(2, &nominal),
        own_all_hz: error(2, &truth),
        all_found: each().filter(|(window, _)| window[2].is_some()).count() as u32,
    })
}

/// The effect of each imperfection alone on the first run of every combination.
pub fn causes(which: &[usize], place: Place<'_>) -> Result<Vec<Cause>> {
    let nothing = Imperfect::NOTHING;
    let kinds = [
        ("nothing", nothing),
        (
            "the slide's onset",
            Imperfect {
                onset: true,
                ..nothing
            },
        ),
        (
            "noise",
            Imperfect {
                noise: true,
                ..nothing
            },
        ),
        (
            "ripple of the speed",
            Imperfect {
                ripple: true,
                ..nothing
            },
        ),
        (
            "mean speed",
            Imperfect {
                speed: true,
                ..nothing
            },
        ),
        ("all of it", Imperfect::ALL),
    ];
    let items: Vec<(Imperfect, usize)> = kinds
        .iter()
        .flat_map(|(_, imperfect)| which.iter().map(|c| (*imperfect, *c)))
        .collect();
    let errors = parallel::map("causes", &items, |(imperfect, c)| {
        let (speed_mm_s, period_mm) = TABLE_2[*c];
        let taken = Taken::new(scene(speed_mm_s, period_mm, 0, *imperfect), place)?;
        let (speed_mm_s, period_mm) = TABLE_2[*c];
        let (pair, nominal_hz) = (TABLE_3[0].taxels, speed_mm_s / period_mm);
        let frames = found(&taken, pair, speed_mm_s)?.frames;
        let percent = |hz: Option<f64>| hz.map(|hz| 100.0 * (hz / nominal_hz - 1.0));
        let two = least_squares_hz(&taken, pair, &frames, &mut Box::new(Scratch::EMPTY));
        Ok((
            percent(two),
            percent(joint_hz(&taken, &frames)?.map(|(hz, _)| hz)),
        ))
    })?;
    kinds
        .iter()
        .zip(errors.chunks(which.len()))
        .map(|((name, _), errors)| {
            // Beside hardly any noise a fit may be ambiguous.
            let found = errors.iter().filter(|error| error.1.is_some());
            Ok(Cause {
                name: (*name).into(),
                least_squares_percent: rms(errors.iter().map(|error| error.0))
                    .context("no estimate")?,
                all_percent: rms(found.map(|error| error.1)).context("no estimate")?,
            })
        })
        .collect()
}

/// Table 2: every speed on every grating, with a perfect stimulator.
pub fn expected(cells: &[(f64, f64)], place: Place<'_>) -> Result<Vec<Expected>> {
    parallel::map("perfect runs", cells, |&(speed_mm_s, period_mm)| {
        let taken = Taken::new(scene(speed_mm_s, period_mm, 0, Imperfect::NOTHING), place)?;
        let firmware = firmware(&taken);
        let firmware_hz = firmware
            .and_then(|firmware| firmware.tone_hz)
            .map(|tone| tone.0);
        let end_late_s = firmware.map(|firmware| firmware.slide_s.1 - taken.truth.slide_end_s);
        let frames = found(&taken, TABLE_3[0].taxels, speed_mm_s)?.frames;
        let hz = joint_hz(&taken, &frames)?.map(|(hz, _)| hz);
        Ok(Expected {
            speed_mm_s,
            period_mm,
            hz,
            firmware_hz,
            end_late_s,
        })
    })
}
