//! Recordings of other people's sensors, each fit by itself: `real FOLDER`. The folder's README says
//! what is known of each. Prints the tables of `docs/results/real.md`, of both estimators.

#[path = "real/estimators.rs"]
mod estimators;
#[path = "real/recording.rs"]
mod recording;

use estimators::{Answer, Estimator, periodogram};
use recording::{Known, Recording, known};
use std::error::Error;
use std::path::Path;

/// Cycles of a window of the figure of error against window.
const WINDOW_CYCLES: [f64; 5] = [1.5, 2.0, 3.0, 4.0, 6.0];
/// Rows of a stretch of cloth: 1.5 and 3 s.
const CLOTH_ROWS: [usize; 2] = [54, 107];
/// Half the width of a 95 % interval, in sigmas.
const NINETY_FIVE: f64 = 1.96;
/// Period of the printed pattern, and its tolerance.
const PATTERN_MM: f64 = 6.9;
const PATTERN_TOLERANCE: f64 = 0.02;

/// How many of how many.
#[derive(Clone, Copy, Default)]
struct Share {
    count: usize,
    of: usize,
}

impl Share {
    fn add(&mut self, counts: bool) {
        self.count += usize::from(counts);
        self.of += 1;
    }
}

impl std::fmt::Display for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{} of {}", self.count, self.of)
    }
}

/// The counts of one estimator.
#[derive(Clone, Copy, Default)]
struct Counts {
    right: Share,
    good: Share,
    held: Share,
    parts: Share,
    channels: Share,
    cloth: Share,
    flat: Share,
    pattern_right: Share,
    pattern_wrong: Share,
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args()
        .nth(1)
        .ok_or("real FOLDER: the folder of the recordings")?;
    let folder = Path::new(&folder);
    if !folder.is_dir() {
        println!("{}: no such folder, nothing is measured", folder.display());
        return Ok(());
    }
    let recordings = known(folder)?;
    println!(
        "| recording | known, Hz | {} | {} |",
        Estimator::Old,
        Estimator::New
    );
    println!("|---|---|---|---|");
    let mut counts = [Counts::default(); 2];
    for (recording, truth) in &recordings {
        let answers = Estimator::BOTH.map(|by| by.fit(recording));
        println!(
            "| {} | {:.4} | {} | {} |",
            recording.name, truth.hz, answers[0], answers[1]
        );
        for (by, counts) in Estimator::BOTH.into_iter().zip(&mut counts) {
            of_a_tone(by, recording, truth, counts);
        }
    }
    for (by, counts) in Estimator::BOTH.into_iter().zip(&mut counts) {
        without_tone(by, folder, counts)?;
        sweeps(by, folder, counts)?;
    }
    println!();
    summary(&counts);
    println!();
    board(&recordings);
    Ok(())
}

/// A recording of a known tone, whole, in parts and by halves of its channels.
fn of_a_tone(by: Estimator, recording: &Recording, truth: &Known, counts: &mut Counts) {
    let answer = by.fit(recording);
    counts.right.add(answer.is_near(truth.hz, truth.tolerance));
    if truth.hz * recording.length() >= 5.9 {
        counts.good.add(answer.is_good);
    }
    if answer.is_good {
        let width = NINETY_FIVE * answer.sigma.hypot(0.5 * truth.tolerance * truth.hz);
        counts
            .held
            .add((answer.frequency - truth.hz).abs() <= width);
    }
    for count in [2, 3] {
        let rows = recording.rows() / count;
        let parts: Vec<_> = (0..count)
            .map(|i| recording.stretch(i * rows, rows))
            .collect();
        let whole = by.fit(&recording.stretch(0, count * rows));
        let answers: Vec<_> = parts.iter().map(|part| by.fit(part)).collect();
        if !whole.is_good || answers.iter().any(|part| !part.is_good) {
            continue;
        }
        let mean = answers.iter().map(|part| part.frequency).sum::<f64>() / count as f64;
        let square = answers.iter().map(|part| part.sigma.powi(2)).sum::<f64>();
        let sigma = whole.sigma.hypot(square.sqrt() / count as f64);
        counts
            .parts
            .add((mean - whole.frequency).abs() <= NINETY_FIVE * sigma);
    }
    if recording.channels() < 4 {
        return;
    }
    let rows = recording.rows() / 2;
    for stretch in [
        recording.clone(),
        recording.stretch(0, rows),
        recording.stretch(rows, rows),
    ] {
        let halves = [0, 1].map(|half| by.fit(&stretch.every_second_channel(half)));
        if halves.iter().all(|half| half.is_good) {
            let width = NINETY_FIVE * halves[0].sigma.hypot(halves[1].sigma);
            counts
                .channels
                .add((halves[0].frequency - halves[1].frequency).abs() <= width);
        }
    }
}

