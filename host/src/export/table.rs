//! Tables as CSV.

use super::packets::packets;
use crate::digits::seconds;
use crate::live::{Counts, Frame, Point};
use anyhow::{Result, bail};
use clap::ValueEnum;
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Event, Health, Raw};
use serde::Serialize;
use std::io::Write;
use std::path::Path;

/// Rows of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// A row for each estimate; unknown values are empty.
    Estimates,
    /// A row for each raw frame, in volts: as `replay`, `fit` and `emulate` read it.
    Frames,
    /// A row for each second: counters and readings.
    Health,
}

/// A row of health: the time, and fields under their names.
macro_rules! health_row {
    ($($kind:ident: $($field:ident)*;)*) => {
        #[derive(Serialize)]
        struct HealthRow {
            t_s: f64,
            $($($field: $kind,)*)*
        }

        impl HealthRow {
            fn new(health: &Health) -> Self {
                Self { t_s: seconds(health.t_us), $($($field: health.$field,)*)* }
            }
        }
    };
}

health_row! {
    u32: frames conversions_lost conversions_doubtful hops_skipped messages_dropped chip_restarts requests_damaged
        bytes_overrun stack_used_bytes;
    f32: frame_rate_hz load supply_v reference_v temperature_c offset_v gain;
}

pub fn write(path: &Path, kind: Kind, out: &mut dyn Write) -> Result<Counts> {
    let mut csv = csv::Writer::from_writer(out);
    let mut rows = 0u64;
    let counts = match kind {
        Kind::Frames => frames(path, &mut csv, &mut rows)?,
        Kind::Estimates => packets(path, &mut |packet| {
            let Event::Estimate(estimate) = &packet.event else { return Ok(()) };
            rows += 1;
            Ok(csv.serialize(Point::new(estimate))?)
        })?,
        Kind::Health => packets(path, &mut |packet| {
            let Event::Health(health) = packet.event else { return Ok(()) };
            rows += 1;
            Ok(csv.serialize(HealthRow::new(&health))?)
        })?,
    };
    csv.flush()?;
    if rows == 0 {
        let hint = if kind == Kind::Frames { ": record with --raw" } else { "" };
        bail!("{}: holds no {}{hint}", path.display(), format!("{kind:?}").to_lowercase());
    }
    Ok(counts)
}

/// Frames in volts. A taxel without any valid value is at 0 V; a frame that lacks any other taxel is left out, since `replay`
/// and `fit` take a gap for missing frames.
fn frames(path: &Path, csv: &mut csv::Writer<&mut dyn Write>, rows: &mut u64) -> Result<Counts> {
    let mut alive = 0u16;
    packets(path, &mut |packet| {
        if let Event::Raw(Raw { present, good, .. }) = packet.event {
            alive |= present & good;
        }
        Ok(())
    })?;
    if alive == 0 {
        return Ok(Counts::default());
    }
    let names = (0..TAXELS).map(|taxel| format!("ain{taxel}"));
    csv.write_record(std::iter::once("time_s".to_owned()).chain(names))?;
    let (mut vref_v, mut left_out) = (Settings::DEFAULT.vref_v, 0u64);
    let counts = packets(path, &mut |packet| {
        let raw = match &packet.event {
            Event::Hello(hello) => {
                vref_v = hello.settings.vref_v;
                return Ok(());
            }
            Event::Raw(raw) => raw,
            _ => return Ok(()),
        };
        if raw.present & raw.good & alive != alive {
            left_out += 1;
            return Ok(());
        }
        *rows += 1;
        let frame = Frame::new(raw, vref_v);
        let volts = frame.volts.iter().map(|volts| volts.unwrap_or(0.0).to_string());
        Ok(csv.write_record(std::iter::once(format!("{:.6}", frame.t_s)).chain(volts))?)
    })?;
    if left_out > 0 {
        eprintln!("ridgetone: {left_out} frames lack a taxel and are left out");
    }
    Ok(counts)
}
