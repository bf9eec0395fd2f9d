//! The coefficients of scores, as a settings file.
//!
//! ```toml
//! window_s = 3.0 # intensities are those of such a window
//!
//! [soft]
//! constant = 5.59
//! sa1 = -0.002 # fa1, fa2, sa1, sa2, m; those left out are 0
//! ```

use anyhow::{Context, Result, ensure};
use hal_mock::short_text;
use ridgetone_feel::{INDICES, PAPER_WINDOW_S, ROUGH, SOFT, Score};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Short names of the indices, in files and in JSON.
pub const NAMES: [&str; INDICES] = ["fa1", "fa2", "sa1", "sa2", "m"];

/// How scores follow from the indices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coefficients {
    /// Window of the intensities that the coefficients belong to, seconds.
    pub window_s: f64,
    #[serde(flatten)]
    scores: BTreeMap<String, Terms>,
}

/// A score's coefficients, `sigma` of people around the line, and the covariance of the
/// coefficients, the constant first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Terms {
    constant: f64,
    #[serde(skip_serializing_if = "is_zero")]
    fa1: f64,
    #[serde(skip_serializing_if = "is_zero")]
    fa2: f64,
    #[serde(skip_serializing_if = "is_zero")]
    sa1: f64,
    #[serde(skip_serializing_if = "is_zero")]
    sa2: f64,
    #[serde(skip_serializing_if = "is_zero")]
    m: f64,
    sigma: f64,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    covariance: Vec<Vec<f64>>,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Coefficients {
    /// The paper's coefficients, equations 11 and 12.
    pub fn paper() -> Self {
        Self::new(
            PAPER_WINDOW_S.into(),
            [("soft".to_owned(), SOFT), ("rough".to_owned(), ROUGH)],
        )
    }

    /// Whether scores are on the paper's scale. Those of other coefficients are on that of the
    /// people who gave them.
    pub fn are_the_papers(&self) -> bool {
        *self == Self::paper()
    }

    pub fn new(window_s: f64, scores: impl IntoIterator<Item = (String, Score)>) -> Self {
        let terms = |score: Score| {
            // Each as short as its f32 allows.
            let short = |value: f32| value.to_string().parse().unwrap_or(f64::from(value));
            let [constant, fa1, fa2, sa1, sa2, m] = score.coefficients.map(short);
            let is_known = score.covariance.iter().flatten().any(|value| *value != 0.0);
            let covariance = score
                .covariance
                .iter()
                .filter(|_| is_known)
                .map(|row| row.map(short).to_vec())
                .collect();
            Terms {
                constant,
                fa1,
                fa2,
                sa1,
                sa2,
                m,
                sigma: short(score.residual_sigma),
                covariance,
            }
        };
        Self {
            window_s,
            scores: scores
                .into_iter()
                .map(|(name, score)| (name, terms(score)))
                .collect(),
        }
    }

    pub fn load(path: &Path) -> Result<Self> {
        let named = || path.display().to_string();
        let text = short_text(path)?;
        let found: Self = toml::from_str(&text).with_context(named)?;
        ensure!(
            found.window_s > 0.0 && found.window_s.is_finite(),
            "{}: window_s must be greater than 0",
            named()
        );
        ensure!(
            !found.scores.is_empty(),
            "{}: no score: write for example [soft]",
            named()
        );
        for (name, terms) in &found.scores {
            let Terms {
                constant,
                fa1,
                fa2,
                sa1,
                sa2,
                m,
                sigma,
                covariance,
            } = terms;
            let numbers = [constant, fa1, fa2, sa1, sa2, m, sigma]
                .into_iter()
                .chain(covariance.iter().flatten());
            let is_finite = numbers
                .into_iter()
                .all(|number| (*number as f32).is_finite());
            ensure!(
                is_finite && *sigma >= 0.0,
                "{}: [{name}]: write finite numbers, and a sigma of 0 or more",
                named()
            );
            let is_square = covariance.len() == INDICES + 1
                && covariance.iter().all(|row| row.len() == INDICES + 1);
            let order = NAMES.join(", ");
            ensure!(
                covariance.is_empty() || is_square,
                "{}: [{name}] covariance: write six rows of six: constant, {order}",
                named()
            );
        }
        Ok(found)
    }

    pub fn toml(&self) -> Result<String> {
        let head = "# Coefficients for `ridgetone feel --coefficients`. Intensities are those of a window of window_s seconds.\n";
        Ok(head.to_owned() + &toml::to_string(self)?)
    }

    /// The scores by name.
    pub fn scores(&self) -> impl Iterator<Item = (&str, Score)> {
        self.scores.iter().map(|(name, terms)| {
            let Terms {
                constant,
                fa1,
                fa2,
                sa1,
                sa2,
                m,
                sigma,
                covariance,
            } = terms;
            let coefficients = [*constant, *fa1, *fa2, *sa1, *sa2, *m].map(|value| value as f32);
            let at = |a: usize, b: usize| {
                covariance
                    .get(a)
                    .and_then(|row| row.get(b))
                    .map_or(0.0, |value| *value as f32)
            };
            let covariance = std::array::from_fn(|a| std::array::from_fn(|b| at(a, b)));
            (
                name.as_str(),
                Score {
                    coefficients,
                    covariance,
                    residual_sigma: *sigma as f32,
                },
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_book_has_the_papers_coefficients() {
        let page = include_str!("../../../docs/guide/4-recordings.md");
        let text = page
            .split("```")
            .find_map(|block| block.strip_prefix("toml\n"))
            .expect("a block of TOML");
        assert_eq!(
            toml::from_str::<Coefficients>(text).expect("coefficients"),
            Coefficients::paper()
        );
    }

    #[test]
    fn coefficients_written_and_read_are_the_same() {
        let mut covariance = [[0.0; INDICES + 1]; INDICES + 1];
        covariance[0][3] = 0.125;
        let other = Score {
            residual_sigma: 0.25,
            covariance,
            ..SOFT
        };
        let written = Coefficients::new(
            1.0,
            [("even".to_owned(), other), ("rough".to_owned(), ROUGH)],
        );
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("coefficients.toml");
        std::fs::write(&path, written.toml().expect("TOML")).expect("written");
        let read = Coefficients::load(&path).expect("read");
        assert_eq!(read, written);
        assert_eq!(
            read.scores().collect::<Vec<_>>(),
            [("even", other), ("rough", ROUGH)]
        );
        for (text, part) in [
            ("window_s = 1", "no score"),
            ("[soft]\nconstant = 1", "window_s"),
            ("window_s = 0\n[soft]", "greater than 0"),
            ("window_s = 1\n[soft]\nfa3 = 1", "fa3"),
            ("window_s = 1\n[soft]\nconstant = nan", "finite"),
            ("window_s = 1\n[soft]\nsa1 = 1e39", "finite"),
            ("window_s = 1\n[soft]\nsigma = -1", "finite"),
            ("window_s = 1\n[soft]\ncovariance = [[1.0]]", "six rows"),
        ] {
            std::fs::write(&path, text).expect("written");
            let error = format!("{:#}", Coefficients::load(&path).expect_err("refused"));
            assert!(
                error.contains("coefficients.toml") && error.contains(part),
                "{text}: {error}"
            );
        }
    }
}