/// Cloth without a grating, whole and in stretches: none is good.
fn without_tone(by: Estimator, folder: &Path, counts: &mut Counts) -> Result<(), Box<dyn Error>> {
    for recording in recording::folder(&folder.join("no_grating"), "", "time_s")? {
        for rows in CLOTH_ROWS.into_iter().chain([recording.rows()]) {
            for first in (0..recording.rows() + 1 - rows.min(recording.rows())).step_by(rows) {
                counts
                    .cloth
                    .add(by.fit(&recording.stretch(first, rows)).is_good);
            }
        }
    }
    Ok(())
}

/// Sweeps by place: over a pattern, and over flat samples.
fn sweeps(by: Estimator, folder: &Path, counts: &mut Counts) -> Result<(), Box<dyn Error>> {
    let folder = folder.join("sweeps");
    for recording in recording::folder(&folder, "flat", "x_mm")? {
        counts.flat.add(by.fit(&recording).is_good);
    }
    for recording in recording::folder(&folder, "pattern", "x_mm")? {
        let answer = by.fit(&recording);
        let is_right = answer.is_near(1.0 / PATTERN_MM, PATTERN_TOLERANCE);
        counts.pattern_right.add(is_right);
        counts.pattern_wrong.add(answer.is_good && !is_right);
    }
    Ok(())
}

fn summary(counts: &[Counts; 2]) {
    println!(
        "| what | {} | {} | asked for |",
        Estimator::Old,
        Estimator::New
    );
    println!("|---|---|---|---|");
    let row = |what: &str, of: &dyn Fn(&Counts) -> Share, asked: &str| {
        println!(
            "| {what} | {} | {} | {asked} |",
            of(&counts[0]),
            of(&counts[1])
        );
    };
    row("right within tolerance", &|c| c.right, "all");
    row("good, of those with six cycles", &|c| c.good, "80 %");
    row("interval holds, of the good", &|c| c.held, "90 %");
    row("parts add up to the whole", &|c| c.parts, "95 %");
    row("halves of the channels agree", &|c| c.channels, "90 %");
    row("cloth without a grating: good", &|c| c.cloth, "1 %");
    row("flat sweeps: good", &|c| c.flat, "1 %");
    row("pattern sweeps: right", &|c| c.pattern_right, "95 %");
    row(
        "pattern sweeps: good and wrong",
        &|c| c.pattern_wrong,
        "none",
    );
}

/// The ridged board in windows of some cycles: relative error of a periodogram's peak and of least
/// squares, against speed over ridge distance.
fn board(recordings: &[(Recording, Known)]) {
    println!(
        "| cycles in the window | windows | periodogram's peak, % | {} | {} | good |",
        Estimator::Old,
        Estimator::New
    );
    println!("|---|---|---|---|---|---|");
    for cycles in WINDOW_CYCLES {
        let (mut errors, mut good) = ([const { Vec::new() }; 3], Share::default());
        for (recording, truth) in recordings
            .iter()
            .filter(|(one, _)| one.name.starts_with("fabric"))
        {
            let all = recording.rows() as f64;
            let rows = (cycles / (truth.hz * recording.length()) * all).min(all) as usize;
            for first in (0..=recording.rows() - rows).step_by(rows) {
                let stretch = recording.stretch(first, rows);
                let answers = Estimator::BOTH.map(|by| by.fit(&stretch));
                good.add(answers[1].is_good);
                let found = [
                    periodogram(&stretch),
                    answers[0].frequency,
                    answers[1].frequency,
                ];
                for (errors, found) in errors.iter_mut().zip(found) {
                    errors.push(100.0 * (found / truth.hz - 1.0).abs());
                }
            }
        }
        let median = errors.map(|mut errors: Vec<f64>| {
            errors.sort_by(f64::total_cmp);
            (errors[errors.len() / 2], errors.len())
        });
        println!(
            "| {cycles} | {} | {:.1} | {:.1} | {:.1} | {good} |",
            median[0].1, median[0].0, median[1].0, median[2].0
        );
    }
}

impl Answer {
    fn is_near(&self, truth: f64, tolerance: f64) -> bool {
        (self.frequency / truth - 1.0).abs() <= tolerance
    }
}
