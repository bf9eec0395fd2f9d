//! Recordings of other people's sensors, each fit by itself. The folder's README says what is known
//! of each. Prints the tables of `docs/results/real.md`.

mod answer;
mod recording;

use answer::{Answer, periodogram};
use anyhow::Result;
use recording::{Known, Recording, known};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct RealArgs {
    /// The recordings. Where it is absent nothing is measured.
    folder: PathBuf,
}

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

pub fn run(RealArgs { folder }: &RealArgs) -> Result<()> {
    if !folder.is_dir() {
        println!("{}: no such folder, nothing is measured", folder.display());
        return Ok(());
    }
    let recordings = known(folder)?;
    println!("| recording | known, Hz | fit, Hz |");
    println!("|---|---|---|");
    let mut counts = Counts::default();
    for (recording, truth) in &recordings {
        let answer = Answer::of(recording);
        println!("| {} | {:.4} | {answer} |", recording.name, truth.hz);
        of_a_tone(recording, truth, &mut counts);
    }
    without_tone(folder, &mut counts)?;
    sweeps(folder, &mut counts)?;
    println!();
    summary(&counts);
    println!();
    board(&recordings);
    Ok(())
}

/// A recording of a known tone, whole, in parts and by halves of its channels.
fn of_a_tone(recording: &Recording, truth: &Known, counts: &mut Counts) {
    let answer = Answer::of(recording);
    counts.right.add(answer.is_near(truth.hz, truth.tolerance));
    if truth.hz * recording.length() >= 5.9 {
        counts.good.add(answer.is_good);
    }
    if answer.is_good {
        counts.held.add(answer.holds(truth));
    }
    for count in [2, 3] {
        let rows = recording.rows() / count;
        let parts: Vec<_> = (0..count)
            .map(|i| recording.stretch(i * rows, rows))
            .collect();
        let whole = Answer::of(&recording.stretch(0, count * rows));
        let answers: Vec<_> = parts.iter().map(Answer::of).collect();
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
        let halves = [0, 1].map(|half| Answer::of(&stretch.every_second_channel(half)));
        if halves.iter().all(|half| half.is_good) {
            let width = NINETY_FIVE * halves[0].sigma.hypot(halves[1].sigma);
            counts
                .channels
                .add((halves[0].frequency - halves[1].frequency).abs() <= width);
        }
    }
}

/// Cloth without a grating, whole and in stretches: none is good.
fn without_tone(folder: &Path, counts: &mut Counts) -> Result<()> {
    for recording in recording::folder(&folder.join("no_grating"), "", "time_s")? {
        for rows in CLOTH_ROWS.into_iter().chain([recording.rows()]) {
            for first in (0..recording.rows() + 1 - rows.min(recording.rows())).step_by(rows) {
                counts
                    .cloth
                    .add(Answer::of(&recording.stretch(first, rows)).is_good);
            }
        }
    }
    Ok(())
}

/// Sweeps by place: over a pattern, and over flat samples.
fn sweeps(folder: &Path, counts: &mut Counts) -> Result<()> {
    let folder = folder.join("sweeps");
    for recording in recording::folder(&folder, "flat", "x_mm")? {
        counts.flat.add(Answer::of(&recording).is_good);
    }
    for recording in recording::folder(&folder, "pattern", "x_mm")? {
        let answer = Answer::of(&recording);
        let is_right = answer.is_near(1.0 / PATTERN_MM, PATTERN_TOLERANCE);
        counts.pattern_right.add(is_right);
        counts.pattern_wrong.add(answer.is_good && !is_right);
    }
    Ok(())
}

fn summary(counts: &Counts) {
    println!("| what | measured | asked for |");
    println!("|---|---|---|");
    let row = |what: &str, of: &dyn Fn(&Counts) -> Share, asked: &str| {
        println!("| {what} | {} | {asked} |", of(counts));
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
        "| cycles in the window | windows | periodogram's peak, % | fit, % | good | intervals that hold |"
    );
    println!("|---|---|---|---|---|---|");
    for cycles in WINDOW_CYCLES {
        let mut errors = [const { Vec::new() }; 2];
        let [mut good, mut held] = [Share::default(); 2];
        for (recording, truth) in recordings
            .iter()
            .filter(|(one, _)| one.name.starts_with("fabric"))
        {
            let all = recording.rows() as f64;
            let rows = (cycles / (truth.hz * recording.length()) * all).min(all) as usize;
            for first in (0..=recording.rows() - rows).step_by(rows) {
                let stretch = recording.stretch(first, rows);
                let answer = Answer::of(&stretch);
                good.add(answer.is_good);
                if answer.is_good {
                    held.add(answer.holds(truth));
                }
                let found = [periodogram(&stretch), answer.frequency];
                for (errors, found) in errors.iter_mut().zip(found) {
                    errors.push(100.0 * (found / truth.hz - 1.0).abs());
                }
            }
        }
        let median = errors.map(|mut errors: Vec<f64>| {
            errors.sort_by(f64::total_cmp);
            (errors[errors.len() / 2], errors.len())
        });
        let [(peak, windows), (fit, _)] = median;
        println!("| {cycles} | {windows} | {peak:.1} | {fit:.1} | {good} | {held} |");
    }
}

impl Answer {
    /// Whether its interval of 95 % holds the truth, as well as that is known.
    fn holds(&self, truth: &Known) -> bool {
        let width = NINETY_FIVE * self.sigma.hypot(0.5 * truth.tolerance * truth.hz);
        (self.frequency - truth.hz).abs() <= width
    }

    fn is_near(&self, truth: f64, tolerance: f64) -> bool {
        (self.frequency / truth - 1.0).abs() <= tolerance
    }
}
