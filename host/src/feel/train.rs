//! `feel train`: coefficients of scores, by stepwise regression of what people said on what was
//! measured.

use super::coefficients::{Coefficients, NAMES};
use super::measure::{Options, RATES_DIFFER, measure};
use super::stepwise::{Criteria, Model, stepwise};
use crate::digits::{plus_minus, significant};
use crate::samples::Samples;
use anyhow::{Context, Result, bail, ensure};
use ridgetone_feel::{INDICES, PAPER_WINDOW_S, Score};
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::path::{Path, PathBuf};

/// Fewest recordings: a line through fewer has no p.
const RECORDINGS_MIN: usize = 3;

/// Scores of a file of which recording; rows of the same recording are averaged.
struct Scores {
    names: Vec<String>,
    /// Recording, its M if there is one, and its scores.
    recordings: Vec<(PathBuf, Option<f64>, Vec<f64>)>,
}

#[derive(Debug, Serialize)]
pub struct Coefficient {
    pub value: f64,
    pub sigma: f64,
    pub p: Option<f64>,
}

/// The regression of one score.
#[derive(Debug, Serialize)]
pub struct Trained {
    pub name: String,
    pub r2: f64,
    pub p: f64,
    pub sigma: f64,
    pub constant: f64,
    /// Coefficients of the variables in the model.
    pub coefficients: BTreeMap<&'static str, Coefficient>,
    /// Variables outside and why.
    pub excluded: BTreeMap<&'static str, String>,
    #[serde(skip)]
    score: Score,
}

#[derive(Debug, Serialize)]
pub struct Training {
    pub r#type: &'static str,
    pub file: String,
    pub recordings: usize,
    /// Window of the coefficients' intensities: the paper's, so that its coefficients compare.
    pub window_s: f64,
    pub scores: Vec<Trained>,
}

/// Measures all recordings of `path` and regresses every score on the intensities and on M.
pub fn train(
    path: &Path,
    options: &Options,
    criteria: Criteria,
    progress: &mut dyn FnMut(u64),
) -> Result<Training> {
    ensure!(
        criteria.enter <= criteria.remove,
        "a variable would enter below p = {} and leave again above {}: let it leave above {} or more",
        criteria.enter,
        criteria.remove,
        criteria.enter
    );
    let file = path.display().to_string();
    let scores = Scores::read(path).with_context(|| file.clone())?;
    let count = scores.recordings.len();
    ensure!(
        count >= RECORDINGS_MIN,
        "{file}: {count} recordings, at least {RECORDINGS_MIN} are needed"
    );
    let mut observed = Vec::new();
    let mut absent: [Option<String>; INDICES] = Default::default();
    let mut window_s = None;
    for (recording, m, _) in &scores.recordings {
        let felt = measure(&Samples::file(recording)?, options, progress)?;
        let same = *window_s.get_or_insert(felt.window_s);
        ensure!(
            (felt.window_s / same - 1.0).abs() < RATES_DIFFER,
            "{}: windows of {:.4} s, and of {same:.4} s in the recordings before: choose a shorter --window",
            felt.file,
            felt.window_s
        );
        let indices = felt.indices(m.map(|m| (m as f32, 0.0)));
        for (absent, value) in absent.iter_mut().zip(&indices.values) {
            if value.is_none() {
                absent.get_or_insert_with(|| format!("absent in {}", felt.file));
            }
        }
        observed.push(
            indices
                .values
                .map(|value| f64::from(value.unwrap_or(0.0)))
                .to_vec(),
        );
    }
    let used: Vec<usize> = (0..INDICES)
        .filter(|index| absent[*index].is_none())
        .collect();
    let observed: Vec<Vec<f64>> = observed
        .iter()
        .map(|row| used.iter().map(|index| row[*index]).collect())
        .collect();
    let mut trained = Vec::new();
    for (number, name) in scores.names.iter().enumerate() {
        let values: Vec<f64> = scores
            .recordings
            .iter()
            .map(|(.., values)| values[number])
            .collect();
        let Some(model) = stepwise(&observed, &values, criteria) else {
            bail!("{file}: column {name}: it is constant, or everything measured is")
        };
        trained.push(Trained::new(name, &model, &used, &absent));
    }
    Ok(Training {
        r#type: "feel_train",
        file,
        recordings: count,
        window_s: PAPER_WINDOW_S.into(),
        scores: trained,
    })
}

impl Training {
    /// Those scores that something explains.
    pub fn coefficients(&self) -> Option<Coefficients> {
        let explained = self
            .scores
            .iter()
            .filter(|score| !score.coefficients.is_empty());
        let scores: Vec<_> = explained
            .map(|trained| (trained.name.clone(), trained.score))
            .collect();
        (!scores.is_empty()).then(|| Coefficients::new(self.window_s, scores))
    }
}

