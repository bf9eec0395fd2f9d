//! What the command line names: `left=/dev/ttyUSB0`.

use crate::recording::is_telemetry;
use crate::usage::UsageError;
use anyhow::Result;
use std::path::PathBuf;

/// Where a finger's messages come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    Port(String),
    /// In front of this scene, or of the first one.
    Emulated(Option<PathBuf>),
    /// Played in real time, as if it happened now.
    Recording(PathBuf),
    /// Where `ridgetone view` serves.
    Url(String),
}

impl Source {
    /// By its form: `emulated`, `emulated:SCENE.toml`, `http://HOST:PORT`, a file of telemetry,
    /// otherwise a port.
    pub fn of(text: &str) -> Result<Self> {
        Ok(match text {
            "" => {
                return Err(usage(
                    "no source behind =: a port, emulated, a recording or http://HOST:PORT",
                ));
            }
            "emulated" => Self::Emulated(None),
            _ if text.starts_with("emulated:") => {
                Self::Emulated(Some(text["emulated:".len()..].into()))
            }
            _ if text.contains("://") => {
                super::url::host(text)?;
                Self::Url(text.to_owned())
            }
            _ if std::fs::metadata(text).is_ok_and(|found| found.is_file()) => {
                if !is_telemetry(text.as_ref())? {
                    return Err(usage(&format!(
                        "{text}: holds no telemetry as `record` writes it"
                    )));
                }
                Self::Recording(text.into())
            }
            _ => Self::Port(text.to_owned()),
        })
    }
}

/// A name in topics: letters, digits, `_` and `-`.
pub fn check(name: &str) -> Result<()> {
    let is_fit = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.is_empty() || !name.chars().all(is_fit) {
        return Err(usage(&format!(
            "{name:?} is no name in a topic: use letters, digits, _ and -"
        )));
    }
    Ok(())
}

/// Fingers as `NAME=SOURCE`, each name once.
pub fn fingers(given: &[String]) -> Result<(Vec<String>, Vec<Source>)> {
    let mut names: Vec<String> = Vec::new();
    let mut sources = Vec::new();
    for text in given {
        let Some((name, source)) = text.split_once('=') else {
            return Err(usage(&format!(
                "--finger {text}: write NAME=SOURCE, such as left=/dev/ttyUSB0"
            )));
        };
        check(name)?;
        if names.iter().any(|known| known == name) {
            return Err(usage(&format!(
                "two fingers are named {name}: each needs a name of its own"
            )));
        }
        names.push(name.to_owned());
        sources.push(Source::of(source)?);
    }
    Ok((names, sources))
}

fn usage(why: &str) -> anyhow::Error {
    UsageError(why.to_owned()).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_known_by_their_form() {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join("a.csv");
        std::fs::write(&table, "time_s,a\n0,1\n").unwrap();
        let table = table.to_str().unwrap();
        let given = [
            "a=/dev/ttyUSB0",
            "b=emulated",
            "c=emulated:hal-mock/scenes/c7.toml",
            "d=http://127.0.0.1:8321",
        ];
        let (names, sources) = fingers(&given.map(str::to_owned)).unwrap();
        assert_eq!(names, ["a", "b", "c", "d"]);
        let expected = [
            Source::Port("/dev/ttyUSB0".into()),
            Source::Emulated(None),
            Source::Emulated(Some("hal-mock/scenes/c7.toml".into())),
            Source::Url("http://127.0.0.1:8321".into()),
        ];
        assert_eq!(sources, expected);
        let refused = |given: &[&str]| {
            let error = fingers(
                &given
                    .iter()
                    .map(|text| (*text).to_owned())
                    .collect::<Vec<_>>(),
            )
            .unwrap_err();
            assert!(error.is::<UsageError>(), "{error}");
            error.to_string()
        };
        assert!(refused(&["a=x", "a=y"]).contains("two fingers are named a"));
        assert!(refused(&["a/b=x"]).contains("\"a/b\" is no name"));
        assert!(refused(&["=x"]).contains("no name"));
        assert!(refused(&["a="]).contains("no source"));
        assert!(refused(&["a"]).contains("NAME=SOURCE"));
        assert!(refused(&["a=ftp://x"]).contains("ftp://x"));
        assert!(refused(&[&format!("a={table}")]).contains("holds no telemetry"));
    }
}
