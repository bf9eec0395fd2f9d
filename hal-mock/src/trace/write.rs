//! Writes a scene as a recorded trace.

use super::TIME_COLUMN;
use crate::scene::{INPUTS, Scene};
use std::io::{self, Write};

/// Samples `scene` from 0 to its end at `scan_rate_hz` and writes one CSV row per scan: `time_s`,
/// then AIN0 to AIN15 in volts. Like a scan, a row reads one input after the other, `slot_s`
/// seconds apart, and is stamped with the time of AIN0; with 0 all are read at once. Numbers are
/// the shortest that read back to the same 64-bit value. Returns the number of rows.
///
/// # Errors
/// Errors of `writer`; [`io::ErrorKind::InvalidInput`] if the rate is not positive or the scene has
/// no end.
pub fn write_csv(
    scene: &mut dyn Scene,
    scan_rate_hz: f64,
    slot_s: f64,
    mut writer: impl Write,
) -> io::Result<u64> {
    // Subtract a millionth of a row so that the end of a trace of n rows does not round up to n +
    // 1.
    let rows = (scene.end_s() * scan_rate_hz - 1e-6).ceil();
    if !(scan_rate_hz > 0.0 && rows.is_finite()) {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "needs a positive scan rate and a scene that ends",
        ));
    }
    let names: String = (0..INPUTS).map(|input| format!(",ain{input}")).collect();
    writeln!(writer, "{TIME_COLUMN}{names}")?;
    let rows = rows as u64;
    for row in 0..rows {
        let t_s = row as f64 / scan_rate_hz;
        let volts: String = (0..INPUTS as u8)
            .map(|input| format!(",{}", scene.volts(input, t_s + f64::from(input) * slot_s)))
            .collect();
        writeln!(writer, "{t_s}{volts}")?;
    }
    writer.flush()?;
    Ok(rows)
}