impl Trained {
    fn new(name: &str, model: &Model, used: &[usize], absent: &[Option<String>; INDICES]) -> Self {
        let mut trained = Self {
            name: name.to_owned(),
            r2: model.r2,
            p: model.p,
            sigma: model.sigma,
            constant: model.constant,
            coefficients: BTreeMap::new(),
            excluded: BTreeMap::new(),
            score: Score {
                residual_sigma: model.sigma as f32,
                ..Score::exact([0.0; INDICES + 1])
            },
        };
        for (index, why) in absent.iter().enumerate() {
            trained
                .excluded
                .extend(why.clone().map(|why| (NAMES[index], why)));
        }
        // Places in the score of the constant and of the variables.
        let places: Vec<usize> = std::iter::once(0)
            .chain(used.iter().map(|index| index + 1))
            .collect();
        trained.score.coefficients[0] = model.constant as f32;
        for (v, (variable, index)) in model.variables.iter().zip(used).enumerate() {
            match (variable.coefficient, variable.p) {
                (Some(value), p) => {
                    trained.score.coefficients[index + 1] = value as f32;
                    let sigma = model.covariance[v + 1][v + 1].sqrt();
                    trained
                        .coefficients
                        .insert(NAMES[*index], Coefficient { value, sigma, p });
                }
                (None, Some(p)) => drop(
                    trained
                        .excluded
                        .insert(NAMES[*index], format!("p = {}", significant(p, 2))),
                ),
                (None, None) => drop(
                    trained
                        .excluded
                        .insert(NAMES[*index], "explained by the others, or constant".into()),
                ),
            }
        }
        for (a, row) in model.covariance.iter().enumerate() {
            for (b, value) in row.iter().enumerate() {
                trained.score.covariance[places[a]][places[b]] = *value as f32;
            }
        }
        trained
    }
}

impl fmt::Display for Training {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for trained in &self.scores {
            let Trained {
                name,
                r2,
                p,
                sigma,
                constant,
                coefficients,
                excluded,
                ..
            } = trained;
            write!(f, "{name:<8} = {}", significant(*constant, 4))?;
            for (index, Coefficient { value, .. }) in coefficients {
                let sign = if *value < 0.0 { '-' } else { '+' };
                write!(f, " {sign} {} x {index}", significant(value.abs(), 4))?;
            }
            match coefficients.is_empty() {
                true => writeln!(f, "    nothing measured explains it")?,
                false => writeln!(
                    f,
                    "    R2 {r2:.3}, p {}, sigma {}",
                    significant(*p, 2),
                    significant(*sigma, 2)
                )?,
            }
            for (index, Coefficient { value, sigma, p }) in coefficients {
                writeln!(
                    f,
                    "  {index:<6} {}, p = {}",
                    plus_minus(*value, *sigma),
                    p.map_or("-".to_owned(), |p| significant(p, 2))
                )?;
            }
            for (index, why) in excluded {
                writeln!(f, "  {index:<6} excluded: {why}")?;
            }
        }
        write!(
            f,
            "{} recordings; intensities are those of a window of {} s",
            self.recordings, self.window_s
        )
    }
}

impl Scores {
    fn read(path: &Path) -> Result<Self> {
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_path(path)?;
        let header = reader.headers()?.clone();
        let at = |wanted: &str| header.iter().position(|name| name == wanted);
        let file_at = at("file").context("no column file: it names the recording of each row")?;
        let m_at = at("m");
        let score_at: Vec<usize> = (0..header.len())
            .filter(|at| *at != file_at && Some(*at) != m_at)
            .collect();
        ensure!(
            !score_at.is_empty(),
            "no score: name its column for example soft"
        );
        let names: Vec<String> = score_at.iter().map(|at| header[*at].to_owned()).collect();
        for (number, name) in names.iter().enumerate() {
            // It would be no table of the settings file.
            ensure!(
                name != "window_s" && !name.is_empty() && !names[..number].contains(name),
                "column {name:?}: choose another name"
            );
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let (mut recordings, mut counts) =
            (Vec::<(PathBuf, Option<f64>, Vec<f64>)>::new(), Vec::new());
        let mut known = HashMap::new();
        for record in reader.records() {
            let record = record?;
            let line = record.position().map_or(0, csv::Position::line);
            let number = |at: usize| -> Result<f64> {
                let value = record[at]
                    .parse::<f64>()
                    .ok()
                    .filter(|value| value.is_finite());
                value.with_context(|| {
                    format!(
                        "line {line}: column {}: {:?} is not a number",
                        &header[at], &record[at]
                    )
                })
            };
            let m = m_at
                .filter(|at| !record[*at].is_empty())
                .map(number)
                .transpose()?;
            let scores = score_at
                .iter()
                .map(|at| number(*at))
                .collect::<Result<Vec<_>>>()?;
            let place = *known
                .entry(record[file_at].to_owned())
                .or_insert(recordings.len());
            if place == recordings.len() {
                recordings.push((folder.join(&record[file_at]), m, vec![0.0; names.len()]));
                counts.push((0.0, 0.0));
            }
            let (_, mean_m, means) = &mut recordings[place];
            let (rows, rows_m) = &mut counts[place];
            *rows += 1.0;
            means
                .iter_mut()
                .zip(scores)
                .for_each(|(mean, score)| *mean += (score - *mean) / *rows);
            if let Some(m) = m {
                *rows_m += 1.0;
                let mean = mean_m.unwrap_or(m);
                *mean_m = Some(mean + (m - mean) / *rows_m);
            }
        }
        Ok(Self { names, recordings })
    }
}
