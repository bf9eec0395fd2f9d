//! Samples as 16 bits: raw, and as a WAV file (RIFF, one channel of PCM).

use super::render::RATE_HZ;
use anyhow::{Context, Result};
use std::io::Write;

/// Bytes of a sample.
const BYTES: u32 = 2;

/// Little endian; 1 is 32767.
pub fn pcm(samples: &[f32]) -> Vec<u8> {
    samples
        .iter()
        .flat_map(|y| ((y.clamp(-1.0, 1.0) * f32::from(i16::MAX)).round() as i16).to_le_bytes())
        .collect()
}

pub fn write(file: &mut dyn Write, samples: &[f32]) -> Result<()> {
    let data = pcm(samples);
    let length = u32::try_from(data.len()).context("a WAV file has at most 4 GiB")?;
    file.write_all(b"RIFF")?;
    file.write_all(&(36 + length).to_le_bytes())?;
    file.write_all(b"WAVEfmt ")?;
    file.write_all(&16u32.to_le_bytes())?;
    // PCM, one channel.
    file.write_all(&[1, 0, 1, 0])?;
    file.write_all(&RATE_HZ.to_le_bytes())?;
    file.write_all(&(RATE_HZ * BYTES).to_le_bytes())?;
    file.write_all(&[BYTES as u8, 0, 8 * BYTES as u8, 0])?;
    file.write_all(b"data")?;
    file.write_all(&length.to_le_bytes())?;
    Ok(file.write_all(&data)?)
}
