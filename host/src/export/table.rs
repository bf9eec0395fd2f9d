//! Tables as CSV.

use super::packets::packets;
use crate::digits::seconds;
use crate::feel::event::{ratings, receptors};
use crate::live::{Counts, Point};
use crate::messages::{Form, messages};
use crate::raw_rows::{self, RawRows};
use crate::texture::overtones;
use anyhow::{Result, bail};
use clap::ValueEnum;
use hal_mock::RowReader;
use ridgetone_proto::telemetry::{Event, Feel, Health, Measured, Texture};
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
    /// A row for each event `feel`: what receptors would fire, and scores; unknown values are
    /// empty.
    Feel,
    /// A row for each event `texture`: what is under the finger; unknown values, and the name of a
    /// plan without one, are empty.
    Texture,
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

#[derive(Serialize)]
struct TextureRow {
    t_s: f64,
    plan: Option<&'static str>,
    period_mm: f32,
    period_sigma_mm: f32,
    power_v2: f32,
    power_sigma_v2: f32,
    amplitude_2: f32,
    phase_2_cycles: f32,
    amplitude_3: f32,
    phase_3_cycles: f32,
    amplitude_4: f32,
    phase_4_cycles: f32,
    level_v: Option<f32>,
}

impl TextureRow {
    fn new(texture: &Texture) -> Self {
        let Texture {
            t_us,
            plan,
            period_mm,
            period_sigma_mm,
            power_v2,
            power_sigma_v2,
            level_v,
            ..
        } = *texture;
        let [second, third, fourth] = overtones(&texture.overtones);
        Self {
            t_s: seconds(t_us),
            plan: plan.name(),
            period_mm,
            period_sigma_mm,
            power_v2,
            power_sigma_v2,
            amplitude_2: second.amplitude,
            phase_2_cycles: second.phase_cycles,
            amplitude_3: third.amplitude,
            phase_3_cycles: third.phase_cycles,
            amplitude_4: fourth.amplitude,
            phase_4_cycles: fourth.phase_cycles,
            level_v,
        }
    }
}

pub fn write(path: &Path, kind: Kind, out: &mut dyn Write) -> Result<Counts> {
    let mut csv = csv::Writer::from_writer(out);
    let mut rows = 0u64;
    let counts = match kind {
        Kind::Frames => frames(path, &mut csv, &mut rows)?,
        Kind::Estimates => packets(path, &mut |packet, _| {
            let Event::Estimate(estimate) = &packet.event else {
                return Ok(());
            };
            rows += 1;
            Ok(csv.serialize(Point::new(estimate))?)
        })?,
        Kind::Health => packets(path, &mut |packet, _| {
            let Event::Health(health) = packet.event else {
                return Ok(());
            };
            rows += 1;
            Ok(csv.serialize(HealthRow::new(&health))?)
        })?,
        Kind::Feel => packets(path, &mut |packet, _| {
            let Event::Feel(feel) = &packet.event else {
                return Ok(());
            };
            let (names, values): (Vec<_>, Vec<_>) = feel_row(feel).into_iter().unzip();
            if rows == 0 {
                csv.write_record(names)?;
            }
            rows += 1;
            Ok(csv.write_record(values)?)
        })?,
        Kind::Texture => packets(path, &mut |packet, _| {
            let Event::Texture(texture) = &packet.event else {
                return Ok(());
            };
            rows += 1;
            Ok(csv.serialize(TextureRow::new(texture))?)
        })?,
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

/// Names and values of an event.
fn feel_row(feel: &Feel) -> Vec<(String, String)> {
    let number = |found: Option<f32>| found.map_or(String::new(), |found| found.to_string());
    let measured = |name: String, found: Option<Measured>| {
        let sigma = (
            format!("{name}_sigma"),
            number(found.map(|found| found.sigma)),
        );
        [(name, number(found.map(|found| found.value))), sigma]
    };
    let mut row = vec![
        ("t_s".to_owned(), seconds(feel.t_us).to_string()),
        ("window_s".to_owned(), number(Some(feel.window_s))),
        ("rate_hz".to_owned(), number(Some(feel.rate_hz))),
    ];
    row.extend(measured("m".to_owned(), feel.force_ratio));
    row.extend(
        receptors(feel)
            .into_iter()
            .flat_map(|found| measured(format!("{}_per_hz", found.key), found.found)),
    );
    row.extend(
        ratings(feel)
            .into_iter()
            .flat_map(|found| measured(found.key.to_owned(), found.found)),
    );
    row
}

/// Frames in volts, as `replay` and `fit` read them from the recording itself.
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
        eprintln!(
            "ridgetone: {} frames lack a taxel and are left out",
            frames.left_out
        );
    }
    Ok(counts)
}
