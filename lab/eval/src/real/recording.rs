//! Recordings as tables: an abscissa and channels.

use anyhow::{Context, Result};
use std::path::Path;

/// A recording, or a part of one.
#[derive(Clone, Debug)]
pub struct Recording {
    pub name: String,
    /// Time in seconds, or place in millimetres.
    pub abscissa: Vec<f64>,
    /// The values of a row after the other.
    pub values: Vec<Vec<f64>>,
}

/// What is known of a recording's frequency.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    pub hz: f64,
    /// As a share of it.
    pub tolerance: f64,
}

impl Recording {
    fn read(path: &Path, abscissa: &str) -> Result<Self> {
        let text = std::fs::read_to_string(path)?;
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let at = names
            .iter()
            .position(|name| *name == abscissa)
            .with_context(|| format!("{}: no column {abscissa}", path.display()))?;
        let is_channel = |i: &usize| *i != at && names[*i] != "time_s";
        let channels: Vec<usize> = (0..names.len()).filter(is_channel).collect();
        let mut recording = Self {
            name: path
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            abscissa: Vec::new(),
            values: Vec::new(),
        };
        for line in lines {
            let row = line
                .split(',')
                .map(str::parse)
                .collect::<Result<Vec<f64>, _>>()?;
            recording.abscissa.push(row[at]);
            recording
                .values
                .push(channels.iter().map(|i| row[*i]).collect());
        }
        Ok(recording)
    }

    pub fn rows(&self) -> usize {
        self.values.len()
    }

    pub fn channels(&self) -> usize {
        self.values.first().map_or(0, Vec::len)
    }

    /// From the first row to the last.
    pub fn length(&self) -> f64 {
        self.abscissa.last().unwrap_or(&0.0) - self.abscissa.first().unwrap_or(&0.0)
    }

    /// Some of its rows.
    pub fn stretch(&self, first: usize, rows: usize) -> Self {
        let rows = first..(first + rows).min(self.rows());
        Self {
            name: self.name.clone(),
            abscissa: self.abscissa[rows.clone()].to_vec(),
            values: self.values[rows].to_vec(),
        }
    }

    /// The rows from one place of its abscissa to another.
    fn between(&self, from: f64, to: f64) -> Self {
        let first = self.abscissa.partition_point(|x| *x < from);
        let end = self.abscissa.partition_point(|x| *x <= to);
        self.stretch(first, end - first)
    }

    pub fn every_second_channel(&self, first: usize) -> Self {
        let half = |row: &Vec<f64>| row.iter().skip(first).step_by(2).copied().collect();
        Self {
            values: self.values.iter().map(half).collect(),
            ..self.clone()
        }
    }
}

/// The recordings of a folder whose names begin with a text; none where the folder is absent.
pub fn folder(path: &Path, start: &str, abscissa: &str) -> Result<Vec<Recording>> {
    let Ok(entries) = std::fs::read_dir(path) else {
        return Ok(Vec::new());
    };
    let mut paths: Vec<_> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect();
    paths.sort();
    let is_wanted = |path: &std::path::PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with(start) && name.ends_with(".csv")
    };
    paths
        .iter()
        .filter(|path| is_wanted(path))
        .map(|path| Recording::read(path, abscissa))
        .collect()
}

/// The recordings whose frequency is known, in their steady part.
pub fn known(path: &Path) -> Result<Vec<(Recording, Known)>> {
    let mut known = Vec::new();
    for recording in folder(path, "", "time_s")? {
        let end = *recording.abscissa.last().unwrap_or(&0.0);
        let name = recording.name.clone();
        let steady = |from: f64, to: f64, hz: f64, tolerance: f64| {
            (recording.between(from, to), Known { hz, tolerance })
        };
        if let Some(speed) = name
            .split("_V")
            .nth(1)
            .and_then(|speed| speed.parse::<f64>().ok())
        {
            let start = if speed == 20.0 { 0.785 } else { 15.7 / speed };
            let stop = if speed == 20.0 { 6.785 } else { 135.7 / speed };
            known.push(steady(start, stop, speed / 20.0, 0.01));
        }
        for (trial, hz) in [
            ("mat11_01", 1.878),
            ("mat11_05", 1.867),
            ("mat11_10", 1.863),
        ] {
            if name.ends_with(trial) {
                known.push(steady(0.3, end - 0.01, hz, 0.01));
            }
        }
        if name == "gait_late" {
            known.push(steady(0.283, 7.812, 0.9303, 0.012));
        }
        if name == "enso" {
            known.push(steady(0.0, end, 1.0 / 12.0, 0.01));
        }
    }
    Ok(known)
}
