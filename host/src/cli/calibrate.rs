//! `calibrate`: the array's constants from gratings of known period.

use super::parse::positive;
use super::settings::plan;
use crate::calibrate::{self, Grating, Measuring, Source};
use crate::frames::{Frames, Reading};
use crate::input::{Input, rate_of};
use crate::output;
use crate::samples::Samples;
use crate::static_image::UNIT_PITCH_MM;
use anyhow::Result;
use clap::Args;
use ridgetone_proto::plan::Plan;
use std::path::PathBuf;

#[derive(Args, Debug)]
#[command(after_help = "\
The units have to be under the same contact as later: the ends of the contact change the phases, by an amount that depends
on its length, and so on the force. Use gratings from one pitch to 1.75, slid for two seconds or more, at any speed and
in either direction. One grating gives the edge phase at the nominal pitch, and a greater uncertainty; three and more give
the pitch, too.

Examples:
  ridgetone calibrate 3=b.rec --speed 15
  ridgetone calibrate 2.5=a.rec 3=b.rec 3.5=c.rec 4=d.rec")]
pub struct CalibrateArgs {
    /// Spatial period in mm and recording of a grating: telemetry with raw frames, a table of volts,
    /// or a scene file.
    #[arg(value_name = "MM=FILE", required = true, value_parser = grating)]
    files: Vec<(f64, PathBuf)>,
    /// Pitch of the units themselves, mm.
    #[arg(long, value_name = "MM", default_value_t = UNIT_PITCH_MM as f32)]
    nominal: f32,
    /// Speed of the gratings, mm/s: a recording whose tone does not match it is refused.
    #[arg(long, value_name = "MM/S", value_parser = positive)]
    speed: Option<f64>,
    /// Scan plan for scene files: paper, hand, texture or vibration [default: paper].
    #[arg(long, value_name = "NAME", value_parser = plan)]
    plan: Option<Plan>,
    /// Measure windows of any status, not only good ones.
    #[arg(long)]
    accept: bool,
    /// One JSON object on one line instead of text.
    #[arg(long)]
    json: bool,
}

fn grating(text: &str) -> Result<(f64, PathBuf), String> {
    let (period, file) = text
        .split_once('=')
        .ok_or("write MM=FILE, such as 2.5=a.csv")?;
    Ok((positive(period)?, file.into()))
}

impl CalibrateArgs {
    pub(super) fn run(self) -> Result<()> {
        let plan = self.plan.unwrap_or(Plan::PAPER);
        let open = |(period_mm, path): &(f64, PathBuf)| {
            let is_scene = path
                .extension()
                .is_some_and(|extension| extension == "toml");
            let source = match is_scene {
                true => Source::Scene(Box::new(Input {
                    scene: hal_mock::load_scene(path, rate_of(&plan))?,
                    ..Input::default()
                })),
                false => {
                    Source::Recording(Frames::open(&Samples::file(path)?, Reading::default())?)
                }
            };
            Ok(Grating {
                name: path.display().to_string(),
                period_mm: *period_mm,
                source,
            })
        };
        let gratings = self.files.iter().map(open).collect::<Result<_>>()?;
        let how = Measuring {
            pitch_mm: self.nominal,
            speed_mm_s: self.speed,
            plan,
            accepts_any: self.accept,
        };
        let found = calibrate::run(gratings, how)?;
        let text = if self.json {
            serde_json::to_string(&found)?
        } else {
            found.to_string()
        };
        output::line(text.trim_end())
    }
}
