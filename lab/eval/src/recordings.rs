//! Recordings that stay outside of the repository, cut in stretches: what the fit says of each, and
//! whether neighbours agree.

use crate::accuracy::NINETY_FIVE;
use crate::page::{Table, figure};
use crate::parallel;
use anyhow::{Context, Result, ensure};
use ridgetone_host::output;
use ridgetone_host::samples::Samples;
use ridgetone_host::speed::Column;
use ridgetone_host::table_fit::{self, Selection};
use ridgetone_host::usage::UsageError;
use ridgetone_proto::telemetry::Status;
use ridgetone_tone::FRAMES_MIN;
use std::fs;
use std::path::{Path, PathBuf};

/// Lengths of the stretches, seconds; the last is the whole recording.
const STRETCHES_S: [f64; 5] = [1.0, 2.0, 4.0, 8.0, f64::INFINITY];
/// A column of this name is the place on the surface: the fit is by place.
const PLACE: &str = "x_mm";

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Recordings of a kind are those of a folder whose names have the same first word: fabric_1.csv and fabric_2.csv. Stretches of
fewer than 16 rows are left out.

Example:
  cargo run --release -p ridgetone-eval -- recordings my_recordings")]
pub struct RecordingsArgs {
    /// Folder with recordings as CSV with a column time_s, and with folders of them.
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
}

/// Of the stretches of one length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Counts {
    stretches: u32,
    good: u32,
    unsteady: u32,
    ambiguous: u32,
    /// Neighbours that are both good, and those that agree.
    pairs: u32,
    agree: u32,
}

impl Counts {
    /// What the fit says of each stretch of one recording, in their order: its status, and
    /// frequency with sigma.
    fn of(fits: &[(Status, Option<(f64, f64)>)]) -> Self {
        let count = |status| fits.iter().filter(|fit| fit.0 == status).count() as u32;
        let good = |fit: (Status, Option<(f64, f64)>)| fit.1.filter(|_| fit.0 == Status::Good);
        let pairs = fits
            .windows(2)
            .filter_map(|pair| good(pair[0]).zip(good(pair[1])));
        let agree: Vec<bool> = pairs
            .map(|((a, s), (b, t))| (a - b).abs() <= NINETY_FIVE * s.hypot(t))
            .collect();
        Self {
            stretches: fits.len() as u32,
            good: count(Status::Good),
            unsteady: count(Status::Unsteady),
            ambiguous: count(Status::Ambiguous),
            pairs: agree.len() as u32,
            agree: agree.iter().filter(|agree| **agree).count() as u32,
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            stretches: self.stretches + other.stretches,
            good: self.good + other.good,
            unsteady: self.unsteady + other.unsteady,
            ambiguous: self.ambiguous + other.ambiguous,
            pairs: self.pairs + other.pairs,
            agree: self.agree + other.agree,
        }
    }
}

/// The counts of one recording, for each of [`STRETCHES_S`].
fn counts(path: &Path) -> Result<[Counts; STRETCHES_S.len()]> {
    let samples = Samples::file(path)?;
    let (mut rows, mut times_s) = (samples.open()?, Vec::new());
    let place = rows
        .names()
        .iter()
        .any(|name| name == PLACE)
        .then(|| Column::Position(PLACE.into()));
    while rows.advance()? {
        times_s.extend(rows.time_s());
    }
    let (first_s, last_s) = times_s
        .first()
        .zip(times_s.last())
        .with_context(|| format!("{}: no time_s", path.display()))?;
    let mut all = [Counts::default(); STRETCHES_S.len()];
    for (counts, length_s) in all.iter_mut().zip(STRETCHES_S) {
        let whole = if length_s.is_finite() {
            ((last_s - first_s) / length_s) as u32
        } else {
            1
        };
        let mut fits = Vec::new();
        for number in 0..whole {
            let from_s = first_s
                + if number > 0 {
                    f64::from(number) * length_s
                } else {
                    0.0
                };
            // A row at the end belongs to the next stretch.
            let to_s = (from_s + length_s).next_down();
            if times_s
                .iter()
                .filter(|t_s| (from_s..=to_s).contains(*t_s))
                .count()
                < FRAMES_MIN as usize
            {
                continue;
            }
            let selection = Selection {
                from_s: Some(from_s),
                to_s: Some(to_s.min(*last_s)),
                place: place.clone(),
                ..Selection::default()
            };
            let fit = table_fit::fit(&mut *samples.open()?, &selection, &mut |_| {})?;
            let tone = fit.tone.frequency();
            fits.push((fit.status, tone.map(|tone| (tone.value, tone.sigma))));
        }
        *counts = Counts::of(&fits);
    }
    Ok(all)
}

/// The recordings of a folder and of the folders in it, in order of their names.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let mut paths = entries
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<Vec<_>>>()?;
    paths.sort();
    let (folders, files): (Vec<_>, Vec<_>) = paths.into_iter().partition(|path| path.is_dir());
    let mut all: Vec<PathBuf> = files
        .into_iter()
        .filter(|path| path.extension().is_some_and(|extension| extension == "csv"))
        .collect();
    for folder in folders {
        all.extend(self::files(&folder)?);
    }
    Ok(all)
}

