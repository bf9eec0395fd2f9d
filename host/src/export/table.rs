//! Tables as CSV.

use super::packets::packets;
use crate::events::{rows, serializable};
use crate::live::Counts;
use crate::messages::{Form, messages};
use crate::note;
use crate::raw_rows::{self, RawRows};
use crate::tables::RowReader;
use anyhow::{Result, bail};
use clap::ValueEnum;
use std::io::Write;
use std::path::Path;

/// Rows of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// A row for each estimate; unknown values are empty.
    Estimates,
    /// A row for each event `track`: short fits of windows in fast succession.
    Tracks,
    /// A row for each raw frame, in volts, for `fit` and `replay`.
    Frames,
    /// A row for each second: counters and readings.
    Health,
    /// A row for each event `texture`: what is under the finger; unknown values are empty.
    Texture,
}

impl Kind {
    /// Returns the type of the messages that become rows; raw frames are written by [`frames`].
    const fn of_messages(self) -> &'static str {
        match self {
            Self::Estimates => "estimate",
            Self::Tracks => "track",
            Self::Frames => "raw",
            Self::Health => "health",
            Self::Texture => "texture",
        }
    }
}

pub fn write(path: &Path, kind: Kind, out: &mut dyn Write) -> Result<Counts> {
    let mut csv = csv::Writer::from_writer(out);
    let mut rows = 0u64;
    let counts = match kind {
        Kind::Frames => frames(path, &mut csv, &mut rows)?,
        _ => values(path, kind.of_messages(), &mut csv, &mut rows)?,
    };
    csv.flush()?;
    if rows == 0 {
        bail!(
            "{}: holds no {}",
            path.display(),
            format!("{kind:?}").to_lowercase()
        );
    }
    Ok(counts)
}

/// Writes the values of all messages of this `type`, by the columns of their schema.
fn values(
    path: &Path,
    kind: &str,
    csv: &mut csv::Writer<&mut dyn Write>,
    rows: &mut u64,
) -> Result<Counts> {
    let mut columns = Vec::new();
    packets(path, &mut |packet, _| {
        let message = serde_json::to_value(serializable(packet))?;
        if message["type"] != kind {
            return Ok(());
        }
        if *rows == 0 {
            columns = rows::columns(kind);
            csv.write_record(columns.iter().map(|column| &column.name))?;
        }
        *rows += 1;
        Ok(csv.write_record(columns.iter().map(|column| column.text(&message)))?)
    })
}

/// Writes frames in volts, as `replay` and `fit` read them from the recording itself.
fn frames(path: &Path, csv: &mut csv::Writer<&mut dyn Write>, rows: &mut u64) -> Result<Counts> {
    let counts = packets(path, &mut |_, _| Ok(()))?;
    let open = || messages(path, Form::Telemetry);
    let mut frames = RawRows::new(&path.display().to_string(), open()?, open()?)?;
    csv.write_record(std::iter::once("time_s".to_owned()).chain(raw_rows::names()))?;
    let mut values = Vec::new();
    while frames.next_frame()? {
        *rows += 1;
        frames.values(&mut values)?;
        let t_s = frames.time_s().unwrap_or_default();
        csv.write_record(
            std::iter::once(format!("{t_s:.6}")).chain(values.iter().map(f64::to_string)),
        )?;
    }
    if frames.left_out > 0 {
        note!("{} frames lack a taxel and are left out", frames.left_out);
    }
    Ok(counts)
}
