//! `scene`: a scene as a CSV trace.

use super::input::SceneOptions;
use crate::input::{SCENE_MAX_S, SLOT_S, check_length, frame_rate_hz};
use crate::note;
use crate::output;
use anyhow::Result;
use clap::Args;
use hal_mock::{SlidingScene, Truth, write_csv};
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  ridgetone scene --scene-speed 15 --period 2.6 -o trace.csv
  ridgetone scene --scene hal-mock/scenes/hand.toml -o hand.csv")]
pub struct SceneArgs {
    #[command(flatten)]
    scene: SceneOptions,
    /// File to write: time_s and 16 columns of volts, read one after the other as the scan does,
    /// 241.14 times a second.
    #[arg(short, long, value_name = "FILE.csv")]
    output: PathBuf,
    /// Also the truth as one JSON object on standard output.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct TruthJson<'a> {
    r#type: &'static str,
    file: &'a str,
    rows: u64,
    rate_hz: f64,
    #[serde(flatten, with = "TruthForm")]
    truth: Truth,
}

#[derive(Serialize)]
#[serde(remote = "Truth")]
struct TruthForm {
    contact_s: f64,
    slide_start_s: f64,
    slide_end_s: f64,
    release_s: f64,
    end_s: f64,
    frequency_hz: f64,
}

impl SceneArgs {
    pub(super) fn run(self) -> Result<()> {
        let mut scene =
            SlidingScene::new(self.scene.sliding(&ridgetone_proto::plan::Plan::PAPER)?)?;
        let (truth, rate_hz, mut rows) = (scene.truth(), frame_rate_hz(), 0);
        check_length("the scene", truth.end_s, SCENE_MAX_S)?;
        output::new_file(&self.output, |file| {
            rows = write_csv(&mut scene, rate_hz, SLOT_S, file)?;
            Ok(())
        })?;
        let file = self.output.display().to_string();
        note!(
            "{file}: {rows} rows at {rate_hz:.2} Hz; contact {:.3} s, slide {:.3} to {:.3} s, release {:.3} s, end {:.3} s, tone {:.4} Hz",
            truth.contact_s,
            truth.slide_start_s,
            truth.slide_end_s,
            truth.release_s,
            truth.end_s,
            truth.frequency_hz
        );
        if self.json {
            let json = TruthJson {
                r#type: "truth",
                file: &file,
                rows,
                rate_hz,
                truth,
            };
            output::line(&serde_json::to_string(&json)?)?;
        }
        Ok(())
    }
}