/// The folder within `root`, and the first word of the name.
fn kind(path: &Path, root: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let word = stem.split('_').next().unwrap_or_default();
    path.strip_prefix(root)
        .unwrap_or(path)
        .with_file_name(word)
        .display()
        .to_string()
}

pub fn run(args: &RecordingsArgs) -> Result<()> {
    let files = files(&args.folder)?;
    ensure!(
        !files.is_empty(),
        UsageError(format!("{}: no recording", args.folder.display()))
    );
    let counts = parallel::map("recordings", &files, |path| counts(path))?;
    let mut kinds: Vec<(String, u32, [Counts; STRETCHES_S.len()])> = Vec::new();
    for (path, counts) in files.iter().zip(counts) {
        let kind = kind(path, &args.folder);
        match kinds.iter_mut().find(|(other, ..)| *other == kind) {
            Some((_, files, sums)) => {
                *files += 1;
                sums.iter_mut()
                    .zip(counts)
                    .for_each(|(sum, counts)| *sum = sum.plus(counts));
            }
            None => kinds.push((kind, 1, counts)),
        }
    }
    let mut table = Table::new(
        1,
        "recordings|files|stretch, s|stretches|good, %|unsteady, %|ambiguous, %|good neighbours|of these agree, %",
    );
    for (kind, files, sums) in kinds {
        for (sum, length_s) in sums
            .iter()
            .zip(STRETCHES_S)
            .filter(|(sum, _)| sum.stretches > 0)
        {
            let share = |count: u32, of: u32| {
                figure(
                    (of > 0).then(|| 100.0 * f64::from(count) / f64::from(of)),
                    1,
                )
            };
            let [good, unsteady, ambiguous] =
                [sum.good, sum.unsteady, sum.ambiguous].map(|count| share(count, sum.stretches));
            let [files, length_s, stretches, pairs] = [
                files.to_string(),
                if length_s.is_finite() {
                    length_s.to_string()
                } else {
                    "whole".into()
                },
                sum.stretches.to_string(),
                sum.pairs.to_string(),
            ];
            let agree = share(sum.agree, sum.pairs);
            table.row(&[
                kind.clone(),
                files,
                length_s,
                stretches,
                good,
                unsteady,
                ambiguous,
                pairs,
                agree,
            ]);
        }
    }
    output::line(&table.end())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;
    use std::f64::consts::TAU;
    use std::fmt::Write;

    /// A steady tone, and one that is faster in its second half: neighbours agree but at the step.
    #[test]
    fn neighbours_agree_where_the_tone_is_the_same() {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, after_hz) in [("steady_1.csv", 5.0), ("sub/step_1.csv", 6.0)] {
            let mut draw = Draw::new(3);
            let mut text = String::from("time_s,a,b,c,d\n");
            for n in 0..800 {
                let turns = if n < 400 {
                    0.05 * f64::from(n)
                } else {
                    0.01 * after_hz * f64::from(n)
                };
                let mut value =
                    |c: i32| 1e3 * ((TAU * turns + f64::from(c)).cos() + 0.05 * draw.normal());
                let [a, b, c, d] = [0, 1, 2, 3].map(&mut value);
                writeln!(text, "{},{a},{b},{c},{d}", f64::from(n) / 100.0).expect("written");
            }
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, text).expect("written");
        }
        let files = files(folder.path()).expect("files");
        let kinds: Vec<_> = files.iter().map(|path| kind(path, folder.path())).collect();
        assert_eq!(kinds, ["steady", "sub/step"]);
        let [steady, step] = [&files[0], &files[1]].map(|path| counts(path).expect("counts"));
        assert_eq!(
            (
                steady[1].stretches,
                steady[1].good,
                steady[1].pairs,
                steady[1].agree
            ),
            (3, 3, 2, 2),
            "{steady:?}"
        );
        assert_eq!((step[0].good, step[0].pairs), (7, 6), "{step:?}");
        assert!(
            steady[0].agree >= 5 && step[0].agree < steady[0].agree,
            "{steady:?} {step:?}"
        );
    }

    #[test]
    fn a_pair_is_two_good_neighbours() {
        let (good, ambiguous) = (
            (Status::Good, Some((5.0, 0.1))),
            (Status::Ambiguous, Some((5.0, 0.1))),
        );
        let far = (Status::Good, Some((5.3, 0.1)));
        let counts = Counts::of(&[good, ambiguous, good, good, far, (Status::NoTone, None)]);
        // 0.3 is more than 1.96 x 0.1414.
        let expected = Counts {
            stretches: 6,
            good: 4,
            unsteady: 0,
            ambiguous: 1,
            pairs: 2,
            agree: 1,
        };
        assert_eq!(counts, expected);
    }
}
