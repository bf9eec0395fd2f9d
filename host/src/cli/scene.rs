//! The scene in front of a simulated or emulated board.

use super::parse::{number, positive};
use crate::input::{Input, rate_of};
use anyhow::Result;
use clap::Args;
use hal_mock::Sliding;
use ridgetone_proto::plan::Plan;
use std::path::Path;

/// Changes to a scene.
#[derive(Args, Clone, Debug)]
pub struct SceneOptions {
    /// Speed of the grating of the plain scene, mm/s [default: 30].
    #[arg(long, value_name = "MM_S", value_parser = positive)]
    scene_speed: Option<f64>,
    /// Spatial period of the grating of the plain scene, mm [default: 3.6].
    #[arg(long, value_name = "MM", value_parser = positive)]
    period: Option<f64>,
    /// Give the plain scene a tone without overtones, as the lean scene declares it.
    #[arg(long)]
    pure_tone: bool,
    /// Power of the tone over that of the noise in the plain scene, dB, or `none` for no noise
    /// [default: 20].
    #[arg(long, value_name = "DB", value_parser = decibel, allow_negative_numbers = true)]
    snr: Option<Decibel>,
    /// Seed of all noise, and of the channels' differences where there is no scene file [default:
    /// 1, or the file's].
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
}

/// A ratio of powers in decibels; `None` for no noise at all.
#[derive(Clone, Copy, Debug)]
struct Decibel(Option<f64>);

fn decibel(text: &str) -> Result<Decibel, String> {
    if text == "none" {
        Ok(Decibel(None))
    } else {
        number(text).map(|db| Decibel(Some(db)))
    }
}

impl SceneOptions {
    /// Returns the scene of a file, or the plain scene, for a plan.
    pub fn sliding(&self, file: Option<&Path>, plan: &Plan) -> Result<Sliding> {
        if let Some(path) = file {
            let scene = hal_mock::load_scene(path, rate_of(plan))?;
            return Ok(Sliding {
                seed: self.seed.unwrap_or(scene.seed),
                ..scene
            });
        }
        let default = Sliding::default();
        Ok(Sliding {
            speed_mm_s: self.scene_speed.unwrap_or(default.speed_mm_s),
            period_mm: self.period.unwrap_or(default.period_mm),
            overtones: if self.pure_tone {
                [0.0; 3]
            } else {
                default.overtones
            },
            snr_db: self.snr.map_or(default.snr_db, |Decibel(db)| db),
            seed: self.seed.unwrap_or(default.seed),
            ..default
        })
    }

    /// Returns the scene and the chip in front of it.
    pub fn input(&self, file: Option<&Path>, plan: &Plan) -> Result<Input> {
        Ok(Input::of(self.sliding(file, plan)?))
    }
}
