//! Reads raw telemetry frames as rows of samples, in volts.

use crate::frame::Frame;
use crate::messages::{Messages, VREF_V};
use crate::tables::RowReader;
use anyhow::{Result, ensure};
use hal_mock::FileError;
use ridgetone_proto::settings::TAXELS;

/// Rows, one for each frame. A taxel without any valid value is 0 V. A frame that lacks any other
/// taxel is skipped, because `replay` and `fit` treat a gap as missing frames.
pub struct RawRows {
    file: String,
    names: Vec<String>,
    messages: Messages,
    /// Bit k is set if taxel k has a valid value in any frame.
    alive: u16,
    vref_v: f32,
    frame: Option<Frame>,
    /// Number of frames skipped because a taxel has no value.
    pub left_out: u64,
}

pub fn names() -> Vec<String> {
    (0..TAXELS).map(|taxel| format!("ain{taxel}")).collect()
}

impl RawRows {
    /// Reads the frames of `messages`. `again` must have the same messages; a first pass over it
    /// finds the taxels that are alive. Fails if there is no valid value.
    pub fn new(file: &str, messages: Messages, again: Messages) -> Result<Self> {
        let (mut alive, mut vref_v) = (0, VREF_V);
        for message in again {
            if let Some(raw) = message?.frame(&mut vref_v)? {
                alive |= raw.present & raw.good;
            }
        }
        ensure!(
            alive != 0,
            "{file}: holds no frames of a board: record with --raw, or write other samples as CSV"
        );
        let (file, frame) = (file.to_owned(), None);
        Ok(Self {
            file,
            names: names(),
            messages,
            alive,
            vref_v: VREF_V,
            frame,
            left_out: 0,
        })
    }

    /// Moves to the next frame, whatever its time. Returns false at the end.
    pub fn next_frame(&mut self) -> Result<bool> {
        for message in self.messages.by_ref() {
            let Some(raw) = message?.frame(&mut self.vref_v)? else {
                continue;
            };
            if raw.present & raw.good & self.alive == self.alive {
                self.frame = Some(Frame::new(&raw, self.vref_v));
                return Ok(true);
            }
            self.left_out += 1;
        }
        Ok(false)
    }
}

impl RowReader for RawRows {
    fn file(&self) -> &str {
        &self.file
    }

    fn names(&self) -> &[String] {
        &self.names
    }

    fn advance(&mut self) -> Result<bool, FileError> {
        let before_s = self.time_s();
        let has_row = self
            .next_frame()
            .map_err(|error| FileError::new(&self.file, None, format!("{error:#}")))?;
        match (before_s, self.time_s()) {
            (Some(before_s), Some(t_s)) if has_row && t_s <= before_s => {
                let why = format!(
                    "the board restarted: time {t_s} after {before_s}; choose a part with --to {before_s}"
                );
                Err(FileError::new(&self.file, None, why))
            }
            _ => Ok(has_row),
        }
    }

    fn time_s(&self) -> Option<f64> {
        self.frame.map(|frame| frame.t_s)
    }

    fn values(&self, values: &mut Vec<f64>) -> Result<(), FileError> {
        values.clear();
        let volts = self.frame.map_or([None; TAXELS], |frame| frame.volts);
        // Convert to text and back, so that values equal those of an exported table bit for bit.
        values.extend(
            volts.map(|volts| volts.unwrap_or(0.0).to_string().parse().unwrap_or(f64::NAN)),
        );
        Ok(())
    }
}
