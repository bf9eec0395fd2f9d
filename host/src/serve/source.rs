//! Fingers and their sources on the command line: `left=/dev/ttyUSB0`.

use crate::emulator::Firmware;
use crate::feed::{Emulation, Feed, Pace, emulated};
use crate::port::{Link, System, Wanted};
use crate::recording::{Recorded, is_telemetry};
use crate::usage::UsageError;
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};

#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    Port(String),
    /// An emulated board with this scene, or with the first one.
    Emulated(Option<PathBuf>),
    /// A file of telemetry, played in real time as if it were live.
    Recording(PathBuf),
}

impl Source {
    /// Parses `emulated`, `emulated:SCENE.toml`, the name of a telemetry file, or a port's name.
    pub fn of(text: &str) -> Result<Self> {
        Ok(match text {
            "" => {
                return Err(usage(
                    "no source after =: write a port, emulated or a recording",
                ));
            }
            "emulated" => Self::Emulated(None),
            _ if text.starts_with("emulated:") => {
                Self::Emulated(Some(text["emulated:".len()..].into()))
            }
            _ if text.contains("://") => {
                return Err(usage(&format!(
                    "{text}: an address is no source: write a port, emulated or a recording"
                )));
            }
            _ if std::fs::metadata(text).is_ok_and(|found| found.is_file()) => {
                if !is_telemetry(text.as_ref())? {
                    return Err(usage(&format!(
                        "{text}: holds no telemetry as `record` writes it"
                    )));
                }
                Self::Recording(text.into())
            }
            // A port may appear later, but a mistyped file name never becomes valid.
            _ if Path::new(text)
                .extension()
                .is_some_and(|ending| ending == "rec") =>
            {
                return Err(usage(&format!("{text}: there is no such recording")));
            }
            _ => Self::Port(text.to_owned()),
        })
    }

    /// Opens the source. An emulated board runs in real time and is touched repeatedly.
    pub fn open(&self, firmware: Option<&Firmware>) -> Result<Feed> {
        Ok(match self {
            Self::Recording(path) => Feed::new(Recorded::open(path)?).paced(Pace::new(1.0)),
            Self::Port(name) => {
                Feed::new(Link::open(System, Wanted::new(Some(name.clone()), None))?)
            }
            Self::Emulated(scene) => {
                let firmware = firmware.context("no firmware image to emulate")?.clone();
                let how = Emulation {
                    firmware,
                    pace: Some(1.0),
                    repeats: true,
                };
                emulated(scene.as_deref(), how)?
            }
        })
    }
}

/// Checks that a name is valid in topics: letters, digits, `_` and `-`.
pub fn check(name: &str) -> Result<()> {
    let is_fit = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.is_empty() || !name.chars().all(is_fit) {
        return Err(usage(&format!(
            "{name:?} is no name in a topic: use letters, digits, _ and -"
        )));
    }
    Ok(())
}

/// Parses fingers as `NAME=SOURCE`; a name must not repeat.
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
        ];
        let (names, sources) = fingers(&given.map(str::to_owned)).unwrap();
        assert_eq!(names, ["a", "b", "c"]);
        let expected = [
            Source::Port("/dev/ttyUSB0".into()),
            Source::Emulated(None),
            Source::Emulated(Some("hal-mock/scenes/c7.toml".into())),
        ];
        assert_eq!(sources, expected);
        let of_table = format!("a={table}");
        for (given, why) in [
            (&["a=x", "a=y"][..], "two fingers are named a"),
            (&["a/b=x"], "\"a/b\" is no name"),
            (&["=x"], "no name"),
            (&["a="], "no source"),
            (&["a"], "NAME=SOURCE"),
            (&["a=ftp://x"], "ftp://x"),
            (
                &["a=http://127.0.0.1:8321"],
                "a port, emulated or a recording",
            ),
            (&[&of_table], "holds no telemetry"),
            (&["a=mistyped.rec"], "no such recording"),
        ] {
            let given: Vec<String> = given.iter().map(|text| (*text).to_owned()).collect();
            let error = fingers(&given).unwrap_err();
            assert!(error.is::<UsageError>(), "{error}");
            assert!(error.to_string().contains(why), "{error}");
        }
    }
}
