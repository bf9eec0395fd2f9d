//! Reads the samples of a WAV file as rows; full scale is 1.

use crate::content::Input;
use crate::tables::RowReader;
use hal_mock::FileError;
use hound::{SampleFormat, WavIntoSamples, WavReader};

enum Values {
    Whole(WavIntoSamples<Input, i32>, f64),
    Float(WavIntoSamples<Input, f32>),
}

/// Rows of a WAV file, each with one sample of every channel.
pub struct WavRows {
    file: String,
    names: Vec<String>,
    values: Values,
    rate_hz: f64,
    row: Vec<f64>,
    read: u64,
}

impl WavRows {
    /// Reads the head of a WAV file.
    pub fn new(input: Input, file: &str) -> Result<Self, FileError> {
        let reader = WavReader::new(input).map_err(|error| FileError::new(file, None, error))?;
        let spec = reader.spec();
        let values = match spec.sample_format {
            SampleFormat::Int => {
                let full = f64::from(spec.bits_per_sample - 1).exp2();
                Values::Whole(reader.into_samples(), full)
            }
            SampleFormat::Float => Values::Float(reader.into_samples()),
        };
        Ok(Self {
            file: file.to_owned(),
            names: (1..=spec.channels)
                .map(|channel| format!("channel_{channel}"))
                .collect(),
            values,
            rate_hz: spec.sample_rate.into(),
            row: Vec::new(),
            read: 0,
        })
    }

    fn next_value(&mut self) -> Option<hound::Result<f64>> {
        match &mut self.values {
            Values::Whole(samples, full) => samples
                .next()
                .map(|value| value.map(|value| f64::from(value) / *full)),
            Values::Float(samples) => samples.next().map(|value| value.map(f64::from)),
        }
    }
}

impl RowReader for WavRows {
    fn file(&self) -> &str {
        &self.file
    }

    fn names(&self) -> &[String] {
        &self.names
    }

    fn advance(&mut self) -> Result<bool, FileError> {
        self.row.clear();
        while self.row.len() < self.names.len() {
            match self.next_value() {
                Some(Ok(value)) => self.row.push(value),
                // A truncated file ends with its last complete row.
                _ if self.read > 0 => return Ok(false),
                _ => return Err(self.refuse("it holds no samples")),
            }
        }
        self.read += 1;
        Ok(true)
    }

    fn time_s(&self) -> Option<f64> {
        Some(self.read.saturating_sub(1) as f64 / self.rate_hz)
    }

    fn values(&self, values: &mut Vec<f64>) -> Result<(), FileError> {
        values.clone_from(&self.row);
        Ok(())
    }
}
